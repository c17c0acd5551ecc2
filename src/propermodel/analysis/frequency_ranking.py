"""Activity from frequency responses: of linear models, without simulation (Louca 2016).

A linear model that is shaken by random inputs has efforts and flows that are jointly normal, and one that is shaken
harmonically has phasors. The mean of the absolute power follows in closed form from their covariances in both cases: a
harmonic input of amplitude a gives the same as a narrow band of random ones of variance a^2 / 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import quad

from propermodel.analysis.activity import IDLE_BELOW
from propermodel.analysis.linear_model import LinearModel
from propermodel.analysis.linearise import linearise
from propermodel.analysis.rankable import check_bonds, rows_among
from propermodel.analysis.ranking import (
    ActivityRanking,
    RankedPart,
    RowContent,
    discretisation_of,
    index_changes,
    ranked_rows,
)
from propermodel.analysis.responses import connected_states
from propermodel.analysis.spectrum import ComplexArray, roots_of
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, ReductionError
from propermodel.equations.at_places import sign_at
from propermodel.equations.system import Row
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Scenario, Variable
from propermodel.simulation.equilibrium import Equilibrium
from propermodel.simulation.observables import observable_path
from propermodel.simulation.trajectory import Trajectory

Density = Callable[[FloatArray], FloatArray] | Iterable[float] | FloatArray | float
SLOW_GROWTH = 0.1  # of the lowest frequency: what grows more slowly leaves answers steady for some periods
NEGLIGIBLE = 1e-12  # of the largest eigenvalue of a power as a quadratic form


def rank_frequencies(
    compiled: CompiledModel,
    at: Scenario | Trajectory | Equilibrium,
    omega: Iterable[float] | FloatArray,
    *,
    time: float | None = None,
    inputs: Iterable[Expr | Path | str] | None = None,
    spectrum: Mapping[Expr | Path | str, Density] | None = None,
    among: str | None = None,
    idle_below: float = IDLE_BELOW,
) -> ActivityRanking:
    """Rank the energy elements of a model by small deviations from a point, without simulation.

    The whole is the mean activity in one second under random normal inputs of a spectrum, independent of each other;
    the parts are harmonic inputs at each frequency, of the variance that the spectrum has around it. `kept_by` keeps
    what the whole or any frequency needs.

    Args:
        compiled: The model.
        at: A scenario (its start), a run (its end, or the instant `time`), or an equilibrium.
        omega: Angular frequencies, rad/s, growing.
        time: The instant of a run, s.
        inputs: As those of `linearise`; by default those of the spectrum, the scenario, or the sources.
        spectrum: How much inputs move: their one-sided power spectral densities, in the square of their unit per rad/s,
            as a function of omega, as values at omega, or as a number; by default that of white noise.
        among: In a model of true and pseudo bonds, which are ranked: `true`, or the name of a pseudo domain.
        idle_below: A frequency at which the density of power is below this share of its mean is idle where a spectrum
            is given: it keeps nothing.

    Raises:
        SimulationError: a name is unknown, the derivatives do not exist at the point, or a mode has no damping at one
            of the frequencies.
        ReductionError: frequencies do not grow from above zero, a spectrum is negative, several inputs have none, a
            mode grows within a period or two, or nothing moves.
    """
    at_omega = _frequencies(omega)
    check_bonds(compiled, among)
    chosen = list(spectrum) if inputs is None and spectrum is not None else inputs
    kept = rows_among(compiled, among)
    rows = [row for row in compiled.system.rows if row.path in kept]
    bonds = [bond for row in rows for bond in row.bonds]
    outputs = [bond / variable.value for variable in (Variable.EFFORT, Variable.FLOW) for bond in bonds]
    linear = linearise(compiled, at, time=time, inputs=chosen, outputs=outputs)
    growth = _growth(linear)
    if growth > SLOW_GROWTH * at_omega[0]:
        raise ReductionError.of(
            "activity/unstable",
            f"{linear.name} is unstable at the {linear.point.description}: a mode grows with {growth:.4g} 1/s, so that "
            "there is no steady answer",
            help="choose a stable point, or rank a run: rank_activity(run)",
        )
    response = linear.frequency_response(at_omega).values
    place = {path: index for index, path in enumerate(linear.outputs)}
    # Of each row: its bonds with the sense of their half arrows into it, and where their efforts and flows stand.
    forms = [_Form.of(compiled, row, place) for row in rows]
    density = _densities(linear, spectrum, at_omega)
    moved = response * np.sqrt(density)[:, np.newaxis, :]
    weights = _weights(at_omega)
    parts = tuple(
        _part(linear, rows, forms, moved[k : k + 1], weights[k : k + 1], float(value))
        for k, value in enumerate(at_omega)
    )
    whole = _activities(rows, forms, moved, weights)
    total = sum(whole.values())
    if not total > 0.0:
        raise ReductionError.of(
            "activity/none",
            f"nothing is active in {linear.name} at the {linear.point.description}: its inputs move no element",
            help="choose other inputs: rank_frequencies(..., inputs=[...]), or another point",
        )
    if spectrum is not None:
        floor = idle_below * total / float(np.sum(weights))
        parts = tuple(
            _idle(part) if part.total < floor * weight else part for part, weight in zip(parts, weights, strict=True)
        )
    changes: dict[Path, float] = {}
    check = None
    if len(at_omega) > 3:
        coarse = _activities(rows, forms, moved[::2], _weights(at_omega[::2]))
        changes = index_changes(whole, coarse)
        check = discretisation_of("with every second frequency", changes, (), sum(coarse.values()) / total - 1.0)
    contents = [
        RowContent(path=row.path, kind=row.kind, elements=row.elements, ports=form.ports(row, moved, weights))
        for row, form in zip(rows, forms, strict=True)
    ]
    return ActivityRanking(
        rows=ranked_rows(contents, whole, changes, parts),
        total=total,
        window=(0.0, 1.0),
        scenario=(at if isinstance(at, Scenario) else at.scenario).name,
        datums=(f"efforts and flows: deviations from the {linear.point.description}",),
        discretisation=check,
        parts=parts,
        notes=(_note(linear, at_omega), *([_slow(growth)] if growth else [])),
    )


def _note(linear: LinearModel, omega: FloatArray) -> str:
    low, high = omega[0] / (2.0 * math.pi), omega[-1] / (2.0 * math.pi)
    names = ", ".join(map(str, linear.inputs))
    return f"mean activity in one second under random {names} between {low:.4g} and {high:.4g} Hz"


def _slow(growth: float) -> str:
    return f"a mode grows with {growth:.4g} 1/s, slowly beside these frequencies: answers are those without its growth"


# -- what moves, and how much ------------------------------------------------------------------------------


def _frequencies(omega: Iterable[float] | FloatArray) -> FloatArray:
    found = np.atleast_1d(np.asarray(omega if isinstance(omega, np.ndarray) else list(omega), dtype=np.float64))
    if not found.size or not (np.isfinite(found).all() and found[0] > 0.0 and np.all(np.diff(found) > 0.0)):
        raise ReductionError.of(
            "activity/frequencies",
            "the frequencies to rank do not grow from above zero",
            help="give angular frequencies in rad/s: numpy.geomspace(0.1, 100.0, 60)",
        )
    return found


def _weights(omega: FloatArray) -> FloatArray:
    """The width around each frequency, rad/s, by the trapezoidal rule; of a single one 1."""
    if len(omega) == 1:
        return np.ones(1)
    half = 0.5 * np.diff(omega)
    return np.concatenate((half, [0.0])) + np.concatenate(([0.0], half))


def _densities(
    linear: LinearModel, spectrum: Mapping[Expr | Path | str, Density] | None, omega: FloatArray
) -> FloatArray:
    """The spectral density of every input at every frequency."""
    if spectrum is None:
        if len(linear.inputs) > 1:
            raise ReductionError.of(
                "activity/spectrum",
                f"nothing says how much each input moves: {', '.join(map(str, linear.inputs))}",
                help="give their spectra, rank_frequencies(..., spectrum={input: density}), or choose one input",
            )
        return np.ones((len(omega), len(linear.inputs)))
    found = np.zeros((len(omega), len(linear.inputs)))
    for name, given in spectrum.items():
        values = np.asarray(given(omega) if callable(given) else given, dtype=np.float64)
        if values.shape not in ((), omega.shape) or not (np.isfinite(values).all() and np.all(values >= 0.0)):
            raise ReductionError.of(
                "activity/spectrum",
                f"the spectrum of {observable_path(name)} is negative, not finite, or of another length than omega",
                help="give a positive number, one for each frequency, or a function of omega",
            )
        found[:, linear.input_index(name)] = values
    return found


def _growth(linear: LinearModel) -> float:
    """How fast the fastest growing mode grows that inputs and outputs meet, 1/s; 0 in a stable model."""
    used = connected_states(linear)
    roots = roots_of(linear.A[np.ix_(used, used)])
    growing = [
        root.value.real for root in roots if root.value.real > max(10.0 * root.uncertainty, 1e-9 * abs(root.value))
    ]
    return max(growing, default=0.0)


# -- the mean of absolute powers ---------------------------------------------------------------------------


@dataclass(frozen=True)
class _Form:
    """The power of a row as sum over its bonds of sign times effort times flow: where these stand among outputs."""

    signs: FloatArray
    efforts: list[int]
    flows: list[int]

    @classmethod
    def of(cls, compiled: CompiledModel, row: Row, place: Mapping[Path, int]) -> _Form:
        inside = set(row.elements)
        signs: list[float] = []
        for name in row.bonds:
            bond = compiled.graph.normal.bonds[name]
            owner = bond.head.owner if bond.head.owner in inside else bond.tail.owner
            signs.append(1.0 if sign_at(bond, owner) else -1.0)
        efforts, flows = (
            [place[bond / variable.value] for bond in row.bonds] for variable in (Variable.EFFORT, Variable.FLOW)
        )
        return cls(np.array(signs), efforts, flows)

    def mean(self, moved: ComplexArray, weights: FloatArray) -> float:
        """The mean absolute power, W."""
        signals = moved[:, [*self.efforts, *self.flows], :]
        covariance = np.einsum("k,kiu,kju->ij", weights, signals, signals.conj()).real
        return mean_absolute_power(covariance, self.signs)

    def ports(self, row: Row, moved: ComplexArray, weights: FloatArray) -> tuple[tuple[Path, float], ...]:
        """The mean absolute power of each bond alone."""
        alone = (_Form(np.ones(1), [e], [f]) for e, f in zip(self.efforts, self.flows, strict=True))
        return tuple((bond, form.mean(moved, weights)) for bond, form in zip(row.bonds, alone, strict=True))


def mean_absolute_power(covariance: FloatArray, signs: FloatArray) -> float:
    """The mean of |sum of sign e f| of jointly normal efforts and flows.

    A quadratic form of normal variables is a sum of squares of independent ones, weighted with the eigenvalues of
    covariance times form. Two of them, of either sign, have a mean in closed form, with c their sum and b their
    distance: 2/pi (sqrt(b^2 - c^2) + c asin(c/b)). For one effort and flow c is their covariance and b the product of
    their deviations; with phasors E and F, c = Re(E F*)/2 and b = |E F|/2, it is the mean of |c + b cos(2 w t)|.

    Args:
        covariance: Of all efforts and then all flows.
        signs: One for each effort and flow.
    """
    count = len(signs)
    # Efforts and flows may differ by many powers of ten: each is counted in its deviation.
    size = np.sqrt(np.diag(covariance))
    unit = np.where(size > 0.0, size, 1.0)
    form = np.zeros((2 * count, 2 * count))
    form[:count, count:] = form[count:, :count] = np.diag(0.5 * signs * size[:count] * size[count:])
    spread, axes = np.linalg.eigh(covariance / np.outer(unit, unit))
    root = axes * np.sqrt(np.maximum(spread, 0.0))
    found = np.asarray(np.linalg.eigvalsh(root.T @ form @ root), dtype=np.float64)
    found = found[np.abs(found) > NEGLIGIBLE * np.max(np.abs(found), initial=0.0)]
    if not found.size or np.all(found > 0.0) or np.all(found < 0.0):
        return abs(float(np.sum(found)))
    if found.size == 2:
        c, b = float(found[0] + found[1]), float(abs(found[0] - found[1]))
        return 2.0 / math.pi * (math.sqrt(max(b * b - c * c, 0.0)) + c * math.asin(max(-1.0, min(1.0, c / b))))
    return _mean_of_squares(found)


def _mean_of_squares(weights: FloatArray) -> float:
    """The mean of |sum of weight x^2|: 2/pi times the integral of (1 - Re p(t))/t^2, p the characteristic function."""
    scale = float(np.sum(np.abs(weights)))
    relative = weights / scale

    def rest(t: float) -> float:
        factors: Any = np.prod((1.0 - 2.0j * relative * t) ** -0.5)
        return (1.0 - float(factors.real)) / (t * t)

    near, far = (quad(rest, *ends, limit=200)[0] for ends in ((0.0, 1.0), (1.0, math.inf)))
    return scale * 2.0 / math.pi * (near + far)


def _activities(rows: list[Row], forms: list[_Form], moved: ComplexArray, weights: FloatArray) -> dict[Path, float]:
    return {row.path: form.mean(moved, weights) for row, form in zip(rows, forms, strict=True)}


def _part(
    linear: LinearModel, rows: list[Row], forms: list[_Form], moved: ComplexArray, weights: FloatArray, omega: float
) -> RankedPart:
    activities = _activities(rows, forms, moved, weights)
    return RankedPart(
        name=f"{omega / (2.0 * math.pi):.4g} Hz",
        scenario=linear.point.description,
        window=(0.0, 1.0),
        activities=activities,
        is_idle=not sum(activities.values()) > 0.0,
    )


def _idle(part: RankedPart) -> RankedPart:
    return replace(part, is_idle=True)
