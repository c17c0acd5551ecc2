"""Activity of every bond, and of every bond among those of its junction (Rideout, Stein and Louca 2007).

A bond that is small among its peers is a term that its junction hardly feels. A junction at which no bond is active has
no flow (1) or no effort (0): what it joins does not meet there (Ersal, Fathy and Stein 2009, junction inactivity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from propermodel.analysis.activity import datums_of
from propermodel.analysis.rankable import check_runs, comparison_of, kind_of
from propermodel.analysis.windows import KeptIntegrals, Window, windows_of
from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path, ReductionError, one_of
from propermodel.simulation.trajectory import Trajectory

INACTIVE_BELOW = 1e-3
JUNCTION_BOND = "-"  # the kind of a bond that ends on no element

Row = TypeVar("Row")


@dataclass(frozen=True, slots=True)
class BondAtJunction:
    """A bond at one of its junctions: its activity over the greatest there, in the run in which that is largest."""

    junction: Path
    relative: float


@dataclass(frozen=True, slots=True)
class BondActivity:
    """The activity of one bond: of an element's port, of a source, of a side of a transformer, or between junctions.

    `share` is its activity over that of the most active bond of all. `at` holds one entry for each junction at its
    ends; without any the bond joins two elements.
    """

    path: Path
    kind: str  # of the element that it ends on, `-` between junctions
    domain: str
    tail: Path
    head: Path
    activity: float  # J
    share: float
    at: tuple[BondAtJunction, ...]
    change_points: float | None = None  # by how much finer steps change the share, percentage points

    @property
    def relative(self) -> float:
        """The largest relative activity at its junctions; 1 where it has none."""
        return max((end.relative for end in self.at), default=1.0)


@dataclass(frozen=True, slots=True)
class JunctionActivity:
    """A junction with the activity of its most active bond."""

    path: Path
    kind: str  # "0" or "1"
    activity: float  # J
    share: float  # of that of the most active bond of all
    bonds: tuple[tuple[Path, float], ...]  # with relative activity, the greatest first
    is_inactive: bool


@dataclass(frozen=True, kw_only=True)
class BondRanking:
    """Bonds sorted by activity, and junctions likewise, with what the numbers depend on."""

    rows: tuple[BondActivity, ...]
    junctions: tuple[JunctionActivity, ...]
    window: tuple[float, float]  # s
    scenario: str
    datums: tuple[str, ...]
    inactive_below: float
    comparison: str = ""  # of what with what the changes were found; empty without refined runs

    @property
    def inactive(self) -> tuple[JunctionActivity, ...]:
        """The junctions at which hardly any power flows."""
        return tuple(junction for junction in self.junctions if junction.is_inactive)

    def row(self, bond: Path) -> BondActivity:
        """The row of a bond.

        Raises:
            ReductionError: there is no such bond.
        """
        return _found(bond, {row.path: row for row in self.rows}, "bond")

    def junction(self, path: Path) -> JunctionActivity:
        """The row of a junction.

        Raises:
            ReductionError: there is no such junction.
        """
        return _found(path, {junction.path: junction for junction in self.junctions}, "junction")

    def __str__(self) -> str:
        width = max((len(str(row.path)) for row in self.rows), default=4)
        lines = [f"{'':>3}  {'bond':<{width}}  kind  activity J     share  at its junctions"]
        for number, row in enumerate(self.rows, 1):
            ends = ", ".join(f"{end.relative:.2%} at {end.junction}" for end in row.at)
            lines.append(
                f"{number:>3}  {row.path!s:<{width}}  {row.kind:<4} {row.activity:>11.5g}  {row.share:>8.3%}  {ends}"
            )
        lines.append(f"{len(self.rows)} bonds from {self.window[0]:g} to {self.window[1]:g} s")
        lines.extend(
            f"inactive: {junction.kind}-junction {junction.path}, {junction.share:.3%}" for junction in self.inactive
        )
        return "\n".join(lines)


def rank_bonds(
    runs: Trajectory | Sequence[Trajectory],
    *,
    refined: Trajectory | Sequence[Trajectory] | None = None,
    window: Window | None = None,
    among: str | None = None,
    inactive_below: float = INACTIVE_BELOW,
) -> BondRanking:
    """Rank every bond of the normal form by activity: of elements, sources and two-ports, and between junctions.

    Args:
        runs: The run, or runs of one model through several scenarios. Activities are those of all runs together;
            relative activities are the largest of any run, so that what is small is small in all of them.
        refined: The same at a smaller step: rows then say by how much it changes their share.
        window: The part of each run that is looked at, s; by default all of it. It begins and ends at instants at
            which integrals were kept, `simulate(..., integrals_every=...)`.
        among: In a model of true and pseudo bonds, which are ranked: `true`, or the name of a pseudo domain.
        inactive_below: A junction is inactive if none of its bonds has this share of the most active bond in any run.

    Raises:
        ReductionError: nothing moved, a run did not reach its end, true and pseudo bonds would be mixed, runs are of
            different models, or a window is not one, or begins or ends where integrals were not kept.
    """
    given = (runs,) if isinstance(runs, Trajectory) else tuple(runs)
    finer = () if refined is None else (refined,) if isinstance(refined, Trajectory) else tuple(refined)
    check_runs(given, finer, among)
    measured = [_measure(run, window, among) for run in given]
    total = _sum(measured)
    greatest = max(total.values(), default=0.0)
    if not greatest > 0.0:
        raise ReductionError.of(
            "activity/none",
            f"nothing is active in scenario '{given[0].scenario.name}': no bond carries power",
            help="give the scenario inputs or starts that make something move, or a later stop",
        )
    fine = _sum([_measure(run, window, among) for run in finer]) if finer else {}
    at = _at_junctions(given[0], set(total))
    rows = [
        BondActivity(
            path=bond.name,
            kind=_kind(given[0], bond),
            domain=bond.domain,
            tail=bond.tail.path,
            head=bond.head.path,
            activity=total[bond.name],
            share=total[bond.name] / greatest,
            at=tuple(
                BondAtJunction(end.owner, _relative(measured, bond.name, at[end.owner]))
                for end in (bond.tail, bond.head)
                if not end.port
            ),
            change_points=_change(bond.name, total, fine) if fine else None,
        )
        for bond in given[0].compiled.graph.normal.bonds.values()
        if bond.name in total
    ]
    junctions = [_junction(given[0], path, bonds, total, measured, inactive_below) for path, bonds in at.items()]
    begins, ends = zip(*(window or (run.scenario.start, run.ending.time) for run in given), strict=True)
    return BondRanking(
        rows=tuple(sorted(rows, key=lambda row: (-row.activity, row.path))),
        junctions=tuple(sorted(junctions, key=lambda junction: (-junction.activity, junction.path))),
        window=(min(begins), max(ends)),
        scenario=", ".join(run.scenario.name for run in given),
        datums=datums_of(given[0]),
        inactive_below=inactive_below,
        comparison=comparison_of(given[0], finer[0]) if finer else "",
    )


Activities = dict[Path, float]  # of bonds, J


def _measure(run: Trajectory, window: Window | None, among: str | None) -> Activities:
    graph, integrals = run.compiled.graph, KeptIntegrals(run)
    if window is not None:
        (window,) = windows_of([window], run.scenario.start, run.ending.time)
    return {
        bond.name: integrals.between(bond.name, window)
        for bond in graph.normal.bonds.values()
        if among in (None, kind_of(graph, bond))
    }


def _sum(measured: Sequence[Activities]) -> Activities:
    return {name: sum(activities[name] for activities in measured) for name in measured[0]}


def _change(bond: Path, total: Activities, fine: Activities) -> float:
    share, finer = total[bond] / max(total.values()), fine[bond] / (max(fine.values()) or 1.0)
    return abs(finer - share) * 100.0


def _kind(run: Trajectory, bond: Bond) -> str:
    elements = run.compiled.graph.normal.elements
    return next((elements[end.owner].kind.value for end in (bond.head, bond.tail) if end.port), JUNCTION_BOND)


def _at_junctions(run: Trajectory, ranked: set[Path]) -> dict[Path, list[Path]]:
    """The ranked bonds of each junction that has any."""
    structure = run.compiled.graph.normal
    found = {path: [bond.name for bond in structure.at()[path] if bond.name in ranked] for path in structure.junctions}
    return {path: bonds for path, bonds in found.items() if bonds}


def _relative(measured: Sequence[Activities], bond: Path, peers: Sequence[Path]) -> float:
    """The largest over the runs of the activity of a bond over the greatest of its junction."""
    found = [(activities[bond], max(activities[peer] for peer in peers)) for activities in measured]
    return max((own / greatest for own, greatest in found if greatest > 0.0), default=0.0)


def _junction(
    run: Trajectory,
    path: Path,
    bonds: Sequence[Path],
    total: Activities,
    measured: Sequence[Activities],
    inactive_below: float,
) -> JunctionActivity:
    greatest = max(total[bond] for bond in bonds)
    relative = [(bond, _relative(measured, bond, bonds)) for bond in bonds]
    return JunctionActivity(
        path=path,
        kind=run.compiled.graph.normal.junctions[path].kind.value,
        activity=greatest,
        share=greatest / max(total.values()),
        bonds=tuple(sorted(relative, key=lambda pair: (-pair[1], pair[0]))),
        is_inactive=all(max(a[bond] for bond in bonds) < inactive_below * max(a.values()) for a in measured),
    )


def _found(path: Path, rows: dict[Path, Row], what: str) -> Row:
    if path not in rows:
        raise ReductionError.of(
            "activity/unknown-row",
            f"the ranking has no {what} '{path}'",
            help=one_of(str(path), map(str, rows)),
        )
    return rows[path]
