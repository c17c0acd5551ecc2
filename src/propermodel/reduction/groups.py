"""Groups of rows that act back on nothing: separated at their boundary, they go as a whole."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from propermodel.analysis.activity import ActivityRow
from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.modelling.model import (
    ConstantEffort,
    ConstantFlow,
    ElementKind,
    JunctionKind,
    PowerSource,
    Removal,
    Variable,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.single import CONSTANT_GAIN, PRELOAD_SHARE, Proposal


@dataclass(frozen=True, slots=True)
class Boundary:
    """A bond between a group and the rest: the junction outside, and the share its term has there."""

    bond: Path
    outside: Path
    share: float


@dataclass(frozen=True)
class Group:
    """Junctions and elements that are connected to the rest by small terms only."""

    rows: tuple[Path, ...]
    junctions: tuple[Path, ...]
    boundary: tuple[Boundary, ...]
    removals: tuple[Removal, ...]
    meaning: str

    def proposal(self, rows: tuple[ActivityRow, ...]) -> Proposal:
        """The group as one proposal."""
        worst = max(self.boundary, key=lambda b: b.share, default=None)
        edge = (
            "it is connected to nothing else"
            if worst is None
            else f"what it gives back is at most {worst.share:.2%} of the greatest activity (at {worst.outside})"
        )
        others = f"with {len(rows) - 1} other row{'s' if len(rows) > 2 else ''}, " if len(rows) > 1 else ""
        return Proposal(self.rows, self.removals, self.meaning, f"{others}{edge}")


def find_groups(
    evidence: RunEvidence, candidates: set[Path], keep: set[Path], tolerance: float, drop_driven: bool
) -> tuple[Group, ...]:
    """The largest groups of junctions without a row to keep whose terms outside are all within the tolerance."""
    blocked = _Blocked(evidence, set() if drop_driven else keep)
    members = {path for path in evidence.structure.junctions if path not in blocked.junctions}
    found: list[Group] = []
    while members:
        failing: set[Path] = set()
        components = list(_components(evidence, members))
        good: list[set[Path]] = []
        for component in components:
            bad = {
                inner
                for bond, inner, outer in _crossings(evidence, component)
                if not _is_small(evidence, bond, outer, tolerance)
            }
            if bad:
                failing |= bad
            else:
                good.append(component)
        for component in good:
            group = _group(evidence, component)
            if group is not None and _may_go(evidence, group, candidates, drop_driven):
                found.append(group)
            members -= component
        members -= failing
    return tuple(found)


class _Blocked:
    """Junctions that touch an element of a kept row."""

    def __init__(self, evidence: RunEvidence, keep: set[Path]) -> None:
        self.junctions: set[Path] = set()
        for path, element in evidence.structure.elements.items():
            if element.kind.is_energetic and element.row in keep:
                self.junctions.update(b.other(path).owner for b in evidence.at[path])


def _may_go(evidence: RunEvidence, group: Group, candidates: set[Path], drop_driven: bool) -> bool:
    if not group.rows or not group.boundary:
        return False
    if set(group.rows) <= candidates:
        return True
    total = sum(evidence.activities[b] for row in evidence.compiled.system.rows for b in row.bonds)
    inside = sum(
        evidence.activities[b] for row in evidence.compiled.system.rows if row.path in group.rows for b in row.bonds
    )
    # A driven part is a small part: the main flow of energy is never one.
    return drop_driven and inside < 0.25 * total


def _neighbours(evidence: RunEvidence, junction: Path) -> Iterable[tuple[Bond, Path]]:
    """Junctions next to a junction: over a bond, through a two-port, or through a field of several ports."""
    for bond in evidence.at[junction]:
        end = bond.other(junction)
        if not end.port:
            yield bond, end.owner
            continue
        for across in evidence.at[end.owner]:
            if across is not bond:
                yield bond, across.other(end.owner).owner


def _components(evidence: RunEvidence, members: set[Path]) -> Iterable[set[Path]]:
    left = set(members)
    while left:
        start = min(left)
        component = {start}
        pending = [start]
        while pending:
            for _, other in _neighbours(evidence, pending.pop()):
                if other in left and other not in component:
                    component.add(other)
                    pending.append(other)
        left -= component
        yield component


def _crossings(evidence: RunEvidence, component: set[Path]) -> Iterable[tuple[Bond, Path, Path]]:
    """Bonds that leave a component: the bond at the outer junction, the inner junction, the outer junction."""
    for inner in sorted(component):
        for bond in evidence.at[inner]:
            end = bond.other(inner)
            if not end.port:
                if end.owner not in component:
                    yield bond, inner, end.owner
                continue
            for across in evidence.at[end.owner]:
                if across is not bond and across.other(end.owner).owner not in component:
                    yield across, inner, across.other(end.owner).owner


def _is_small(evidence: RunEvidence, bond: Bond, outer: Path, tolerance: float) -> bool:
    variable = evidence.structure.junctions[outer].kind.common.other
    share = evidence.share(bond, outer)
    if share > tolerance:
        return False
    size = evidence.size_share(bond, outer)
    return size <= PRELOAD_SHARE or evidence.constant_share(bond, outer, variable) <= CONSTANT_GAIN * share


def _group(evidence: RunEvidence, component: set[Path]) -> Group | None:
    crossings = list(_crossings(evidence, component))
    elements = {bond.other(j).owner for j in component for bond in evidence.at[j] if bond.other(j).port}
    rows = tuple(row.path for row in evidence.compiled.system.rows if any(path in elements for path in row.elements))
    boundary = tuple(Boundary(bond.name, outer, evidence.share(bond, outer)) for bond, _, outer in crossings)
    constant = _constant(evidence, crossings, elements)
    if constant is not None:
        return Group(rows, tuple(sorted(component)), boundary, *constant)
    edge: list[Removal] = []
    for bond, _, outer in crossings:
        is_one = evidence.structure.junctions[outer].kind is JunctionKind.ONE
        edge.append(ZeroEffort(bond.name) if is_one else ZeroFlow(bond.name))
    removals = dict.fromkeys([*edge, *_inner_removals(evidence, component, elements)])
    return Group(rows, tuple(sorted(component)), boundary, tuple(removals), _meaning(edge, rows))


def _meaning(edge: list[Removal], rows: tuple[Path, ...]) -> str:
    kinds = {type(r) for r in edge}
    if kinds == {ZeroFlow}:
        return "rigid or closed" if len(rows) < 3 else "group, no flow"
    if kinds == {ZeroEffort}:
        return "no effort" if len(rows) < 3 else "group, no effort"
    return "group, cut at its boundary"


def _inner_removals(evidence: RunEvidence, component: set[Path], elements: set[Path]) -> list[Removal]:
    """Inside, every element is deleted by the rule of its junction; most are idle already."""
    found: list[Removal] = []
    for path in sorted(elements):
        element = evidence.structure.elements[path]
        if not element.kind.is_energetic:
            continue
        for bond in evidence.at[path]:
            junction = bond.other(path).owner
            if junction in component:
                is_one = evidence.structure.junctions[junction].kind is JunctionKind.ONE
                found.append(ZeroEffort(bond.name) if is_one else ZeroFlow(bond.name))
    return found


def _constant(
    evidence: RunEvidence, crossings: list[tuple[Bond, Path, Path]], elements: set[Path]
) -> tuple[tuple[Removal, ...], str] | None:
    """A slow store behind one bond becomes a constant source, where that explains its term better than zero does."""
    if len(crossings) != 1:
        return None
    crossing, inner, outer = crossings[0]
    variable = evidence.structure.junctions[outer].kind.common.other
    stores = [
        bond
        for bond in evidence.at[inner]
        if bond.other(inner).port
        and evidence.structure.elements[bond.other(inner).owner].kind
        is (ElementKind.COMPLIANCE if variable is Variable.EFFORT else ElementKind.INERTIA)
    ]
    if len(stores) != 1 or evidence.structure.junctions[inner].kind.common is not variable:
        return None
    share = evidence.share(crossing, outer)
    if evidence.constant_share(crossing, outer, variable) > CONSTANT_GAIN * share:
        return None
    store = stores[0]
    owner = store.other(inner).owner
    value = evidence.mean(store, variable)
    make = ConstantEffort if variable is Variable.EFFORT else ConstantFlow
    removals: list[Removal] = [make(store.name, value)]
    for path in sorted(elements):
        element = evidence.structure.elements[path]
        if isinstance(element.behaviour, PowerSource) or not element.kind.is_energetic:
            continue
        for bond in evidence.at[path]:
            if bond is store:
                continue
            junction = bond.other(path).owner
            is_one = evidence.structure.junctions[junction].kind is JunctionKind.ONE
            zero_flow = path == owner or not is_one
            removals.append(ZeroFlow(bond.name) if zero_flow else ZeroEffort(bond.name))
    return tuple(removals), f"constant {variable} {value:.6g}"
