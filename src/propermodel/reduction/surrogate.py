"""A linear model of a run: the equations of a model with the slopes that its laws had along the run.

The slope of a law in the element's own variables is fitted to the run (least squares over instants spread over it), so
that it stands for the whole range that was used; what else a law or a signal depends on has its mean slope. Where a
variable did not move, the slope at the point replaces the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, ReductionError
from propermodel.expressions.core import TIME, Expr
from propermodel.reduction.tableau import Entry, Law, Tableau, tableau_of
from propermodel.simulation.evaluation import Evaluation
from propermodel.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.sparse import csc_array

ComplexArray = NDArray[np.complex128]

INSTANTS = 200  # at which laws are looked at
# A variable that varies by less than this share of its size has not moved: rounding would decide the slope.
_STANDSTILL = 1e-7
_DEPENDENT = 1e-6  # singular values below this share of the largest do not decide a fit


@dataclass(frozen=True)
class Surrogate:
    """(M_0 + s M_1 + sum of exp(s T) M_T) w = 0, with the row of the law at every port of an energy element."""

    tableau: Tableau
    constant: csc_array  # M_0
    rate: csc_array  # M_1
    delayed: tuple[tuple[float, csc_array], ...]  # the period T of every controller, s, and M_T
    laws: Mapping[Path, Law]  # by bond
    misfits: Mapping[Path, float]  # of what is not nearly linear along the run: the share that is left unexplained

    def gains(self, s: complex, bonds: Sequence[Path], columns: Sequence[int]) -> ComplexArray:
        """What variables (rows) do per unit by which the laws of bonds (columns) are violated, at one s.

        Raises:
            ReductionError: the equations have no solution there.
        """
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        matrix = csc_array(self.constant + s * self.rate)
        for period, part in self.delayed:
            matrix = csc_array(matrix + np.exp(s * period) * part)
        right = np.zeros((self.tableau.size, len(bonds)), dtype=np.complex128)
        right[[self.laws[bond].row for bond in bonds], range(len(bonds))] = 1.0
        try:
            found = splu(matrix).solve(right)
        except RuntimeError as error:
            raise ReductionError.of(
                "reduction/prediction",
                f"the linear model of {self.tableau.compiled.model.name} along this run is singular, so errors "
                "cannot be predicted",
                help="predict from a run that moves more, or judge removals by simulation",
            ) from error
        return found[list(columns)]


def fit(trajectory: Trajectory, outputs: Iterable[Path]) -> Surrogate:
    """The linear model of a run whose observables were all recorded.

    Raises:
        SimulationError: an observable was not recorded.
        ReductionError: the model has no linear model along this run.
    """
    from scipy.sparse import csc_array

    tableau = tableau_of(trajectory.compiled, outputs)
    rows = np.unique(np.linspace(0, len(trajectory.time) - 1, INSTANTS).astype(int))
    seen = _values(tableau, trajectory, rows)
    entries = tableau.entries
    evaluation = Evaluation(trajectory.compiled.lowered, trajectory.memory)
    slopes = evaluation.values([entry.value for entry in entries], seen)
    means = np.median(slopes, axis=1)
    columns = np.array([seen[leaf] for leaf in tableau.columns])
    in_row: dict[int, dict[int, int]] = {}
    for number, entry in enumerate(entries):
        if not entry.is_rate and entry.period is None:
            in_row.setdefault(entry.row, {})[entry.column] = number
    for law in tableau.laws:
        _fit_law(in_row[law.row], law.own, columns, slopes, means)

    def part(is_part: Callable[[Entry], bool]) -> csc_array:
        chosen = [number for number, entry in enumerate(entries) if is_part(entry)]
        where = ([entries[k].row for k in chosen], [entries[k].column for k in chosen])
        return csc_array((means[chosen], where), shape=(tableau.size, tableau.size))

    constant = part(lambda entry: not entry.is_rate and entry.period is None)
    rate = part(lambda entry: entry.is_rate)
    periods = list(dict.fromkeys(entry.period for entry in entries if entry.period is not None))
    lengths = evaluation.values(periods, {})[:, 0]
    delayed = tuple(
        (float(length), part(lambda entry, period=period: entry.period is period))
        for period, length in zip(periods, lengths, strict=True)
    )
    wrong = [entry for entry, mean in zip(entries, means, strict=True) if not np.isfinite(mean)]
    if wrong:
        raise ReductionError.of(
            "reduction/prediction",
            f"a law of {tableau.owner(wrong[0].row)} has no finite slope along this run, so errors cannot be predicted",
            help="a root or a quotient at zero: give it a smooth transition, or judge removals by simulation",
        )
    misfits = _misfits(tableau, in_row, columns, slopes, means)
    return Surrogate(tableau, constant, rate, delayed, {law.bond: law for law in tableau.laws}, misfits)


def _values(tableau: Tableau, trajectory: Trajectory, rows: NDArray[np.int64]) -> dict[Expr, FloatArray]:
    """The values of all variables, held values and time at some of the recorded instants."""
    found: dict[Expr, FloatArray] = {TIME: trajectory.time[rows]}
    held = [leaf for leaf, _ in trajectory.compiled.graph.held]
    for leaf in (*tableau.columns, *held):
        found[leaf] = trajectory[leaf.data.path][rows]
    return found


def _fit_law(
    row: Mapping[int, int],
    own: Sequence[int],
    columns: FloatArray,
    slopes: FloatArray,
    means: FloatArray,
) -> None:
    """Replace the mean slopes of a law in its own variables by those of a straight line through the run.

    Args:
        row: The number of the coefficient of every column in the law's row.
        own: The element's own variables in the law.
        columns: The value of every column at the instants.
        slopes: The value of every coefficient at the instants.
        means: The coefficients, of which some are replaced.
    """
    bent = [column for column in own if column in row and np.ptp(slopes[row[column]]) > 0.0 and _moves(columns[column])]
    if not bent:
        return
    rest = np.zeros(columns.shape[1])
    for column, number in row.items():
        if column not in bent:
            rest += means[number] * columns[column]
    given = columns[bent] - np.mean(columns[bent], axis=1, keepdims=True)
    scale = np.linalg.norm(given, axis=1)
    basis = (given / scale[:, np.newaxis]).T
    if np.linalg.svd(basis, compute_uv=False)[-1] < _DEPENDENT:
        return
    found = np.linalg.lstsq(basis, np.mean(rest) - rest, rcond=None)[0] / scale
    for column, slope in zip(bent, found, strict=True):
        means[row[column]] = slope


def _moves(values: FloatArray) -> bool:
    return bool(np.ptp(values) > _STANDSTILL * np.max(np.abs(values)))


def _misfits(
    tableau: Tableau,
    in_row: Mapping[int, Mapping[int, int]],
    columns: FloatArray,
    slopes: FloatArray,
    means: FloatArray,
) -> dict[Path, float]:
    """What the equations whose slopes vary leave unexplained of their largest term, by the part that they belong to.

    Equations among rates are left out, as rates were not recorded.
    """
    owners = {law.row: law.element for law in tableau.laws}
    moved = columns - np.mean(columns, axis=1, keepdims=True)
    with_rates = {entry.row for entry in tableau.entries if entry.is_rate or entry.period is not None}
    found: dict[Path, float] = {}
    for row, numbers in in_row.items():
        if row in with_rates or all(np.ptp(slopes[number]) == 0.0 for number in numbers.values()):
            continue
        terms = np.array([means[number] * moved[column] for column, number in numbers.items()])
        largest = float(np.max(np.std(terms, axis=1)))
        if largest > 0.0:
            owner = owners.get(row) or tableau.owner(row)
            found[owner] = max(found.get(owner, 0.0), float(np.std(np.sum(terms, axis=0))) / largest)
    return found
