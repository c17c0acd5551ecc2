"""Activity: the integral of |effort x flow| of every energy element, ranked (Louca et al. 1997)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propermodel.bondgraph.pseudo import is_pseudo
from propermodel.diagnostics import Diagnostic, Path, ReductionError, one_of
from propermodel.presentation import notebook_html
from propermodel.simulation.trajectory import Trajectory

TRUE = "true"  # what true bonds are called in `rank_activity(run, among=...)`


@dataclass(frozen=True, slots=True)
class ActivityRow:
    """One row of a ranking. `cumulative` is the share of this row and all above it; `ports` are single bonds, J."""

    path: Path
    kind: str
    activity: float  # J
    index: float
    cumulative: float
    elements: tuple[Path, ...]
    ports: tuple[tuple[Path, float], ...]


@dataclass(frozen=True, slots=True)
class Discretisation:
    """The same run with finer steps: by how much indices change, in percentage points."""

    step: float
    refined_step: float
    tolerance: float
    refined_tolerance: float
    largest_change_points: float
    largest_change_at: Path
    total_change: float  # relative change of the total activity

    @property
    def comparison(self) -> str:
        """What was compared, in words."""
        if self.step == self.refined_step:
            return f"at a tolerance of {self.refined_tolerance:g} instead of {self.tolerance:g}"
        return f"at a step of {self.refined_step:g} s instead of {self.step:g} s"


@dataclass(frozen=True, kw_only=True)
class ActivityRanking:
    """Rows sorted by activity, ties by path, with what the numbers depend on."""

    rows: tuple[ActivityRow, ...]
    total: float  # J
    window: tuple[float, float]
    scenario: str
    datums: tuple[str, ...]
    discretisation: Discretisation | None

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    def row(self, path: Path) -> ActivityRow:
        """The row of an element or group."""
        return next(row for row in self.rows if row.path == path)

    def kept_by(self, threshold: float) -> tuple[ActivityRow, ...]:
        """The published rule: rows from the top until their share reaches the threshold; the row that reaches it stays.

        Raises:
            ReductionError: the threshold is not a share between 0 and 1.
        """
        if not 0.0 <= threshold <= 1.0:
            raise ReductionError.of(
                "reduction/threshold",
                f"the threshold is {threshold:g}, not a share between 0 and 1",
                help="write 0.99 for 99 percent",
            )
        kept: list[ActivityRow] = []
        share = 0.0
        for row in self.rows:
            # All rows are kept for a threshold of 1, also where rounding lifts the sum early.
            if kept and share >= threshold and (threshold < 1.0 or row.activity == 0.0):
                break
            if threshold == 0.0:
                break
            kept.append(row)
            share = row.cumulative
        return tuple(kept)

    def __str__(self) -> str:
        width = max((len(str(row.path)) for row in self.rows), default=4)
        lines = [f"{'':>3}  {'element':<{width}}  kind    activity J     index  cumulative"]
        for number, row in enumerate(self.rows, 1):
            lines.append(
                f"{number:>3}  {row.path!s:<{width}}  {row.kind:<4} {row.activity:>13.5g}  {row.index:>8.3%}  "
                f"{row.cumulative:>9.3%}"
            )
        lines.append(f"total activity {self.total:.6g} J from {self.window[0]:g} to {self.window[1]:g} s")
        if self.discretisation is None:
            lines.append("no discretisation check was made: give rank_activity a refined run")
        else:
            check = self.discretisation
            lines.append(
                f"discretisation check: {check.comparison} indices "
                f"change by at most {check.largest_change_points:.3f} points ({check.largest_change_at})"
            )
        return "\n".join(lines)


def rank_activity(
    trajectory: Trajectory,
    *,
    refined: Trajectory | None = None,
    window: tuple[float, float] | None = None,
    among: str | None = None,
) -> ActivityRanking:
    """Rank the energy elements of a run by activity.

    Args:
        trajectory: The run.
        refined: The same run at a smaller step; without it the ranking says that it is unchecked.
        window: A part of the run (taken to the instants at which integrals were kept); by default all of it.
        among: In a model of true and pseudo bonds, which are ranked: `true`, or the name of a pseudo domain.

    Raises:
        ReductionError: nothing moved, the run did not reach its end, or true and pseudo bonds would be mixed.
    """
    _check(trajectory, among)
    if refined is not None:
        _check_complete(refined, "refined run")
    kept = _rows_among(trajectory, among)
    activities = {path: activity for path, activity in row_activities(trajectory, window).items() if path in kept}
    total = sum(activities.values())
    if not total > 0.0:
        raise ReductionError.of(
            "activity/none",
            f"nothing is active in scenario '{trajectory.scenario.name}': no element exchanges energy",
            help="give the scenario inputs or starts that make something move, or a later stop",
        )
    finer = {} if refined is None else row_activities(refined, window)
    finer = {path: activity for path, activity in finer.items() if path in kept}
    discretisation = None if refined is None else _compare_steps(trajectory, refined, activities, finer)
    by_row = {row.path: row for row in trajectory.compiled.system.rows}
    rows: list[ActivityRow] = []
    cumulative = 0.0
    for path in sorted(activities, key=lambda p: (-activities[p], p)):
        row = by_row[path]
        cumulative += activities[path]
        ports = tuple((bond, bond_activity(trajectory, bond, window)) for bond in row.bonds)
        rows.append(
            ActivityRow(
                path,
                row.kind,
                activities[path],
                activities[path] / total,
                cumulative / total,
                row.elements,
                ports,
            )
        )
    domains = trajectory.compiled.graph.domains.values()
    return ActivityRanking(
        rows=tuple(rows),
        total=total,
        window=window if window is not None else (trajectory.scenario.start, trajectory.ending.time),
        scenario=trajectory.scenario.name,
        datums=tuple(f"{d.name}: {d.datum}" for d in domains if d.datum),
        discretisation=discretisation,
    )


def _rows_among(trajectory: Trajectory, among: str | None) -> set[Path]:
    """The rows that are ranked."""
    graph = trajectory.compiled.graph
    found: set[Path] = set()
    for row in trajectory.compiled.system.rows:
        bonds = [graph.normal.bonds[name] for name in row.bonds]
        kinds = {bond.domain if is_pseudo(graph, bond) else TRUE for bond in bonds}
        if among is None or kinds == {among}:
            found.add(row.path)
    return found


def _check_complete(trajectory: Trajectory, name: str) -> None:
    if not trajectory.ending.is_complete:
        raise ReductionError.of(
            "activity/incomplete",
            f"the {name} did not reach its end: {trajectory.ending.message}",
            where=str(trajectory.ending.path),
            help="rank a run that is complete: cure the failure (a smaller step?), or let the scenario stop earlier",
        )


def _check(trajectory: Trajectory, among: str | None) -> None:
    _check_complete(trajectory, "run")
    graph = trajectory.compiled.graph
    pseudo = sorted({domain.name for domain in graph.domains.values() if not domain.is_true})
    if among is not None and among not in (TRUE, *pseudo):
        raise ReductionError.of(
            "activity/unknown-domain",
            f"there are no bonds called '{among}' to rank",
            help=one_of(among, (TRUE, *pseudo)),
        )
    bonds = [graph.normal.bonds[name] for row in trajectory.compiled.system.rows for name in row.bonds]
    kinds = {bond.domain if is_pseudo(graph, bond) else TRUE: bond for bond in reversed(bonds)}
    if among is None and len(kinds) > 1:
        name, bond = next((name, bond) for name, bond in kinds.items() if name != TRUE)
        raise ReductionError(
            [
                Diagnostic(
                    "activity/pseudo-bonds",
                    "true and pseudo bonds cannot be ranked together: the product of a pseudo bond is not power",
                    where=f"{bond.name} is a pseudo bond ({name})",
                    help=f"rank them apart, rank_activity(run, among='{TRUE}') or among='{name}', "
                    "or write the pseudo domain as a true one, with entropy flow for heat",
                )
            ]
        )


def row_activities(trajectory: Trajectory, window: tuple[float, float] | None = None) -> dict[Path, float]:
    """The activity of every row, J; a group and a field count the power of all their bonds together."""
    return {
        row.path: bond_activity(trajectory, row.path if len(row.bonds) > 1 else next(iter(row.bonds)), window)
        for row in trajectory.compiled.system.rows
    }


def bond_activity(trajectory: Trajectory, entry: Path, window: tuple[float, float] | None = None) -> float:
    """The activity of a bond (or of a row of several), J."""
    if window is None:
        return trajectory.activity(entry)
    column = trajectory.kept_activity(entry)
    first, last = (int(np.argmin(np.abs(trajectory.integral_times - t))) for t in window)
    return float(column[last] - column[first])


def bond_activities(trajectory: Trajectory) -> Mapping[Path, float]:
    """The activity of every bond of the normal form over the whole run, J."""
    return {
        power.path: float(trajectory.memory.activity[i])
        for i, power in enumerate(trajectory.compiled.lowered.powers)
        if power.kind == "bond"
    }


def _compare_steps(
    trajectory: Trajectory,
    refined: Trajectory,
    activities: Mapping[Path, float],
    finer: Mapping[Path, float],
) -> Discretisation:
    total, finer_total = sum(activities.values()), sum(finer.values())
    changes = {path: abs(finer[path] / finer_total - activities[path] / total) * 100.0 for path in activities}
    worst = max(changes, key=lambda p: (changes[p], p))
    return Discretisation(
        step=trajectory.step,
        refined_step=refined.step,
        tolerance=trajectory.tolerance,
        refined_tolerance=refined.tolerance,
        largest_change_points=changes[worst],
        largest_change_at=worst,
        total_change=finer_total / total - 1.0,
    )
