"""What replaces one row: the local tests at its junction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

from propermodel.analysis.ranking import ActivityRow
from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.modelling.model import (
    ConstantEffort,
    ConstantFlow,
    ElementKind,
    JunctionKind,
    Removal,
    Variable,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.singular import Twin

# A neglected term whose mean size is more than this share of its greatest peer is a preload, whatever its activity.
PRELOAD_SHARE = 0.2
# A constant replaces a zero when it leaves less than this share of the zero's error.
CONSTANT_GAIN = 0.5


@dataclass(frozen=True, slots=True)
class Term:
    """What a removal takes out of the sum of a junction: a share of the junction's greatest activity."""

    bond: Path
    junction: Path
    share: float  # in the worst run
    constant: Variable | None = None  # what keeps its mean, where that is so


class Refusal(StrEnum):
    """Why a row below the threshold has to stay."""

    PRELOAD = "static preload"
    LARGE = "large among its peers"
    FIELD = "field"  # it couples junctions that are not separate
    ALONE = "no junction"  # there is no sum that it is a term of
    TOGETHER = "too much together"
    CONFLICT = "causal conflict"
    FLAT_LAW = "flat law"  # what is left does not determine its variable along the run
    ONLY_WAY = "unique load path"  # a row that stays would be idle
    OUTPUT = "protected output"
    STABILITY = "stability"


@dataclass(frozen=True, slots=True)
class Proposal:
    """Removals that belong together, for one row or a group; without removals and meaning it is a refusal."""

    rows: tuple[Path, ...]
    removals: tuple[Removal, ...]
    meaning: str
    reason: str
    terms: tuple[Term, ...] = ()
    cause: Refusal | None = None
    twins: tuple[Twin, ...] = ()

    def refused(self, why: str, cause: Refusal, twins: tuple[Twin, ...] = ()) -> Proposal:
        """The same proposal, refused."""
        reason = f"{self.meaning} was tried, but {why}"
        return replace(self, removals=(), terms=(), meaning="", reason=reason, cause=cause, twins=twins)


def propose_constant(evidence: RunEvidence, row: ActivityRow, tolerance: float) -> Proposal | None:
    """A constant source in place of a storage whose variable hardly changes, where zero would be much worse."""
    elements = [evidence.structure.elements[path] for path in row.elements]
    if len(elements) != 1 or not elements[0].kind.is_storage:
        return None
    bonds = [evidence.structure.bonds[name] for name, _ in row.ports]
    main = max(bonds, key=lambda bond: evidence.activities[bond.name])
    junction = _junction_of(main)
    if junction is None or len(evidence.at[junction]) < 2:
        return None
    kind = evidence.structure.junctions[junction].kind
    output = Variable.EFFORT if elements[0].kind is ElementKind.COMPLIANCE else Variable.FLOW
    # The constant acts on the sum where its variable is a term: at its own junction, or over it at the next ones.
    sums = [(main, junction)] if kind.common is not output else _sums_beyond(evidence, main, junction)
    if not sums:
        return None
    shares = [evidence.share(bond, place) for bond, place in sums]
    rests = [evidence.constant_share(bond, place, output) for bond, place in sums]
    if max(rests) > tolerance or max(rests) > CONSTANT_GAIN * max(shares):
        return None
    value = evidence.mean(main, output)
    removals: list[Removal] = [(ConstantEffort if output is Variable.EFFORT else ConstantFlow)(main.name, value)]
    removals.extend(_deletion(evidence, bond) for bond in bonds if bond is not main)
    return Proposal(
        (row.path,),
        tuple(removals),
        f"constant {output} {value:.6g}",
        f"what a constant leaves unexplained is at most {max(rests):.2%} of the greatest activity "
        f"(zero: {max(shares):.2%})",
        tuple(Term(bond.name, place, rest, output) for (bond, place), rest in zip(sums, rests, strict=True)),
    )


