"""From a ranking to removals: what goes, what replaces it, and why; or why it must stay."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum

from propermodel.analysis.activity import ActivityRanking, ActivityRow
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, ReductionError, one_of
from propermodel.expressions.core import Expr, SymbolKind, leaves
from propermodel.modelling.model import Freeze, Removal
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import OBSERVED, signals_to_freeze
from propermodel.reduction.groups import Group, GroupRules, find_groups
from propermodel.reduction.single import Proposal, propose, propose_constant
from propermodel.reduction.together import too_much_together
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

    `meaning` says what replaces a row that goes; it is empty for one that stays.
    """

    row: ActivityRow
    verdict: Verdict
    removals: tuple[Removal, ...]
    meaning: str
    reason: str

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
        lines.extend(f"  note: {note}" for note in self.notes)
        return "\n".join(lines)


@dataclass(frozen=True, kw_only=True)
class Rules:
    """How a plan is made.

    `tolerance` is the largest share of its junction's greatest activity that a neglected term may have. With
    `drop_driven` a group goes also when some of its rows are above the threshold, provided that it acts back on
    nothing beyond the tolerance and no protected output lies in it: it is a driven part (Rideout, Stein and Louca
    2007).
    """

    threshold: float = 0.99
    tolerance: float = 0.1
    drop_driven: bool = True
    protected: tuple[Path, ...] = field(default=())


