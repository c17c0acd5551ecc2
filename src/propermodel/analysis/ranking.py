"""Rankings of activity: rows, the windows, scenarios or frequencies ranked by themselves, and what is kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from propermodel.diagnostics import Path, ReductionError, one_of
from propermodel.presentation import notebook_html


@dataclass(frozen=True, slots=True)
class ActivityRow:
    """One row of a ranking: an energy element, or the group that is declared as one.

    `activity` of several ports is that of their powers together, the integral of |sum of e f|; `ports` has the activity
    of each port (degree of freedom) alone, so that `sum_over_ports` is the sum of integrals of |e f|.
    """

    path: Path
    kind: str
    activity: float  # J
    index: float
    cumulative: float  # the share of this row and all above it
    elements: tuple[Path, ...]
    ports: tuple[tuple[Path, float], ...]  # single bonds, J
    largest_index: float = 0.0  # over the whole and all parts; the index where there are no parts
    largest_in: str = ""  # the part that has it; empty for the whole
    change_points: float | None = None  # by how much finer steps or samples change the index, percentage points

    @property
    def sum_over_ports(self) -> float:
        """The activities of all ports, each by itself, J: never less than the activity of the row."""
        return sum(activity for _, activity in self.ports)


@dataclass(frozen=True, slots=True)
class Discretisation:
    """The same with finer steps (or the coarser half of samples): by how much indices change, in percentage points."""

    comparison: str  # what was compared, in words
    largest_change_points: float  # over the whole and all parts
    largest_change_at: Path
    total_change: float  # relative change of the total activity


@dataclass(frozen=True, kw_only=True)
class RankedPart:
    """A window, a scenario or a frequency that is ranked by itself.

    In a part that is idle so little happens against the run that its indices would be noise: it keeps nothing.
    """

    name: str
    scenario: str
    window: tuple[float, float]  # s
    activities: Mapping[Path, float]  # of all rows, J
    changes: Mapping[Path, float] = field(default_factory=dict[Path, float])  # of indices, percentage points
    is_idle: bool = False

    @property
    def total(self) -> float:
        """The activity of all rows, J."""
        return sum(self.activities.values())

    def index(self, path: Path) -> float:
        """The share of a row; 0 in an idle part."""
        return 0.0 if self.is_idle else self.activities[path] / self.total

    def kept_by(self, threshold: float) -> set[Path]:
        """What the published rule keeps in this part alone."""
        return set() if self.is_idle else _kept(self.activities, threshold)


@dataclass(frozen=True, kw_only=True)
class ActivityRanking:
    """Rows sorted by their largest index, ties by path, with what the numbers depend on.

    `parts` are what was ranked by itself beside the whole: windows, scenarios, frequencies. Without parts the largest
    index is the index, so that rows are sorted by activity.
    """

    rows: tuple[ActivityRow, ...]
    total: float  # J
    window: tuple[float, float]
    scenario: str
    datums: tuple[str, ...]
    discretisation: Discretisation | None
    parts: tuple[RankedPart, ...] = ()
    notes: tuple[str, ...] = ()

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    def row(self, path: Path) -> ActivityRow:
        """The row of an element or group.

        Raises:
            ReductionError: it has none.
        """
        found = next((row for row in self.rows if row.path == path), None)
        if found is None:
            raise ReductionError.of(
                "activity/unknown-row",
                f"the ranking has no row '{path}'",
                help=one_of(str(path), (str(row.path) for row in self.rows)),
            )
        return found

    def kept_by(self, threshold: float) -> tuple[ActivityRow, ...]:
        """The published rule: rows from the top until their share reaches the threshold; the row that reaches it stays.

        It is applied to the whole and to each part, and what any of them keeps is kept: a short manoeuvre in a long
        mission keeps what it needs.

        Raises:
            ReductionError: the threshold is not a share between 0 and 1.
        """
        if not 0.0 <= threshold <= 1.0:
            raise ReductionError.of(
                "reduction/threshold",
                f"the threshold is {threshold:g}, not a share between 0 and 1",
                help="write 0.99 for 99 percent",
            )
        kept = _kept({row.path: row.activity for row in self.rows}, threshold)
        for part in self.parts:
            kept |= part.kept_by(threshold)
        return tuple(row for row in self.rows if row.path in kept)

    def components(self) -> tuple[ComponentActivity, ...]:
        """The activities of components: of each, the sum over all rows inside it, most active first."""
        sums: dict[Path, list[ActivityRow]] = {}
        for row in self.rows:
            for length in range(1, len(row.path)):
                sums.setdefault(Path(row.path[:length]), []).append(row)
        found = [
            ComponentActivity(path, total := sum(row.activity for row in rows), total / self.total, len(rows))
            for path, rows in sums.items()
        ]
        return tuple(sorted(found, key=lambda c: (-c.activity, c.path)))

    def __str__(self) -> str:
        width = max((len(str(row.path)) for row in self.rows), default=4)
        head = f"{'':>3}  {'element':<{width}}  kind    activity J     index  cumulative"
        lines = [head + ("    largest" if self.parts else "")]
        for number, row in enumerate(self.rows, 1):
            lines.append(
                f"{number:>3}  {row.path!s:<{width}}  {row.kind:<4} {row.activity:>13.5g}  {row.index:>8.3%}  "
                f"{row.cumulative:>9.3%}"
                + (f"  {row.largest_index:>8.3%}  {row.largest_in}".rstrip() if self.parts else "")
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
        lines.extend(f"note: {note}" for note in self.notes)
        return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class ComponentActivity:
    """The rows inside a component, added up."""

    path: Path
    activity: float  # J
    index: float
    rows: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RowContent:
    """What a row is, before it is ranked."""

    path: Path
    kind: str
    elements: tuple[Path, ...]
    ports: tuple[tuple[Path, float], ...]


def ranked_rows(
    contents: Iterable[RowContent],
    activities: Mapping[Path, float],
    changes: Mapping[Path, float],
    parts: tuple[RankedPart, ...],
) -> tuple[ActivityRow, ...]:
    """The rows of a ranking in order.

    Args:
        contents: What each row is.
        activities: Of every row over the whole, J; at least one is not zero.
        changes: Of every index, percentage points; empty where nothing finer is known.
        parts: What is ranked by itself beside the whole.
    """
    total = sum(activities.values())
    by_path = {content.path: content for content in contents}
    largest: dict[Path, tuple[float, str]] = {}
    for path, activity in activities.items():
        found = (activity / total, "")
        for part in parts:
            # A part counts as larger where it is so by more than rounding.
            if part.index(path) > found[0] * (1.0 + 1e-12):
                found = (part.index(path), part.name)
        largest[path] = found
    rows: list[ActivityRow] = []
    cumulative = 0.0
    for path in sorted(activities, key=lambda p: (-largest[p][0], p)):
        content = by_path[path]
        cumulative += activities[path]
        rows.append(
            ActivityRow(
                path,
                content.kind,
                activities[path],
                activities[path] / total,
                cumulative / total,
                content.elements,
                content.ports,
                *largest[path],
                changes.get(path),
            )
        )
    return tuple(rows)


def index_changes(activities: Mapping[Path, float], finer: Mapping[Path, float]) -> dict[Path, float]:
    """By how much each index changes from one to the other, percentage points; an index of nothing is 0."""
    total, finer_total = sum(activities.values()) or 1.0, sum(finer.values()) or 1.0
    return {path: abs(finer[path] / finer_total - activities[path] / total) * 100.0 for path in activities}


def discretisation_of(
    comparison: str,
    changes: Mapping[Path, float],
    parts: Iterable[RankedPart],
    total_change: float,
) -> Discretisation:
    """The largest change over the whole and all parts that are not idle."""
    found = [(change, path) for path, change in changes.items()]
    found += [(change, path) for part in parts if not part.is_idle for path, change in part.changes.items()]
    change, path = max(found)
    return Discretisation(comparison, change, path, total_change)


def _kept(activities: Mapping[Path, float], threshold: float) -> set[Path]:
    total = sum(activities.values())
    kept: set[Path] = set()
    cumulative = 0.0
    for path in sorted(activities, key=lambda p: (-activities[p], p)):
        # All rows are kept for a threshold of 1, also where rounding lifts the sum early.
        if kept and cumulative / total >= threshold and (threshold < 1.0 or activities[path] == 0.0):
            break
        if threshold == 0.0:
            break
        kept.add(path)
        cumulative += activities[path]
    return kept
