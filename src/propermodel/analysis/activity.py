"""Activity: the integral of |effort x flow| of every energy element, ranked (Louca et al. 1997)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from propermodel.analysis.rankable import check_runs, comparison_of, rows_among
from propermodel.analysis.ranking import (
    ActivityRanking,
    RankedPart,
    RowContent,
    discretisation_of,
    index_changes,
    ranked_rows,
)
from propermodel.analysis.windows import KeptIntegrals, Window, Windows, windows_of
from propermodel.codegen.lower import DEVIATION
from propermodel.diagnostics import Path, ReductionError
from propermodel.simulation.trajectory import Trajectory

IDLE_BELOW = 1e-3


def rank_activity(
    runs: Trajectory | Sequence[Trajectory],
    *,
    refined: Trajectory | Sequence[Trajectory] | None = None,
    window: Window | None = None,
    windows: Windows | None = None,
    among: str | None = None,
    idle_below: float = IDLE_BELOW,
) -> ActivityRanking:
    """Rank the energy elements of a run, or of runs of several scenarios, by activity.

    Runs of a model that `measure_about` has made rank storage about a point.

    Several runs, and the windows of a run, are ranked each by itself as well: rows are then sorted by their largest
    index, and `kept_by` keeps what any of them needs. Activities, indices and their sums are those of all runs
    together.

    Args:
        runs: The run, or runs of one model through several scenarios.
        refined: The same at a smaller step; without it the ranking says that it is unchecked.
        window: The part of each run that is looked at, s; by default all of it.
        windows: Windows that are ranked by themselves, so that what matters for a short while is not diluted: how many
            of equal length, their length (`"10 s"`), or pairs of instants. They begin and end at instants at which
            integrals were kept, `simulate(..., integrals_every=...)`; nothing is interpolated.
        among: In a model of true and pseudo bonds, which are ranked: `true`, or the name of a pseudo domain.
        idle_below: A window whose mean power is below this share of that of its run is idle: it keeps nothing, since
            indices of almost nothing are noise.

    Raises:
        ReductionError: nothing moved, a run did not reach its end, true and pseudo bonds would be mixed, runs are of
            different models, or a window is not one, or begins or ends where integrals were not kept.
    """
    given = _as_tuple(runs)
    finer = () if refined is None else _as_tuple(refined)
    check_runs(given, finer, among)
    measured = [
        _measure(run, finer[number] if finer else None, window, windows, among, idle_below)
        for number, run in enumerate(given)
    ]
    parts = tuple(part for found in measured for part in found.windows)
    if len(measured) > 1:
        parts = tuple(part for found in measured for part in (found.whole, *found.windows))
    activities = _sum([found.whole.activities for found in measured])
    changes: dict[Path, float] = {}
    discretisation = None
    if finer:
        fine = _sum([found.finer for found in measured])
        changes = index_changes(activities, fine)
        total_change = sum(fine.values()) / sum(activities.values()) - 1.0
        discretisation = discretisation_of(comparison_of(given[0], finer[0]), changes, parts, total_change)
    spans = [found.whole.window for found in measured]
    idle = [part.name for part in parts if part.is_idle]
    return ActivityRanking(
        rows=ranked_rows(_contents(given, window, set(activities)), activities, changes, parts),
        total=sum(activities.values()),
        window=(min(w for w, _ in spans), max(w for _, w in spans)),
        scenario=", ".join(found.whole.scenario for found in measured),
        datums=datums_of(given[0]),
        discretisation=discretisation,
        parts=parts,
        notes=((f"idle, with a mean power below {idle_below:g} of that of the run: {_listed(idle)}",) if idle else ()),
    )


def _as_tuple(runs: Trajectory | Sequence[Trajectory]) -> tuple[Trajectory, ...]:
    return (runs,) if isinstance(runs, Trajectory) else tuple(runs)


# -- one run -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Measured:
    """A run as a whole and in windows, with its activities at finer steps."""

    whole: RankedPart
    windows: tuple[RankedPart, ...]
    finer: Mapping[Path, float]


def _measure(
    run: Trajectory,
    refined: Trajectory | None,
    window: Window | None,
    windows: Windows | None,
    among: str | None,
    idle_below: float,
) -> _Measured:
    span = (run.scenario.start, run.ending.time)
    if window is not None:
        (window,) = windows_of([window], *span)
    name = run.scenario.name
    kept = rows_among(run.compiled, among)
    integrals, finer = KeptIntegrals(run), None if refined is None else KeptIntegrals(refined)

    def part(part_name: str, between: Window | None, floor: float) -> tuple[RankedPart, dict[Path, float]]:
        begin, end = between or span
        activities = _among(integrals, between, kept)
        fine = {} if finer is None else _among(finer, between, kept)
        return RankedPart(
            name=part_name,
            scenario=name,
            window=(begin, end),
            activities=activities,
            changes=index_changes(activities, fine) if fine else {},
            is_idle=not sum(activities.values()) > floor * (end - begin),
        ), fine

    whole, fine = part(name, window, 0.0)
    if whole.is_idle:
        raise ReductionError.of(
            "activity/none",
            f"nothing is active in scenario '{name}': no element exchanges energy",
            help="give the scenario inputs or starts that make something move, or a later stop",
        )
    begin, end = whole.window
    floor = idle_below * whole.total / (end - begin)
    found = () if windows is None else windows_of(windows, begin, end)
    return _Measured(whole, tuple(part(f"{name}, {a:g} to {b:g} s", (a, b), floor)[0] for a, b in found), fine)


def _among(integrals: KeptIntegrals, window: Window | None, rows: set[Path]) -> dict[Path, float]:
    return {
        row.path: integrals.between(_measured_entry(integrals.run, _entry(row.path, row.bonds)), window)
        for row in integrals.run.compiled.system.rows
        if row.path in rows
    }


def _entry(row: Path, bonds: tuple[Path, ...]) -> Path:
    """What has the power of a row: a group and a field count the power of all their bonds together."""
    return row if len(bonds) > 1 else next(iter(bonds))


def _measured_entry(run: Trajectory, entry: Path) -> Path:
    """The power by which a bond or row is ranked: about the datum, where the model has one for it."""
    deviation = entry / DEVIATION
    return deviation if deviation in run.compiled.lowered.power_places else entry


# -- several runs ------------------------------------------------------------------------------------------


def _sum(found: Sequence[Mapping[Path, float]]) -> dict[Path, float]:
    return {path: sum(activities[path] for activities in found) for path in found[0]}


def _contents(runs: Sequence[Trajectory], window: Window | None, rows: set[Path]) -> list[RowContent]:
    integrals = [KeptIntegrals(run) for run in runs]
    return [
        RowContent(
            path=row.path,
            kind=row.kind,
            elements=row.elements,
            ports=tuple(
                (bond, sum(kept.between(_measured_entry(kept.run, bond), window) for kept in integrals))
                for bond in row.bonds
            ),
        )
        for row in runs[0].compiled.system.rows
        if row.path in rows
    ]


def _listed(names: Sequence[str], most: int = 5) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return "; ".join(names[:most]) + more


def datums_of(run: Trajectory) -> tuple[str, ...]:
    """What the numbers of a run count from."""
    system = run.compiled.system
    domains = [f"{d.name}: {d.datum}" for d in run.compiled.graph.domains.values() if d.datum]
    return (*domains, *([] if system.datum is None else [f"storage: measured about the {system.datum.point}"]))


def row_activities(trajectory: Trajectory) -> dict[Path, float]:
    """The activity of every row over the whole run, J."""
    rows = trajectory.compiled.system.rows
    return {row.path: trajectory.activity(_entry(row.path, row.bonds)) for row in rows}


def bond_activities(trajectory: Trajectory) -> Mapping[Path, float]:
    """The activity of every bond of the normal form over the whole run, J."""
    return {
        power.path: float(trajectory.memory.activity[i])
        for i, power in enumerate(trajectory.compiled.lowered.powers)
        if power.kind == "bond"
    }
