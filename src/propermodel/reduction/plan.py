"""From a ranking to removals: what goes, what replaces it, and why; or why it must stay."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from propermodel.analysis.ranking import ActivityRanking, ActivityRow
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, ReductionError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Freeze, Removal
from propermodel.presentation import notebook_html
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.groups import Group, GroupRules, find_groups
from propermodel.reduction.judging import Judge, Rules, removals_of
from propermodel.reduction.lost_modes import ModeWatch, told
from propermodel.reduction.merges import MergedElement, merges_after
from propermodel.reduction.reading import elements_of_outputs
from propermodel.reduction.single import PRELOAD_SHARE, Proposal, Refusal, propose, propose_constant
from propermodel.reduction.singular import Twin
from propermodel.reduction.ways import Way, ways_of
from propermodel.simulation.observables import observable_path
from propermodel.simulation.trajectory import Trajectory


class Verdict(StrEnum):
    """What becomes of a row."""

    KEPT = "kept"
    REMOVED = "removed"
    REFUSED = "refused"  # below the threshold, but it has to stay


@dataclass(frozen=True, slots=True)
class Decision:
    """The verdict on one row, with the removals made for it and the reason in words and numbers.

    `meaning` says what replaces a row that goes; it is empty for one that stays. `ways` are all its replacements.
    """

    row: ActivityRow
    verdict: Verdict
    removals: tuple[Removal, ...]
    meaning: str
    reason: str
    ways: tuple[Way, ...] = ()
    cause: Refusal | None = None  # of a refusal
    twins: tuple[Twin, ...] = ()  # what would leave equations, where the replacement that was tried does not

    @property
    def explanation(self) -> str:
        """What replaces the row, and why."""
        return f"{self.meaning}: {self.reason}" if self.meaning else self.reason


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """The removals of a reduction with their evidence."""

    threshold: float
    tolerance: float  # of the local tests
    decisions: tuple[Decision, ...]
    groups: tuple[Group, ...]
    frozen: tuple[Freeze, ...]
    removals: tuple[Removal, ...]
    kept_by_threshold: int
    protected: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    merges: tuple[MergedElement, ...] = ()  # what could be one since these removals, exactly; not among them

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def kept(self) -> tuple[Decision, ...]:
        """The rows that stay, for whatever reason."""
        return tuple(d for d in self.decisions if d.verdict is not Verdict.REMOVED)

    @property
    def removed(self) -> tuple[Decision, ...]:
        """The rows that go."""
        return tuple(d for d in self.decisions if d.verdict is Verdict.REMOVED)

    @property
    def kept_activity(self) -> float:
        """The share of activity of the rows that stay."""
        return sum(d.row.index for d in self.kept)

    def explain(self, row: Path | str) -> str:
        """Why a row goes or stays, with the numbers of all its replacements.

        Raises:
            ReductionError: there is no such row.
        """
        path = observable_path(row)
        decision = next((d for d in self.decisions if d.row.path == path), None)
        if decision is None:
            raise ReductionError.of(
                "reduction/unknown-row",
                f"the plan has no row '{path}'",
                help=one_of(str(path), (str(d.row.path) for d in self.decisions)),
            )
        cause = f" ({decision.cause})" if decision.cause is not None else ""
        lines = [f"{path}, {decision.row.index:.3%} of the activity: {decision.verdict}{cause}", decision.explanation]
        width = max((len(way.meaning) for way in decision.ways), default=0)
        place = max((len(str(way.removal.bond)) for way in decision.ways), default=0)
        lines.extend(
            f"  {way.removal.bond!s:<{place}}  {way.meaning:<{width}}  {way.judged(self.tolerance, PRELOAD_SHARE)}"
            for way in decision.ways
        )
        if decision.twins:
            lines.append(f"regular would be {' or '.join(map(str, decision.twins))}")
        group = next((g for g in self.groups if path in g.rows), None)
        if group is not None:
            lines.append(group.explanation)
        return "\n".join(lines)

    def __str__(self) -> str:
        head = (
            f"threshold {self.threshold:.1%} keeps {self.kept_by_threshold} of {len(self.decisions)} rows; "
            f"{len(self.removed)} can go, {len(self.kept)} stay with {self.kept_activity:.2%} of the activity"
        )
        width = max((len(str(d.row.path)) for d in self.decisions), default=0)
        lines = [
            head,
            *(
                f"  {d.row.path!s:<{width}} {d.row.index:>8.3%}  {d.verdict:<8} {d.explanation}"
                for d in self.decisions
                if d.verdict is not Verdict.KEPT
            ),
        ]
        lines.extend(f"  {freeze.signal} frozen at {freeze.value:.6g}" for freeze in self.frozen)
        lines.extend(f"  could be one: {merge}" for merge in self.merges)
        lines.extend(f"  note: {note}" for note in self.notes)
        return "\n".join(lines)


def plan_reduction(
    compiled: CompiledModel,
    trajectory: Trajectory | Sequence[Trajectory],
    ranking: ActivityRanking,
    *,
    threshold: float = 0.99,
    protected: Iterable[Expr | Path | str] = (),
    tolerance: float = 0.1,
    drop_driven: bool = True,
    keep: Iterable[Path | str] = (),
    release: Iterable[Path | str] = (),
) -> Reduction:
    """Decide which rows go and what replaces them.

    Rows are kept from the top until `threshold` of the activity is reached. For each other row a local test at its
    junction says which replacement is small against its peers: no effort, no flow, a constant; whole groups that act
    back on nothing go together. What would leave a protected output undefined, a kept row idle, or equations without
    solution is refused.

    Args:
        compiled: The full model.
        trajectory: Its run, or its runs through several scenarios, with the observables of all ports recorded. What is
            called small is small in every run.
        ranking: Its ranking; one over windows or scenarios keeps what any of them needs.
        threshold: The share of activity to keep.
        protected: Observables that must stay defined.
        tolerance: Largest share that a neglected term may have at its junction.
        drop_driven: Let driven parts go that feed no protected output, although they are active.
        keep: Rows that stay, however little they do, also where `release` names them.
        release: Rows that are tested as if they were below the threshold, however much they do.

    Raises:
        ReductionError: the threshold is no share, a protected output or a row does not exist, there is no run, or one
            is of another model.
    """
    rules = Rules(
        threshold=threshold,
        tolerance=tolerance,
        drop_driven=drop_driven,
        protected=tuple(observable_path(p) for p in protected),
    )
    for path in rules.protected:
        if path not in compiled.lowered.observables:
            raise ReductionError.of(
                "reduction/unknown-output",
                f"the protected output '{path}' does not exist",
                help=one_of(str(path), map(str, compiled.lowered.observables)),
            )
    runs = (trajectory,) if isinstance(trajectory, Trajectory) else tuple(trajectory)
    _check_runs(compiled, runs)
    locked, released = _rows(ranking, keep), _rows(ranking, release)
    kept = ({row.path for row in ranking.kept_by(threshold)} - released) | locked
    evidence = RunEvidence.of(compiled, *runs)
    modes = tuple(map(ModeWatch, runs))
    candidates = [row for row in ranking.rows if row.path not in kept]
    # What lies in no group: a driven part may go with rows that the threshold keeps, but not with locked ones.
    inviolable = locked if drop_driven else kept
    proposals, groups = _propose(evidence, ranking, candidates, inviolable, rules)
    judge = Judge(compiled, evidence, modes, kept, rules)
    accepted, refused = judge.verify(proposals)
    return _assemble(ranking, judge, accepted, refused, groups, locked)


def _rows(ranking: ActivityRanking, names: Iterable[Path | str]) -> set[Path]:
    """The rows of these names.

    Raises:
        ReductionError: one does not exist.
    """
    known = {row.path for row in ranking.rows}
    found = {observable_path(name) for name in names}
    for path in found - known:
        raise ReductionError.of(
            "reduction/unknown-row",
            f"the ranking has no row '{path}'",
            help=one_of(str(path), map(str, known)),
        )
    return found


def _check_runs(compiled: CompiledModel, runs: Sequence[Trajectory]) -> None:
    bonds = set(compiled.graph.normal.bonds)
    other = next((run for run in runs if set(run.compiled.graph.normal.bonds) != bonds), None)
    if not runs or other is not None:
        raise ReductionError.of(
            "reduction/runs",
            f"the run of scenario '{other.scenario.name}' is one of another model"
            if other is not None
            else f"there is no run to reduce {compiled.model.name} by",
            help="give the run, or the runs through several scenarios, of the model that is reduced",
        )


def _propose(
    evidence: RunEvidence,
    ranking: ActivityRanking,
    candidates: list[ActivityRow],
    inviolable: set[Path],
    rules: Rules,
) -> tuple[list[Proposal], tuple[Group, ...]]:
    by_row = {row.path: row for row in ranking.rows}
    constants = [p for row in candidates if (p := propose_constant(evidence, row, rules.tolerance)) is not None]
    protected = elements_of_outputs(evidence.compiled.graph, rules.protected)
    while True:
        settled = {path for p in constants for path in p.rows}
        open_rows = {row.path for row in candidates} - settled
        staying = settled | protected | inviolable
        groups = find_groups(evidence, open_rows, staying, GroupRules(rules.tolerance, rules.drop_driven))
        # A slow store inside a group is better a constant source, which the rest of the group then meets.
        inner = [by_row[path] for group in groups for path in group.rows if path not in open_rows]
        found = [p for row in inner if (p := propose_constant(evidence, row, rules.tolerance)) is not None]
        if not found:
            break
        constants.extend(found)
    grouped = {path for group in groups for path in group.rows}
    singles = [row for row in reversed(candidates) if row.path in open_rows and row.path not in grouped]
    return [
        *constants,
        *(group.proposal(tuple(by_row[path] for path in group.rows)) for group in groups),
        *(propose(evidence, row, rules.tolerance) for row in singles),
    ], groups


def _assemble(
    ranking: ActivityRanking,
    judge: Judge,
    accepted: list[Proposal],
    refused: list[Proposal],
    groups: tuple[Group, ...],
    locked: set[Path],
) -> Reduction:
    rules, removals = judge.rules, removals_of(accepted)
    frozen, reduced = judge.reduce(accepted)
    going = {path: p for p in accepted for path in p.rows}
    staying = {path: p for p in refused for path in p.rows}
    left = {row.path for row in reduced.system.rows}
    decisions: list[Decision] = []
    for row in ranking.rows:
        ways = ways_of(judge.evidence, row)
        if row.path in going:
            p = going[row.path]
            decisions.append(Decision(row, Verdict.REMOVED, p.removals, p.meaning, p.reason, ways))
        elif row.path in staying and row.path not in judge.keep:
            p = staying[row.path]
            decisions.append(Decision(row, Verdict.REFUSED, (), p.meaning, p.reason, ways, p.cause, p.twins))
        elif row.path not in left:
            reason = "the other removals leave it nothing to act on"
            decisions.append(Decision(row, Verdict.REMOVED, (), "idle", reason, ways))
        else:
            above = f"above the threshold of {rules.threshold:.1%}"
            reason = "locked: it was to be kept" if row.path in locked else above
            decisions.append(Decision(row, Verdict.KEPT, (), "", reason, ways))
    return Reduction(
        threshold=rules.threshold,
        tolerance=rules.tolerance,
        decisions=tuple(decisions),
        groups=tuple(g for g in groups if any(set(g.rows) & set(p.rows) for p in accepted)),
        frozen=frozen,
        removals=(*removals, *frozen),
        kept_by_threshold=len(ranking.kept_by(rules.threshold)),
        protected=rules.protected,
        notes=tuple(_notes(judge, accepted, frozen, reduced)),
        merges=merges_after(judge.compiled, reduced) if accepted else (),
    )


def _notes(judge: Judge, accepted: list[Proposal], frozen: tuple[Freeze, ...], reduced: CompiledModel) -> Iterator[str]:
    if not accepted:
        yield "nothing can be removed at this threshold"
        return
    for freeze in frozen:
        swing = judge.evidence.swing(freeze.signal, freeze.value)
        if swing > judge.rules.tolerance * abs(freeze.value):
            yield f"{freeze.signal} is frozen at {freeze.value:.6g}; in the run it was up to {swing:.3g} away from that"
    yield from dict.fromkeys(watch.problem for watch in judge.modes if watch.problem)
    yield from told(judge.lost_modes(reduced))
