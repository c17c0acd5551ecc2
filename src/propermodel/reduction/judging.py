"""Which proposals leave a model that still answers, and why the others do not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, SimulationError, parse_path
from propermodel.expressions.core import SymbolKind, leaves
from propermodel.modelling.model import BondRemoval, ElementKind, Freeze, Removal
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.lost_modes import LostMode, ModeKind, ModeWatch
from propermodel.reduction.single import Proposal, Refusal
from propermodel.reduction.singular import Twin, explain_removals
from propermodel.reduction.together import too_much_together


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


@dataclass(frozen=True, slots=True)
class Objection:
    """Why removals together are impossible, and what would be regular instead."""

    cause: Refusal
    why: str
    twins: tuple[Twin, ...] = ()
    members: frozenset[Path] = frozenset()  # bonds, none of which could be missed in a conflict


class Judge:
    """Tries proposals out, all at once where possible, otherwise one by one."""

    def __init__(
        self, compiled: CompiledModel, evidence: RunEvidence, modes: Sequence[ModeWatch], keep: set[Path], rules: Rules
    ) -> None:
        self.compiled = compiled
        self.evidence = evidence
        self.modes = modes
        self.keep = keep
        self.rules = rules
        self._made: tuple[tuple[Removal, ...], tuple[Freeze, ...], CompiledModel] | None = None  # the last
        self._lost: tuple[CompiledModel, tuple[LostMode, ...]] | None = None

    def verify(self, proposals: Iterable[Proposal]) -> tuple[list[Proposal], list[Proposal]]:
        """The proposals that leave a model with equations, and the refused ones with reasons."""
        proposals = list(proposals)
        refused = [p for p in proposals if not p.removals]
        open_proposals = [p for p in proposals if p.removals]
        while (found := too_much_together(self.evidence, open_proposals, self.rules.tolerance)) is not None:
            proposal, why = found
            open_proposals.remove(proposal)
            refused.append(proposal.refused(why, Refusal.TOGETHER))
        while (objection := self.objection(open_proposals)) is not None and objection.members:
            # Of those that conflict, the one stays that would be missed most.
            proposal = max((p for p in open_proposals if _bonds(p) & objection.members), key=_missed)
            open_proposals.remove(proposal)
            twins = self._own(proposal, objection)
            refused.append(proposal.refused(objection.why, objection.cause, twins))
        if objection is None:
            return open_proposals, refused
        accepted: list[Proposal] = []
        for proposal in open_proposals:
            objection = self.objection([*accepted, proposal])
            if objection is None:
                accepted.append(proposal)
            else:
                refused.append(proposal.refused(objection.why, objection.cause, self._own(proposal, objection)))
        return accepted, refused

    def reduce(self, proposals: Sequence[Proposal]) -> tuple[tuple[Freeze, ...], CompiledModel]:
        """The model that proposals leave, and the signals that keep a constant in it.

        Raises:
            ProperModelError: it has no equations.
        """
        removals = removals_of(proposals)
        if self._made is None or self._made[0] != removals:
            frozen = signals_to_freeze(self.evidence, removals)
            self._made = removals, frozen, compile_quietly(self.compiled.model.without((*removals, *frozen)))
        return self._made[1:]

    def lost_modes(self, reduced: CompiledModel) -> tuple[LostMode, ...]:
        """The modes that only one of the two models has.

        Raises:
            SimulationError: along the run nothing solves the equations of the reduced model.
        """
        if self._lost is None or self._lost[0] is not reduced:
            self._lost = reduced, _each_once(mode for watch in self.modes for mode in watch.lost(reduced))
        return self._lost[1]

    def objection(self, proposals: Sequence[Proposal]) -> Objection | None:
        """Why these removals together are impossible, or None."""
        try:
            _, reduced = self.reduce(proposals)
        except ProperModelError as error:
            return self._without_equations(proposals, error)
        dropped = {path for p in proposals for path in p.rows}
        rows = {row.path for row in reduced.system.rows}
        idle = sorted(str(path) for path in self.keep - rows - dropped)
        if idle:
            return Objection(Refusal.ONLY_WAY, f"{', '.join(idle)} would have nothing left to act on")
        lost = [
            str(path)
            for path in self.rules.protected
            if path not in reduced.lowered.observables or (_moves(self.compiled, path) and not _moves(reduced, path))
        ]
        if lost:
            why = f"the protected output {', '.join(lost)} would not exist or would never change"
            return Objection(Refusal.OUTPUT, why)
        return self._instability(reduced)

    def _without_equations(self, proposals: Sequence[Proposal], error: ProperModelError) -> Objection:
        """The fewest removals that leave no equations, with their twins."""
        bonds: list[BondRemoval] = [r for r in removals_of(proposals) if not isinstance(r, Freeze)]
        found = explain_removals(self.compiled.model, bonds)
        if found is None:
            return Objection(
                Refusal.CONFLICT, f"without it the equations have no solution: {error.diagnostics[0].message}"
            )
        members = {member.bond for member in found.members}
        own = {removal.bond for removal in bonds} == members and len(proposals) == 1
        others = "" if own or len(members) < 2 else f" ({found.closure} of {', '.join(sorted(map(str, members)))})"
        why = f"without it the equations have no solution: {found.message}{others}"
        bonds_of = frozenset(members)
        elements = self.evidence.structure.elements
        laws = [
            entry.path
            for entry in found.fault.diagnostics[0].involved
            if (path := parse_path(entry.path)) in elements and elements[path].kind is ElementKind.RESISTANCE
        ]
        if laws:
            return Objection(
                Refusal.FLAT_LAW, f"{why}; the law of {', '.join(laws)} does not give it", found.twins, bonds_of
            )
        return Objection(Refusal.CONFLICT, why, found.twins, bonds_of)

    def _own(self, proposal: Proposal, objection: Objection) -> tuple[Twin, ...]:
        """The twins at the proposal's own bonds; those at the bonds of others where it has none."""
        bonds = _bonds(proposal)
        return tuple(twin for twin in objection.twins if twin.member.bond in bonds) or objection.twins

    def _instability(self, reduced: CompiledModel) -> Objection | None:
        """Whether equations lose their solution along the run, or one model grows where the other does not."""
        try:
            serious = [mode for mode in self.lost_modes(reduced) if mode.is_serious]
        except SimulationError as error:
            why = f"along the run nothing solves the equations that are left: {error.diagnostics[0].message}"
            return Objection(Refusal.FLAT_LAW, why)
        return Objection(Refusal.STABILITY, str(serious[0])) if serious else None