def _sums_beyond(evidence: RunEvidence, main: Bond, junction: Path) -> list[tuple[Bond, Path]]:
    found: list[tuple[Bond, Path]] = []
    for bond in evidence.at[junction]:
        if bond is main:
            continue
        end = bond.other(junction)
        if (
            not end.port
            and evidence.structure.junctions[end.owner].kind is not evidence.structure.junctions[junction].kind
        ):
            found.append((bond, end.owner))
    return found


def _deletion(evidence: RunEvidence, bond: Bond) -> Removal:
    """The removal that takes a bond's term out of the sum of its junction."""
    junction = _junction_of(bond)
    is_one = junction is not None and evidence.structure.junctions[junction].kind is JunctionKind.ONE
    return ZeroEffort(bond.name) if is_one else ZeroFlow(bond.name)


def propose(evidence: RunEvidence, row: ActivityRow, tolerance: float) -> Proposal:
    """The replacement for a row that passes the local test at every bond, or a refusal that says why none does."""
    removals: list[Removal] = []
    meanings: list[str] = []
    reasons: list[str] = []
    terms: list[Term] = []
    for bond, _ in row.ports:
        found = _at_bond(evidence, evidence.structure.bonds[bond], tolerance)
        if found is None or not _is_one_port_row(evidence, row):
            return _refuse(evidence, row, tolerance)
        removal, meaning, reason, term = found
        removals.append(removal)
        meanings.append(meaning)
        reasons.append(reason)
        terms.append(term)
    meaning = " and ".join(dict.fromkeys(meanings))
    return Proposal((row.path,), tuple(removals), meaning, "; ".join(reasons), tuple(terms))


def _is_one_port_row(evidence: RunEvidence, row: ActivityRow) -> bool:
    return all(len(evidence.structure.elements[path].ports) == 1 for path in row.elements)


def _junction_of(bond: Bond) -> Path | None:
    for end in (bond.tail, bond.head):
        if not end.port:
            return end.owner
    return None


def _at_bond(evidence: RunEvidence, bond: Bond, tolerance: float) -> tuple[Removal, str, str, Term] | None:
    """The replacement at one bond, by the rule of its junction: at a sum, the small term is dropped."""
    junction = _junction_of(bond)
    if junction is None or len(evidence.at[junction]) < 2:
        return None
    kind = evidence.structure.junctions[junction].kind
    variable = kind.common.other
    share = evidence.share(bond, junction)
    where = f"at {kind}-junction {junction}"
    size = evidence.size_share(bond, junction)
    if share <= tolerance and size <= max(PRELOAD_SHARE, tolerance):
        make_zero = ZeroEffort if kind is JunctionKind.ONE else ZeroFlow
        reason = f"its {variable} carries {share:.2%} of the greatest activity {where}"
        return make_zero(bond.name), f"no {variable}", reason, Term(bond.name, junction, share)
    return None


def _refuse(evidence: RunEvidence, row: ActivityRow, tolerance: float) -> Proposal:
    if not _is_one_port_row(evidence, row):
        reason = "a field couples several junctions, and its group could not be separated from the rest"
        return Proposal((row.path,), (), "", reason, cause=Refusal.FIELD)
    worst, cause = "", Refusal.ALONE
    for name, _ in row.ports:
        bond = evidence.structure.bonds[name]
        junction = _junction_of(bond)
        if junction is None:
            continue
        kind = evidence.structure.junctions[junction].kind
        share, size = evidence.share(bond, junction), evidence.size_share(bond, junction)
        if share > tolerance:
            cause = Refusal.LARGE
            worst = (
                f"little of the whole, but its {kind.common.other} carries {share:.1%} of the greatest activity at "
                f"{kind}-junction {junction}: it is not small among its peers (allowed {tolerance:.0%})"
            )
        elif size > PRELOAD_SHARE:
            cause = Refusal.PRELOAD
            worst = (
                f"its {kind.common.other} is on average {size:.0%} of the greatest at {kind}-junction {junction}: "
                "a preload that does no work but must not be dropped"
            )
    return Proposal((row.path,), (), "", worst or "no replacement is possible at its junction", cause=cause)
