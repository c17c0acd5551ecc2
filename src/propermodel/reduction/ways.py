"""Every replacement of an element with its number: what the sums that it takes part in would miss."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from propermodel.analysis.ranking import ActivityRow
from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.modelling.model import (
    BondRemoval,
    ConstantEffort,
    ConstantFlow,
    ElementKind,
    TwoPort,
    Variable,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.singular import meaning_of

_ZERO = {Variable.EFFORT: ZeroEffort, Variable.FLOW: ZeroFlow}
_CONSTANT = {Variable.EFFORT: ConstantEffort, Variable.FLOW: ConstantFlow}


@dataclass(frozen=True, slots=True)
class Way:
    """One replacement at one bond.

    `missing` is the largest share of the greatest activity at a junction that its sum would miss, at `junction`; `size`
    the mean size of what is missing against the greatest term there, which a preload has although it does no work.
    """

    removal: BondRemoval
    missing: float
    size: float
    junction: Path | None  # None: the variable is no term of any sum, so all that shares it would stop

    @property
    def meaning(self) -> str:
        """What takes the place of the element."""
        return meaning_of(self.removal)

    def judged(self, tolerance: float, preload: float) -> str:
        """Its numbers in words."""
        if self.junction is None:
            return "stops all that moves with it"
        found = f"{self.missing:.2%} of the greatest activity missing at {self.junction}"
        if self.missing > tolerance:
            return f"{found}: not small among its peers"
        if self.size > preload:
            return f"{found}, but {self.size:.0%} of the greatest {self._variable}: a preload"
        return f"{found}: small"

    @property
    def _variable(self) -> str:
        return "effort" if isinstance(self.removal, ZeroEffort | ConstantEffort) else "flow"


def ways_of(evidence: RunEvidence, row: ActivityRow) -> tuple[Way, ...]:
    """Every replacement at every bond of a row, the one that is missed least first."""
    ways = [way for name, _ in row.ports for way in _at(evidence, evidence.structure.bonds[name])]
    return tuple(sorted(ways, key=lambda way: (way.removal.bond, way.junction is None, way.missing)))


def _at(evidence: RunEvidence, bond: Bond) -> Iterable[Way]:
    end = bond.head if bond.head.port else bond.tail
    element = evidence.structure.elements[end.owner]
    for variable in (Variable.EFFORT, Variable.FLOW):
        sums = _sums(evidence, bond, variable)
        yield _way(evidence, _ZERO[variable](bond.name), [(evidence.share(b, j), b, j) for b, j in sums])
    given = {ElementKind.COMPLIANCE: Variable.EFFORT, ElementKind.INERTIA: Variable.FLOW}.get(element.kind)
    if given is not None:
        rests = [(evidence.constant_share(b, j, _term(evidence, j)), b, j) for b, j in _sums(evidence, bond, given)]
        removal = _CONSTANT[given](bond.name, evidence.mean(bond, given))
        way = _way(evidence, removal, rests)
        yield Way(removal, way.missing, 0.0, way.junction)


def _way(evidence: RunEvidence, removal: BondRemoval, terms: list[tuple[float, Bond, Path]]) -> Way:
    if not terms:
        return Way(removal, 1.0, 1.0, None)
    missing, bond, junction = max(terms, key=lambda term: (term[0], term[2]))
    return Way(removal, missing, evidence.size_share(bond, junction), junction)


def _term(evidence: RunEvidence, junction: Path) -> Variable:
    """The variable that a junction adds up."""
    return evidence.structure.junctions[junction].kind.common.other


def _sums(evidence: RunEvidence, bond: Bond, variable: Variable) -> list[tuple[Bond, Path]]:
    """The terms that a variable is: at its junction or, where that shares it, at those around and past two-ports."""
    structure = evidence.structure
    pending = [(bond, end.owner, variable) for end in (bond.tail, bond.head) if not end.port]
    found: list[tuple[Bond, Path]] = []
    seen: set[Path] = set()
    while pending:
        here, junction, wanted = pending.pop()
        if _term(evidence, junction) is wanted:
            found.append((here, junction))
            continue
        if junction in seen:
            continue
        seen.add(junction)
        for other in evidence.at[junction]:
            end = other.other(junction)
            if other is here:
                continue
            if not end.port:
                pending.append((other, end.owner, wanted))
                continue
            element = structure.elements[end.owner]
            if isinstance(element.behaviour, TwoPort):
                beyond = wanted if element.kind is ElementKind.TRANSFORMER else wanted.other
                for bond_beyond in evidence.at[element.path]:
                    far = bond_beyond.other(element.path)
                    if bond_beyond is not other and not far.port:
                        pending.append((bond_beyond, far.owner, beyond))
    return found
