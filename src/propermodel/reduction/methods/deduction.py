"""Model order deduction: grow a simple model until it is good enough (MODA and FD-MODA), for linear models.

The simplest model has no compliance: springs between bodies are rigid, those in a sum of efforts are absent. Then one
compliance at a time comes back, always the one with which the spectral radius (the largest size of an eigenvalue)
rises least. MODA (Wilson and Stein 1995) stops before the spectral radius leaves the range of frequencies of interest;
FD-MODA (Wilson, Taylor and Eryilmaz 1995) stops when the frequency response of the outputs has converged.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, ProperModelError
from propermodel.equations.system import Row
from propermodel.modelling.model import ElementKind, Removal
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.workbench import Workbench

ENERGY_OF_INTEREST = 0.999  # share of the energy of the outputs' changes that the range of frequencies holds
CONVERGED = 0.02  # change of the frequency response with one more compliance, as a share of its size
FREQUENCIES = 60

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """A model on the way up."""

    removals: tuple[Removal, ...]
    radius: float  # largest size of an eigenvalue, 1/s
    response: ComplexArray  # (frequencies, outputs, inputs)


_Choose = Callable[[list[Grown], float], tuple[int, str]]


def by_spectral_radius(bench: Workbench) -> Curve:
    """Grow until the spectral radius would leave the range of interest."""
    return _curve(bench, "MODA, spectral radius", "Wilson and Stein 1995", _within_range)


def by_frequency_response(bench: Workbench) -> Curve:
    """Grow until one more compliance does not change the frequency response."""
    return _curve(bench, "MODA, frequency response", "Wilson, Taylor and Eryilmaz 1995", _converged)


def highest_frequency(bench: Workbench) -> float:
    """The end of the range that holds nearly all energy of the outputs' changes, rad/s."""
    run = bench.run
    even = np.linspace(run.time[0], run.time[-1], 2048)
    found = 0.0
    for path in bench.outputs:
        values = np.interp(even, run.time, run[path])
        # Without the straight line between its ends a signal has no jump where it would begin anew.
        energy = np.abs(np.fft.rfft(values - np.linspace(values[0], values[-1], len(values)))) ** 2
        energy[0] = 0.0
        share = np.cumsum(energy) / max(float(np.sum(energy)), 1e-300)
        line = int(np.searchsorted(share, ENERGY_OF_INTEREST))
        found = max(found, 2.0 * np.pi * line / float(even[-1] - even[0]))
    return found


def _curve(bench: Workbench, method: str, source: str, choose: _Choose) -> Curve:
    if bench.why_not_linear:
        return Curve(method=method, source=source, not_applied=bench.why_not_linear)
    limit = highest_frequency(bench)
    grown = _grown(bench, np.geomspace(limit / 1000.0, limit, FREQUENCIES))
    if not grown:
        return Curve(method=method, source=source, not_applied="no model without some compliance has equations")
    models = tuple(bench.measure(model.removals) for model in reversed(grown))
    number, rule = choose(grown, limit)
    return Curve(
        method=method,
        source=source,
        models=models,
        chosen=bench.measure(grown[number].removals),
        rule=rule,
        simulations=bench.simulations,
    )


def _within_range(grown: list[Grown], limit: float) -> tuple[int, str]:
    inside = [number for number, model in enumerate(grown) if model.radius <= limit]
    return max(inside, default=0), f"no eigenvalue beyond {limit:.4g} rad/s"


def _converged(grown: list[Grown], limit: float) -> tuple[int, str]:
    rule = f"one more compliance changes the response up to {limit:.4g} rad/s by at most {CONVERGED:.0%}"
    for number, (model, following) in enumerate(itertools.pairwise(grown)):
        size = np.linalg.norm(following.response, axis=0)
        change = np.linalg.norm(following.response - model.response, axis=0)
        if np.all(change <= CONVERGED * size):
            return number, rule
    return len(grown) - 1, rule


def _grown(bench: Workbench, omega: FloatArray) -> list[Grown]:
    """The models from the simplest that has equations to the full one."""
    gone = [row for row in bench.rows if _is_compliance(bench, row)]
    found: list[Grown] = []
    simplest = _looked_at(bench, gone, omega)
    if simplest is not None:
        found.append(simplest)
    while gone:
        tries = [(_looked_at(bench, [r for r in gone if r is not row], omega), row) for row in gone]
        sound: list[tuple[float, Path, Grown]] = [(m.radius, row.path, m) for m, row in tries if m is not None]
        if not sound:
            # None of them has equations yet: what keeps them from it is among those that are gone.
            gone = gone[1:]
            continue
        _, back, best = min(sound, key=_radius_and_path)
        gone = [row for row in gone if row.path != back]
        found.append(best)
    return found


def _radius_and_path(one: tuple[float, Path, Grown]) -> tuple[float, Path]:
    return one[0], one[1]


def _is_compliance(bench: Workbench, row: Row) -> bool:
    elements = bench.evidence.structure.elements
    return all(elements[path].kind is ElementKind.COMPLIANCE for path in row.elements)


def _looked_at(bench: Workbench, gone: list[Row], omega: FloatArray) -> Grown | None:
    removals = tuple(removal for row in gone for removal in bench.by_position(row))
    try:
        compiled = bench.compiled(removals)
        if any(path not in compiled.lowered.observables for path in bench.outputs):
            return None
        model = bench.linear_model(compiled)
        response = model.frequency_response(omega).values
    except ProperModelError:
        return None  # it has no equations, or none that are linear at the start: no candidate of this method
    return Grown(removals, float(np.max(np.abs(model.poles), initial=0.0)), response)
