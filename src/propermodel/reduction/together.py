"""Terms that are each small at a junction, but not together against what is left there.

A body that stands on a spring: against its weight the spring's changes are small, and so are damper and inertia. But
the weight itself gives way to nothing. Without all of them nothing holds the body.
"""

from __future__ import annotations

from collections.abc import Iterable

from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.modelling.model import ElementKind, Variable
from propermodel.reduction.evidence import OneRun, RunEvidence
from propermodel.reduction.single import Proposal, Term

# What gives an effort or flow without regard to what happens to its partner at the moment.
_SOURCES = frozenset({ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE})
_MAY_BE_CONSTANT = {
    Variable.EFFORT: _SOURCES | {ElementKind.COMPLIANCE},
    Variable.FLOW: _SOURCES | {ElementKind.INERTIA},
}


def too_much_together(
    evidence: RunEvidence, proposals: Iterable[Proposal], tolerance: float
) -> tuple[Proposal, str] | None:
    """The largest of the proposals that together take too much out of a junction, with the reason; or None."""
    dropped: dict[Path, list[tuple[Proposal, Term]]] = {}
    for proposal in proposals:
        for term in proposal.terms:
            dropped.setdefault(term.junction, []).append((proposal, term))
    for junction, items in dropped.items():
        for run in evidence.runs:
            if len(evidence.runs) > 1 and not run.moves(junction):
                continue
            shares = [_share(evidence, run, term) for _, term in items]
            total, gone = sum(shares), {term.bond for _, term in items}
            staying = [b for b in evidence.at[junction] if b.name not in gone]
            left = max((_answer(evidence, run, b, junction) for b in staying), default=0.0)
            if total > tolerance * left:
                largest = max(range(len(items)), key=shares.__getitem__)
                others = f", with all that would go there {total:.2%}" if len(items) > 1 else ""
                where = f" in scenario {run.trajectory.scenario.name}" if len(evidence.runs) > 1 else ""
                kind = evidence.structure.junctions[junction].kind
                return items[largest][0], (
                    f"it takes {shares[largest]:.2%} of the greatest activity out of {kind}-junction {junction}{where}"
                    f"{others}; apart from what is constant only {left:.2%} would be left there (allowed "
                    f"{tolerance:.0%} of that)"
                )
    return None


def _share(evidence: RunEvidence, run: OneRun, term: Term) -> float:
    """The share that a term has in one run."""
    if len(evidence.runs) == 1:
        return term.share
    bond = evidence.structure.bonds[term.bond]
    if term.constant is None:
        return run.share(bond, term.junction)
    return run.constant_share(bond, term.junction, term.constant, evidence.mean(bond, term.constant))


def _answer(evidence: RunEvidence, run: OneRun, bond: Bond, junction: Path) -> float:
    """The share of a term that stays; of a source or a preload only what changes, for a constant answers to nothing."""
    variable = evidence.structure.junctions[junction].kind.common.other
    element = evidence.structure.elements.get(bond.other(junction).owner)
    if element is None or evidence.is_field(element.path) or element.kind not in _MAY_BE_CONSTANT[variable]:
        return run.strength(bond, junction)
    return run.constant_share(bond, junction, variable, evidence.mean(bond, variable))
