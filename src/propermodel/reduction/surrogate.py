"""Linear models of a run: the equations of a model with the slopes that its laws had at each operating point.

The slope of a law in the element's own variables is fitted to the run (least squares over instants spread over it), so
that it stands for the whole range that was used; a modulus is a mean weighted with what passes through it, and what
else a law or a signal depends on has its median slope. Where a variable did not move, the slope at the point replaces
the fit.
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
from propermodel.modelling.model import TwoPort
from propermodel.reduction.operating_points import IntArray, operating_points
from propermodel.reduction.tableau import Entry, Law, Tableau, tableau_of
from propermodel.simulation.evaluation import Evaluation
from propermodel.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.sparse import csc_array

ComplexArray = NDArray[np.complex128]

INSTANTS = 1000  # at which laws are looked at
# A variable that varies by less than this share of its size has not moved: rounding would decide the slope.
_STANDSTILL = 1e-7
MOST_VALUES = 5  # of a slope that jumps
_DEPENDENT = 1e-6  # singular values below this share of the largest do not decide a fit
_DECADES_OF_A_SHIFT = 2.0  # of s: beyond this ratio the equations are factorised anew


@dataclass(frozen=True)
class Slopes:
    """(M_0 + s M_1 + sum of exp(s T) M_T) w = 0 near one operating point."""

    constant: csc_array  # M_0
    rate: csc_array  # M_1
    delayed: tuple[tuple[float, csc_array], ...]  # the period T of every controller, s, and M_T

    def at(self, s: complex) -> csc_array:
        """The matrix at one s."""
        from scipy.sparse import csc_array

        matrix = csc_array(self.constant + s * self.rate)
        for period, part in self.delayed:
            matrix = csc_array(matrix + np.exp(s * period) * part)
        return matrix


@dataclass(frozen=True)
class Surrogate:
    """A linear model for every operating point of a run, with the row of the law at every port of an energy element."""

    tableau: Tableau
    points: tuple[Slopes, ...]
    point_at: FloatArray  # (2, instants): times, s, and the number of the operating point from then on
    laws: Mapping[Path, Law]  # by bond
    misfits: Mapping[Path, float]  # of what is not nearly linear along the run: the share that is left unexplained

    def point_of(self, time: FloatArray) -> IntArray:
        """The operating point at instants."""
        places = np.searchsorted(self.point_at[0], time, side="right") - 1
        return self.point_at[1][np.maximum(places, 0)].astype(np.int64)

    def gains(self, point: int, places: ComplexArray, bonds: Sequence[Path], columns: Sequence[int]) -> ComplexArray:
        """What variables do per unit by which the laws of bonds are violated: (places, columns, bonds).

        The equations are factorised at a few s, from which the others differ by M_1 and M_T, which have few rows
        (Woodbury's formula).

        Args:
            point: The operating point.
            places: Values of s.
            bonds: The bonds.
            columns: The variables, by their columns.

        Raises:
            ReductionError: the equations have no solution there.
        """
        found = np.empty((len(places), len(columns), len(bonds)), dtype=np.complex128)
        order = np.argsort(np.abs(places), kind="stable")
        while order.size:
            limit = np.abs(places[order[0]]) * 10.0**_DECADES_OF_A_SHIFT
            count = int(np.searchsorted(np.abs(places[order]), limit, side="right"))
            group, order = order[:count], order[count:]
            found[group] = self._gains_near(self.points[point], places[group], bonds, list(columns))
        return found

    def _gains_near(
        self, slopes: Slopes, places: ComplexArray, bonds: Sequence[Path], columns: list[int]
    ) -> ComplexArray:
        middle = complex(places[len(places) // 2])
        changing = [(np.unique(part.indices), part) for part in (slopes.rate, *(part for _, part in slopes.delayed))]
        rows = [int(row) for numbers, _ in changing for row in numbers]
        right = np.zeros((self.tableau.size, len(bonds) + len(rows)), dtype=np.complex128)
        right[[self.laws[bond].row for bond in bonds], range(len(bonds))] = 1.0
        right[rows, range(len(bonds), right.shape[1])] = 1.0
        try:
            solved = _solve(slopes.at(middle), right)
        except RuntimeError as error:
            raise ReductionError.of(
                "reduction/prediction",
                f"the linear model of {self.tableau.compiled.model.name} along this run is singular, so errors "
                "cannot be predicted",
                help="predict from a run that moves more, or judge removals by simulation",
            ) from error
        from_laws, from_rows = solved[:, : len(bonds)], solved[:, len(bonds) :]
        seen_laws = np.vstack([part[numbers] @ from_laws for numbers, part in changing])
        seen_rows = np.vstack([part[numbers] @ from_rows for numbers, part in changing])
        found = np.empty((len(places), len(columns), len(bonds)), dtype=np.complex128)
        for k, s in enumerate(places):
            factors = [s - middle, *(np.exp(s * period) - np.exp(middle * period) for period, _ in slopes.delayed)]
            by_row = np.repeat(factors, [len(numbers) for numbers, _ in changing])[:, np.newaxis]
            inner = np.linalg.solve(np.eye(len(rows)) + by_row * seen_rows, by_row * seen_laws)
            found[k] = from_laws[columns] - from_rows[columns] @ inner
        return found


def fit(trajectory: Trajectory, outputs: Iterable[Path]) -> Surrogate:
    """The linear models of a run whose observables were all recorded.

    Raises:
        SimulationError: an observable was not recorded.
        ReductionError: the model has no linear model along this run.
    """
    tableau = tableau_of(trajectory.compiled, outputs)
    rows = np.unique(np.linspace(0, len(trajectory.time) - 1, INSTANTS).astype(int))
    seen = _values(tableau, trajectory, rows)
    entries = tableau.entries
    evaluation = Evaluation(trajectory.compiled.lowered, trajectory.memory)
    slopes = evaluation.values([entry.value for entry in entries], seen)
    columns = np.array([seen[leaf] for leaf in tableau.columns])
    static = [k for k, entry in enumerate(entries) if not entry.is_rate and entry.period is None]
    # A curved law in its own variables has its straight line; what else changes a slope makes an operating point.
    own = {(law.row, column) for law in tableau.laws for column in law.own}
    static = [k for k in static if (entries[k].row, entries[k].column) not in own or _jumps(slopes[k])]
    terms = np.array([slopes[k] * columns[entries[k].column] for k in static])
    point_of = operating_points([entries[k].row for k in static], slopes[static], terms)
    periods = list(dict.fromkeys(entry.period for entry in entries if entry.period is not None))
    lengths = evaluation.values(periods, {})[:, 0]
    points: list[Slopes] = []
    misfits: dict[Path, list[FloatArray]] = {}
    for number in range(int(point_of.max()) + 1):
        there = point_of == number
        means = _means(tableau, columns[:, there], slopes[:, there])
        points.append(_assembled(tableau, means, dict(zip(periods, map(float, lengths), strict=True))))
        for path, sums in _misfits(tableau, columns[:, there], slopes[:, there], means).items():
            misfits.setdefault(path, []).append(sums)
    unexplained = {path: float(np.sqrt(np.divide(*np.sum(sums, axis=0)))) for path, sums in misfits.items()}
    laws = {law.bond: law for law in tableau.laws}
    return Surrogate(
        tableau, tuple(points), np.array([trajectory.time[rows], point_of], dtype=np.float64), laws, unexplained
    )


def _solve(matrix: csc_array, right: ComplexArray) -> ComplexArray:
    """The solution of sparse equations, whose rows and columns are scaled first: pressures stand beside volumes.

    Raises:
        RuntimeError: they are singular.
    """
    from scipy.sparse import csc_array, diags_array
    from scipy.sparse.linalg import splu

    by_row = diags_array(1.0 / abs(matrix).max(axis=1).toarray().ravel())
    scaled = by_row @ matrix
    by_column = diags_array(1.0 / abs(scaled).max(axis=0).toarray().ravel())
    return by_column @ splu(csc_array(scaled @ by_column)).solve(by_row @ right)


def _assembled(tableau: Tableau, means: FloatArray, lengths: Mapping[Expr, float]) -> Slopes:
    """The matrices of one operating point.

    Raises:
        ReductionError: a slope is not finite.
    """
    from scipy.sparse import csc_array

    entries = tableau.entries
    wrong = [entry for entry, mean in zip(entries, means, strict=True) if not np.isfinite(mean)]
    if wrong:
        raise ReductionError.of(
            "reduction/prediction",
            f"a law of {tableau.owner(wrong[0].row)} has no finite slope along this run, so errors cannot be predicted",
            help="a root or a quotient at zero: give it a smooth transition, or judge removals by simulation",
        )

    def part(is_part: Callable[[Entry], bool]) -> csc_array:
        chosen = [number for number, entry in enumerate(entries) if is_part(entry)]
        where = ([entries[k].row for k in chosen], [entries[k].column for k in chosen])
        return csc_array((means[chosen], where), shape=(tableau.size, tableau.size))

    return Slopes(
        part(lambda entry: not entry.is_rate and entry.period is None),
        part(lambda entry: entry.is_rate),
        tuple(
            (length, part(lambda entry, period=period: entry.period is period)) for period, length in lengths.items()
        ),
    )


def _in_row(tableau: Tableau) -> dict[int, dict[int, int]]:
    """For every equation the number of the coefficient of each column, rates and what is held apart."""
    found: dict[int, dict[int, int]] = {}
    for number, entry in enumerate(tableau.entries):
        if not entry.is_rate and entry.period is None:
            found.setdefault(entry.row, {})[entry.column] = number
    return found


def _means(tableau: Tableau, columns: FloatArray, slopes: FloatArray) -> FloatArray:
    """The slope that stands for every coefficient at one operating point."""
    means = np.median(slopes, axis=1)
    in_row = _in_row(tableau)
    elements = tableau.compiled.graph.normal.elements
    for row, numbers in in_row.items():
        owner = elements.get(tableau.owner(row))
        if owner is not None and isinstance(owner.behaviour, TwoPort):
            for column, number in numbers.items():
                # What passes much counts most: a pump that works now and then is one that works.
                weights = columns[column] ** 2
                if np.ptp(slopes[number]) > 0.0 and np.sum(weights) > 0.0:
                    means[number] = np.sum(slopes[number] * weights) / np.sum(weights)
    for law in tableau.laws:
        _fit_law(in_row[law.row], law.own, columns, slopes, means)
    return means


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
    if not np.any(rest):
        return  # a law that is implicit in its own variables has no scale to be fitted to
    given = columns[bent] - np.mean(columns[bent], axis=1, keepdims=True)
    scale = np.linalg.norm(given, axis=1)
    basis = (given / scale[:, np.newaxis]).T
    if np.linalg.svd(basis, compute_uv=False)[-1] < _DEPENDENT:
        return
    found = np.linalg.lstsq(basis, np.mean(rest) - rest, rcond=None)[0] / scale
    for column, slope in zip(bent, found, strict=True):
        means[row[column]] = slope


def _jumps(slope: FloatArray) -> bool:
    """Whether a slope has few values, as that of what locks or switches."""
    return len(np.unique(slope)) <= MOST_VALUES


def _moves(values: FloatArray) -> bool:
    return bool(np.ptp(values) > _STANDSTILL * np.max(np.abs(values)))


def _misfits(tableau: Tableau, columns: FloatArray, slopes: FloatArray, means: FloatArray) -> dict[Path, FloatArray]:
    """What the equations whose slopes vary leave unexplained, and their largest term, by the part they belong to.

    Both as sums of squares. Equations among rates are left out, as rates were not recorded.
    """
    owners = {law.row: law.element for law in tableau.laws}
    moved = columns - np.mean(columns, axis=1, keepdims=True)
    with_rates = {entry.row for entry in tableau.entries if entry.is_rate or entry.period is not None}
    found: dict[Path, FloatArray] = {}
    for row, numbers in _in_row(tableau).items():
        if row in with_rates or all(np.ptp(slopes[number]) == 0.0 for number in numbers.values()):
            continue
        terms = np.array([means[number] * moved[column] for column, number in numbers.items()])
        largest = float(np.max(np.var(terms, axis=1)))
        if largest > 0.0:
            owner = owners.get(row) or tableau.owner(row)
            sums = np.array([float(np.var(np.sum(terms, axis=0))), largest]) * columns.shape[1]
            if owner not in found or np.divide(*sums) > np.divide(*found[owner]):
                found[owner] = sums
    return found
