"""Groups of rows that act back on nothing: separated at their boundary, they go as a whole.

Every link between two junctions (a bond, or a two-port or field between two bonds) is a term in a sum at either end.
Where the term is small, that end does not feel the other one. Links that are small at one end or both are cut in
thought; what then hangs together is a part, and a part that none of the staying ones feels is driven by them (Rideout,
Stein and Louca 2007). It may go.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from propermodel.analysis.ranking import ActivityRow
from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.modelling.model import JunctionKind, Removal, ZeroEffort, ZeroFlow
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.single import CONSTANT_GAIN, PRELOAD_SHARE, Proposal, Term

# A driven part that may go although it is active holds at most this share of all activity.
LARGEST_DRIVEN_SHARE = 0.25


@dataclass(frozen=True, slots=True)
class Boundary:
    """A bond between a group and the rest: the junction outside, and the share its term has there."""

    bond: Path
    outside: Path
    share: float


@dataclass(frozen=True)
class Group:
    """Junctions and elements that are connected to the rest by terms that are small for the rest."""

    rows: tuple[Path, ...]
    junctions: tuple[Path, ...]
    boundary: tuple[Boundary, ...]
    removals: tuple[Removal, ...]
    meaning: str

    @property
    def explanation(self) -> str:
        """Who belongs to it, and what the rest feels of each bond at its boundary."""
        names = ", ".join(map(str, self.rows))
        edges = "; ".join(f"{b.share:.2%} at {b.outside} ({b.bond})" for b in self.boundary)
        felt = f"the rest feels of it, as shares of the greatest activity, {edges}" if edges else "nothing holds it"
        return f"group of {names}: {felt}"

    def proposal(self, rows: tuple[ActivityRow, ...]) -> Proposal:
        """The group as one proposal."""
        worst = max(self.boundary, key=lambda b: b.share, default=None)
        edge = (
            "it is connected to nothing else"
            if worst is None
            else f"what the rest feels of it is at most {worst.share:.2%} of the greatest activity (at {worst.outside})"
        )
        others = f"with {len(rows) - 1} other row{'s' if len(rows) > 2 else ''}, " if len(rows) > 1 else ""
        terms = tuple(Term(b.bond, b.outside, b.share) for b in self.boundary)
        return Proposal(self.rows, self.removals, self.meaning, f"{others}{edge}", terms)


@dataclass(frozen=True, slots=True)
class GroupRules:
    """The largest share of a term outside a group, and whether active groups may go as driven parts."""

    tolerance: float
    drop_driven: bool


@dataclass(frozen=True, slots=True)
class Link:
    """A link between two junctions with the bond at either end."""

    ends: tuple[Path, Path]
    bonds: tuple[Bond, Bond]
    small: tuple[bool, bool]


def find_groups(
    evidence: RunEvidence, candidates: set[Path], staying: set[Path], rules: GroupRules
) -> tuple[Group, ...]:
    """The groups that may go.

    Args:
        evidence: The run.
        candidates: Rows below the threshold.
        staying: Rows and elements that must not lie in a group.
        rules: What is small, and whether active groups may go.
    """
    links = list(links_of(evidence, rules.tolerance))
    parts = joined(evidence, [link for link in links if not any(link.small)])
    place = {junction: number for number, part in enumerate(parts) for junction in part}
    going = {n for n, part in enumerate(parts) if not _holds(evidence, part, staying)}
    if rules.drop_driven:
        going.discard(max(range(len(parts)), key=lambda n: activity_of(evidence, parts[n]), default=-1))
    while True:
        felt = {
            place[link.ends[side]]
            for link in links
            for side in (0, 1)
            if place[link.ends[side]] in going and place[link.ends[1 - side]] not in going and not link.small[1 - side]
        }
        if not felt & going:
            break
        going -= felt
    components = joined(evidence, [k for k in links if place[k.ends[0]] in going and place[k.ends[1]] in going])
    groups = [_group(evidence, c, links) for c in components if all(place[j] in going for j in c)]
    return tuple(group for group in groups if _may_go(evidence, group, candidates, rules))


def links_of(evidence: RunEvidence, tolerance: float) -> Iterable[Link]:
    """Every link between two junctions, and whether its term is small at either end."""

    def link(a: Bond, at_a: Path, b: Bond, at_b: Path) -> Link:
        small = (is_small(evidence, a, at_a, tolerance), is_small(evidence, b, at_b, tolerance))
        return Link((at_a, at_b), (a, b), small)

    for bond in evidence.structure.bonds.values():
        if not bond.tail.port and not bond.head.port:
            yield link(bond, bond.tail.owner, bond, bond.head.owner)
    for path in evidence.structure.elements:
        bonds = evidence.at[path]
        for number, a in enumerate(bonds):
            for b in bonds[number + 1 :]:
                yield link(a, a.other(path).owner, b, b.other(path).owner)


def is_small(evidence: RunEvidence, bond: Bond, junction: Path, tolerance: float) -> bool:
    """Whether the junction hardly feels the term of this bond."""
    share = evidence.share(bond, junction)
    if share > tolerance:
        return False
    variable = evidence.structure.junctions[junction].kind.common.other
    size = evidence.size_share(bond, junction)
    return size <= PRELOAD_SHARE or evidence.constant_share(bond, junction, variable) <= CONSTANT_GAIN * share


def joined(evidence: RunEvidence, links: list[Link]) -> list[set[Path]]:
    """The junctions that links join, part by part."""
    parent = {junction: junction for junction in evidence.structure.junctions}

    def find(path: Path) -> Path:
        while parent[path] != path:
            parent[path] = parent[parent[path]]
            path = parent[path]
        return path

    for link in links:
        parent[find(link.ends[0])] = find(link.ends[1])
    parts: dict[Path, set[Path]] = {}
    for junction in evidence.structure.junctions:
        parts.setdefault(find(junction), set()).add(junction)
    return list(parts.values())


def elements_at(evidence: RunEvidence, part: set[Path]) -> set[Path]:
    """The elements at some junctions."""
    return {bond.other(j).owner for j in part for bond in evidence.at[j] if bond.other(j).port}


def _holds(evidence: RunEvidence, part: set[Path], staying: set[Path]) -> bool:
    for path in elements_at(evidence, part):
        element = evidence.structure.elements[path]
        if path in staying or (element.kind.is_energetic and element.row in staying):
            return True
    return False


def activity_of(evidence: RunEvidence, part: set[Path]) -> float:
    """The activity of all energy elements at some junctions in all runs, J."""
    return sum(evidence.activities[bond] for bond in _bonds_of_elements(evidence, part))


def _bonds_of_elements(evidence: RunEvidence, part: set[Path]) -> list[Path]:
    """The bonds of the energy elements at some junctions."""
    found = [path for path in elements_at(evidence, part) if evidence.structure.elements[path].kind.is_energetic]
    return [bond.name for path in found for bond in evidence.at[path]]


def _may_go(evidence: RunEvidence, group: Group, candidates: set[Path], rules: GroupRules) -> bool:
    if not group.rows or not group.boundary:
        return False
    inside = elements_at(evidence, set(group.junctions))
    if any(not set(r.elements) <= inside for r in evidence.compiled.system.rows if r.path in group.rows):
        return False
    if set(group.rows) <= candidates:
        return True
    if 2 * len(candidates.intersection(group.rows)) <= len(group.rows):
        return False
    every = _bonds_of_elements(evidence, set(evidence.structure.junctions))
    own = _bonds_of_elements(evidence, set(group.junctions))
    return rules.drop_driven and all(
        sum(run.activities[bond] for bond in own) <= LARGEST_DRIVEN_SHARE * sum(run.activities[bond] for bond in every)
        for run in evidence.runs
    )


def _group(evidence: RunEvidence, part: set[Path], links: list[Link]) -> Group:
    elements = elements_at(evidence, part)
    rows = tuple(r.path for r in evidence.compiled.system.rows if any(path in elements for path in r.elements))
    edge: dict[Removal, None] = {}
    boundary: list[Boundary] = []
    for link in links:
        for side in (0, 1):
            inner, outer = link.ends[side], link.ends[1 - side]
            if inner in part and outer not in part:
                bond = link.bonds[1 - side]
                boundary.append(Boundary(bond.name, outer, evidence.share(bond, outer)))
                edge[deletion(evidence, bond, outer)] = None
    removals = dict.fromkeys([*edge, *_inner_removals(evidence, part, elements)])
    return Group(rows, tuple(sorted(part)), tuple(boundary), tuple(removals), _meaning(list(edge), rows))


def deletion(evidence: RunEvidence, bond: Bond, junction: Path) -> ZeroEffort | ZeroFlow:
    """The removal that takes the term of a bond out of the sum of a junction."""
    is_one = evidence.structure.junctions[junction].kind is JunctionKind.ONE
    return ZeroEffort(bond.name) if is_one else ZeroFlow(bond.name)


def _meaning(edge: list[Removal], rows: tuple[Path, ...]) -> str:
    kinds = {type(removal) for removal in edge}
    if kinds == {ZeroFlow}:
        return "rigid or closed" if len(rows) < 3 else "group, no flow"
    if kinds == {ZeroEffort}:
        return "no effort" if len(rows) < 3 else "group, no effort"
    return "group, cut at its boundary"


def _inner_removals(evidence: RunEvidence, part: set[Path], elements: set[Path]) -> list[Removal]:
    """Inside, every element is deleted by the rule of its junction; most are idle already."""
    return [
        deletion(evidence, bond, bond.other(path).owner)
        for path in sorted(elements)
        if evidence.structure.elements[path].kind.is_energetic
        for bond in evidence.at[path]
        if bond.other(path).owner in part
    ]