def plan_reduction(
    compiled: CompiledModel,
    trajectory: Trajectory,
    ranking: ActivityRanking,
    *,
    threshold: float = 0.99,
    protected: Iterable[Expr | Path | str] = (),
    tolerance: float = 0.1,
    drop_driven: bool = True,
) -> Reduction:
    """Decide which rows go and what replaces them.

    Rows are kept from the top until `threshold` of the activity is reached. For each other row a local test at its
    junction says which replacement is small against its peers: no effort, no flow, a constant; whole groups that act
    back on nothing go together. What would leave a protected output undefined, a kept row idle, or equations without
    solution is refused.

    Args:
        compiled: The full model.
        trajectory: Its run, with the observables of all ports recorded.
        ranking: Its ranking.
        threshold: The share of activity to keep.
        protected: Observables that must stay defined.
        tolerance: Largest share that a neglected term may have at its junction.
        drop_driven: Let driven parts go that feed no protected output, although they are active.

    Raises:
        ReductionError: the threshold is no share, or a protected output does not exist.
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
    keep = {row.path for row in ranking.kept_by(threshold)}
    evidence = RunEvidence.of(compiled, trajectory)
    candidates = [row for row in ranking.rows if row.path not in keep]
    proposals, groups = _propose(evidence, ranking, candidates, keep, rules)
    accepted, refused = _verify(compiled, evidence, proposals, keep, rules)
    return _assemble(ranking, keep, rules, accepted, refused, groups, compiled, evidence)


def _propose(
    evidence: RunEvidence,
    ranking: ActivityRanking,
    candidates: list[ActivityRow],
    keep: set[Path],
    rules: Rules,
) -> tuple[list[Proposal], tuple[Group, ...]]:
    by_row = {row.path: row for row in ranking.rows}
    constants = [p for row in candidates if (p := propose_constant(evidence, row, rules.tolerance)) is not None]
    protected = _protected_elements(evidence, rules.protected)
    while True:
        settled = {path for p in constants for path in p.rows}
        open_rows = {row.path for row in candidates} - settled
        staying = settled | protected | (set() if rules.drop_driven else keep)
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


def _protected_elements(evidence: RunEvidence, protected: tuple[Path, ...]) -> set[Path]:
    """The elements that protected outputs look at, directly or through signals, but not through physics."""
    graph = evidence.compiled.graph
    rates = {state.symbol: state.derivative for state in graph.signal_states}
    by_path = {leaf.data.path: leaf for leaf in (*graph.signals, *rates)}
    pending: list[Expr] = [by_path[path] for path in protected if path in by_path]
    looked_at = {path.parent for path in protected if path not in by_path}
    seen: set[Expr] = set()
    while pending:
        leaf = pending.pop()
        if leaf in seen:
            continue
        seen.add(leaf)
        value = graph.signals.get(leaf, rates.get(leaf))
        if value is not None:
            pending.extend(leaves(value))
        elif leaf.data.kind in OBSERVED:
            looked_at.add(leaf.data.path.parent)
    bonds = {bond for path in looked_at for bond in (path, *_inside(evidence, path))}
    elements = graph.normal.elements
    found = {path for path in looked_at if path in elements}
    for bond in evidence.structure.bonds.values():
        if bond.name in bonds:
            found.update(end.owner for end in (bond.tail, bond.head) if end.port)
    # What an output looks at is a sum or a flow at these elements; two-ports lead on to parts that it does not see.
    return {path for path in found if elements[path].kind.is_energetic}


def _inside(evidence: RunEvidence, port: Path) -> tuple[Path, ...]:
    node = evidence.compiled.graph.node_ports.get(port)
    return node.inside if node is not None else ()


def _verify(
    compiled: CompiledModel, evidence: RunEvidence, proposals: list[Proposal], keep: set[Path], rules: Rules
) -> tuple[list[Proposal], list[Proposal]]:
    """Accept the proposals that leave a model with equations; all at once where possible, otherwise one by one."""
    refused = [p for p in proposals if not p.removals]
    open_proposals = [p for p in proposals if p.removals]
    while (found := too_much_together(evidence, open_proposals, rules.tolerance)) is not None:
        proposal, why = found
        open_proposals.remove(proposal)
        refused.append(proposal.refused(why))
    if _fault(compiled, evidence, open_proposals, keep, rules) is None:
        return open_proposals, refused
    accepted: list[Proposal] = []
    for proposal in open_proposals:
        fault = _fault(compiled, evidence, [*accepted, proposal], keep, rules)
        if fault is None:
            accepted.append(proposal)
        else:
            refused.append(proposal.refused(fault))
    return accepted, refused


def _fault(
    compiled: CompiledModel, evidence: RunEvidence, proposals: list[Proposal], keep: set[Path], rules: Rules
) -> str | None:
    """Why these removals together are impossible, or None."""
    try:
        _, reduced = _reduce(compiled, evidence, proposals)
    except ProperModelError as error:
        return f"without it the equations have no solution: {error.diagnostics[0].message}"
    dropped = {path for p in proposals for path in p.rows}
    rows = {row.path for row in reduced.system.rows}
    idle = sorted(str(path) for path in keep - rows - dropped)
    if idle:
        return f"{', '.join(idle)} would have nothing left to act on"
    lost = [
        str(path)
        for path in rules.protected
        if path not in reduced.lowered.observables or (_moves(compiled, path) and not _moves(reduced, path))
    ]
    if lost:
        return f"the protected output {', '.join(lost)} would not exist or would never change"
    return None


def _moves(compiled: CompiledModel, path: Path) -> bool:
    """Whether an observable can change in a run: it depends on a state, a held value, an input or time."""
    value = next((value for leaf, value in compiled.system.values.items() if leaf.data.path == path), None)
    return value is None or any(leaf.data.kind is not SymbolKind.PARAMETER for leaf in leaves(value))


def _reduce(
    compiled: CompiledModel, evidence: RunEvidence, proposals: list[Proposal]
) -> tuple[tuple[Freeze, ...], CompiledModel]:
    removals = tuple(dict.fromkeys(r for p in proposals for r in p.removals))
    frozen = signals_to_freeze(evidence, removals)
    return frozen, compile_quietly(compiled.model.without((*removals, *frozen)))


def _assemble(
    ranking: ActivityRanking,
    keep: set[Path],
    rules: Rules,
    accepted: list[Proposal],
    refused: list[Proposal],
    groups: tuple[Group, ...],
    compiled: CompiledModel,
    evidence: RunEvidence,
) -> Reduction:
    removals = tuple(dict.fromkeys(r for p in accepted for r in p.removals))
    frozen, reduced = _reduce(compiled, evidence, accepted)
    going = {path: p for p in accepted for path in p.rows}
    staying = {path: p for p in refused for path in p.rows}
    left = {row.path for row in reduced.system.rows}
    decisions: list[Decision] = []
    for row in ranking.rows:
        if row.path in going:
            p = going[row.path]
            decisions.append(Decision(row, Verdict.REMOVED, p.removals, p.meaning, p.reason))
        elif row.path in staying and row.path not in keep:
            p = staying[row.path]
            decisions.append(Decision(row, Verdict.REFUSED, (), p.meaning, p.reason))
        elif row.path not in left:
            decisions.append(
                Decision(row, Verdict.REMOVED, (), "idle", "the other removals leave it nothing to act on")
            )
        else:
            decisions.append(Decision(row, Verdict.KEPT, (), "", f"above the threshold of {rules.threshold:.1%}"))
    used = {p.meaning for p in accepted}
    return Reduction(
        threshold=rules.threshold,
        tolerance=rules.tolerance,
        decisions=tuple(decisions),
        groups=tuple(g for g in groups if any(set(g.rows) & set(p.rows) for p in accepted)),
        frozen=frozen,
        removals=(*removals, *frozen),
        kept_by_threshold=len(keep),
        protected=rules.protected,
        notes=() if used else ("nothing can be removed at this threshold",),
    )
