"""The normal form of a bond graph: exact simplifications, made before causality, ranking and drawing.

What carries no effort or no flow goes; junctions that only pass a bond through go; equal neighbours merge; and rings
(0-junctions that each join the same two 1-junctions, or the dual) become one junction that carries their one-ports.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from itertools import islice

from propermodel.bondgraph.graph import Bond, Element, End, Junction
from propermodel.bondgraph.mechanisms import hold, input_is_gone, is_mechanism_output
from propermodel.bondgraph.net import Net
from propermodel.diagnostics import Involved, Path, StructureError
from propermodel.expressions.core import ZERO, is_zero
from propermodel.modelling.model import ElementKind, JunctionKind, PowerSource, TwoPort, Variable

Zero = tuple[Path, Variable]  # a bond and which of its variables vanishes

_SOURCES = frozenset({ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE})


class _Shorted(Exception):
    """A source prescribes what must vanish."""

    def __init__(self, element: Element, variable: Variable) -> None:
        super().__init__(str(element.path))
        self.element = element
        self.variable = variable

    def explained(self, culprit: Element | None) -> StructureError:
        """The error for its author; `culprit` is the source that prescribes zero, where it is one."""
        element, variable = self.element, self.variable
        involved = [Involved(str(element.path), f"prescribes its {variable}", element.source)]
        if culprit is not None:
            involved.append(Involved(str(culprit.path), f"holds it at zero (its {culprit.kind} is 0)", culprit.source))
        holder = culprit.path if culprit else "a removal"
        return StructureError.of(
            "structure/source-shorted",
            f"{element.path} prescribes the {variable} where {holder} holds it at zero",
            source=element.source,
            involved=involved,
            help=f"take one of the two away, or put a part between them that takes the difference of {variable}",
        )


def normalise(net: Net, zeros: list[Zero]) -> None:
    """Bring the net to normal form, starting from bonds that are known to carry no effort or no flow."""
    removed = {name for name, _ in zeros}
    pending = deque([*zeros, *_zero_sources(net)])
    sources = {bond.name: e for e in net.elements.values() if e.kind in _SOURCES for bond in net.bonds_at(e.path)}
    origin: dict[Path, Path] = {}  # bond that must vanish: the bond that it follows from
    while True:
        while pending:
            zero = pending.popleft()
            before = len(pending)
            try:
                _spread(net, zero, pending, removed)
            except _Shorted as shorted:
                raise shorted.explained(sources.get(origin.get(zero[0], zero[0]))) from None
            for name, _ in islice(pending, before, None):
                origin.setdefault(name, origin.get(zero[0], zero[0]))
        pending.extend(_dead_ends(net))
        if pending:
            continue
        changed = _merge_equal(net)
        changed = _drop_through(net) or changed
        changed = _resolve_rings(net) or changed
        if not changed:
            return


def _zero_sources(net: Net) -> list[Zero]:
    found: list[Zero] = []
    for element in net.elements.values():
        behaviour = element.behaviour
        if isinstance(behaviour, PowerSource) and is_zero(behaviour.value) and element.path not in net.probes:
            variable = Variable.EFFORT if behaviour.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
            found.extend(
                (bond.name, variable)
                for bond in net.bonds_at(element.path)
                if variable is Variable.EFFORT or not is_mechanism_output(net, bond.other(element.path))
            )
    return found


def _spread(net: Net, zero: Zero, pending: deque[Zero], removed: set[Path]) -> None:
    """Take away a bond without effort (or flow) and follow what that means at both ends."""
    name, variable = zero
    if name not in net.bonds:
        return
    net.known_zero.setdefault(name, variable)
    bond = net.drop(name)
    is_held = variable is Variable.FLOW and not any(input_is_gone(net, end) for end in (bond.tail, bond.head))
    for end in (bond.tail, bond.head):
        if end.owner not in net.incident:
            continue
        if is_held and is_mechanism_output(net, end):
            hold(net, bond, end)
        elif net.is_junction(end):
            if net.junctions[end.owner].kind.common is variable:
                pending.extend((other, variable) for other in net.incident[end.owner])
                if not net.incident[end.owner]:
                    net.drop_node(end.owner)
        elif name not in removed and _keeps(net.elements[end.owner], variable):
            _set_free(net, bond, end)
        elif _goes_as_a_whole(net, name, end, removed):
            if not net.incident[end.owner]:
                net.drop_node(end.owner)
        else:
            _spread_into_element(net, bond, end, variable, pending)


def _keeps(element: Element, variable: Variable) -> bool:
    """Whether an element without this variable keeps its state: a mass on which nothing acts, a closed-off volume."""
    stores = {Variable.EFFORT: ElementKind.INERTIA, Variable.FLOW: ElementKind.COMPLIANCE}
    return element.kind is stores[variable] and len(element.ports) == 1


def _goes_as_a_whole(net: Net, name: Path, end: End, removed: set[Path]) -> bool:
    """Whether removals take away this bond of a field and all others that it still has."""
    element = net.elements[end.owner]
    is_field = len(element.ports) > 1 and element.kind.is_energetic
    return is_field and name in removed and removed.issuperset(net.incident[end.owner])


def _set_free(net: Net, bond: Bond, end: End) -> None:
    """Let a storage stand alone, on a junction of its own."""
    net.known_zero.pop(bond.name, None)
    element = net.elements[end.owner]
    kind = JunctionKind.ONE if element.kind is ElementKind.INERTIA else JunctionKind.ZERO
    other = net.junctions.get(bond.other(end.owner).owner)
    if other is not None and other.kind is kind and not net.incident[other.path]:
        net.add(bond)
        return
    node = Junction(path=net.fresh(element.path / end.port, "_free"), kind=kind, source=element.source)
    net.add_junction(node)
    net.add(replace(bond, tail=End(node.path)) if bond.head == end else replace(bond, head=End(node.path)))


def _spread_into_element(net: Net, bond: Bond, end: End, variable: Variable, pending: deque[Zero]) -> None:
    element = net.elements[end.owner]
    if isinstance(element.behaviour, TwoPort):
        across = variable if element.kind is ElementKind.TRANSFORMER else variable.other
        pending.extend((other, across) for other in net.incident[element.path])
        if not net.incident[element.path]:
            net.drop_node(element.path)
        return
    if isinstance(element.behaviour, PowerSource):
        prescribed = Variable.EFFORT if element.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
        if prescribed is variable and not is_zero(element.behaviour.value):
            raise _Shorted(element, variable)
        net.drop_node(element.path)
        return
    if len(element.ports) == 1:
        net.drop_node(element.path)
        return
    # A field keeps its other ports: this one is held at zero by a source.
    kind = ElementKind.EFFORT_SOURCE if variable is Variable.EFFORT else ElementKind.FLOW_SOURCE
    source = Element(
        path=element.path / f"{end.port}_zero",
        kind=kind,
        ports=("port",),
        behaviour=PowerSource(kind=kind, value=ZERO),
        row=element.path / f"{end.port}_zero",
        source=element.source,
    )
    net.elements[source.path] = source
    net.incident[source.path] = {}
    junction = Junction(path=element.path / f"{end.port}_node", kind=JunctionKind.ONE, source=element.source)
    net.add_junction(junction)
    net.add(Bond(source.path / "port", End(junction.path), End(source.path, "port"), bond.domain))
    net.add(replace(bond, tail=End(junction.path)) if bond.head == end else replace(bond, head=End(junction.path)))


def _dead_ends(net: Net) -> list[Zero]:
    """Junctions with one bond left: a lone 1-junction carries no effort, a lone 0-junction no flow."""
    found: list[Zero] = []
    for path, junction in list(net.junctions.items()):
        bonds = net.bonds_at(path)
        if not bonds:
            net.drop_node(path)
        elif len(bonds) == 1:
            end = bonds[0].other(path)
            if end.port and len(net.elements[end.owner].ports) == 1:
                # A storage that keeps its own junction variable (a free mass) stays; all else is idle.
                kind = net.elements[end.owner].kind
                keeps = ElementKind.INERTIA if junction.kind is JunctionKind.ONE else ElementKind.COMPLIANCE
                if kind is keeps or not kind.is_energetic:
                    continue
            found.append((bonds[0].name, junction.kind.common.other))
    return found


def _merge_equal(net: Net) -> bool:
    changed = False
    for name in list(net.bonds):
        bond = net.bonds.get(name)
        if bond is None or bond.tail.port or bond.head.port:
            continue
        keep, gone = bond.tail.owner, bond.head.owner
        if keep == gone:
            net.drop(name)
            changed = True
        elif net.junctions[keep].kind is net.junctions[gone].kind:
            net.drop(name)
            if len(net.incident[gone]) > len(net.incident[keep]):
                keep, gone = gone, keep
            for other in list(net.incident[gone]):
                net.move(other, gone, keep)
            net.drop_node(gone)
            changed = True
    return changed


def _drop_through(net: Net) -> bool:
    changed = False
    for path in list(net.junctions):
        bonds = net.bonds_at(path)
        if len(bonds) != 2 or (bonds[0].tail.owner == path) == (bonds[1].tail.owner == path):
            continue
        before, after = (bonds[0], bonds[1]) if bonds[0].head.owner == path else (bonds[1], bonds[0])
        if (before.tail.port and after.head.port) or before.tail.owner == after.head.owner:
            continue
        net.drop_node(path)
        kept = after if after.head.port else before
        net.add(Bond(kept.name, before.tail, after.head, kept.domain))
        changed = True
    return changed


def _resolve_rings(net: Net) -> bool:
    """Collect junctions that each join the same two junctions of the dual kind into one."""
    rings: dict[tuple[Path, Path, bool], list[tuple[Path, bool]]] = {}
    for path, junction in net.junctions.items():
        bonds = net.bonds_at(path)
        joins = [bond for bond in bonds if not bond.other(path).port]
        if len(joins) != 2 or len(bonds) == 2:
            continue
        if any(net.junctions[b.other(path).owner].kind is junction.kind for b in joins):
            continue
        first, second = sorted(joins, key=lambda b: b.other(path).owner)
        a, b = first.other(path).owner, second.other(path).owner
        if a == b:
            continue
        into_first, into_second = first.head.owner == path, second.head.owner == path
        rings.setdefault((a, b, into_first is into_second), []).append((path, into_first))
    # The dual of a ring may be a ring as well; what one has changed is looked at again in the next round.
    touched: set[Path] = set()
    for (a, b, same_sense), members in rings.items():
        places = {a, b, *(path for path, _ in members)}
        if len(members) > 1 and not places & touched:
            _collect_ring(net, a, b, same_sense, members)
            touched |= places
    return bool(touched)


def _collect_ring(net: Net, a: Path, b: Path, same_sense: bool, members: list[tuple[Path, bool]]) -> None:
    if not same_sense and not members[0][1]:
        # Let the first member keep its sense: look at the ring from the other side.
        a, b = b, a
        members = [(path, not into_first) for path, into_first in members]
    model = net.junctions[members[0][0]]
    common = Junction(path=net.fresh(model.path, "_ring"), kind=model.kind, source=model.source)
    net.add_junction(common)
    carrier = Junction(path=net.fresh(model.path, "_ring"), kind=model.kind.dual, source=model.source)
    net.add_junction(carrier)
    domain = next(iter(net.bonds_at(model.path))).domain
    net.add(Bond(common.path / "first", End(a), End(common.path), domain))
    second = (End(b), End(common.path)) if same_sense else (End(common.path), End(b))
    net.add(Bond(common.path / "second", *second, domain))
    net.add(Bond(carrier.path / "carried", End(common.path), End(carrier.path), domain))
    for path, into_first in members:
        for bond in net.bonds_at(path):
            if bond.other(path).owner in (a, b):
                net.drop(bond.name)
        ends = (End(carrier.path), End(path)) if into_first else (End(path), End(carrier.path))
        net.add(Bond(path / "in_ring", *ends, domain))