def _each_once(modes: Iterable[LostMode]) -> tuple[LostMode, ...]:
    """Of each kind, lost or new, the first that a run shows; a serious one before others."""
    found: dict[tuple[ModeKind, bool], LostMode] = {}
    for mode in modes:
        known = found.get((mode.kind, mode.is_new))
        if known is None or (mode.is_serious and not known.is_serious):
            found[mode.kind, mode.is_new] = mode
    return tuple(found.values())


def _bonds(proposal: Proposal) -> set[Path]:
    """The bonds that a proposal names."""
    return {removal.bond for removal in proposal.removals if not isinstance(removal, Freeze)}


def _missed(proposal: Proposal) -> tuple[float, tuple[Path, ...]]:
    """The largest share that a proposal takes out of a junction; ties by path."""
    return max((term.share for term in proposal.terms), default=0.0), proposal.rows


def removals_of(proposals: Iterable[Proposal]) -> tuple[Removal, ...]:
    """All removals of proposals, each once."""
    return tuple(dict.fromkeys(removal for proposal in proposals for removal in proposal.removals))


def _moves(compiled: CompiledModel, path: Path) -> bool:
    """Whether an observable can change in a run: it depends on a state, a held value, an input or time."""
    value = next((value for leaf, value in compiled.system.values.items() if leaf.data.path == path), None)
    return value is None or any(leaf.data.kind is not SymbolKind.PARAMETER for leaf in leaves(value))
