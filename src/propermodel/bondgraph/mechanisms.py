"""Held outputs of mechanisms: what has no flow there closes a kinematic loop and stays in the normal form.

Elsewhere a bond without flow goes. An output of a mechanism is a sum of flows; that it vanishes ties the inputs to
each other, and the effort that ties them is that of a source of no flow, which stays or is put there.
"""

from __future__ import annotations

from propermodel.bondgraph.graph import Bond, Element, End
from propermodel.bondgraph.net import Net
from propermodel.expressions.core import ZERO, is_zero
from propermodel.modelling.model import ElementKind, JunctionKind, PowerSource, TwoPort


def is_mechanism_output(net: Net, end: End) -> bool:
    """Whether a bond end is the output of a mechanism, or the 0-junction that sums one up."""
    element = net.elements.get(end.owner)
    if element is not None:
        return end.port == "b" and isinstance(element.behaviour, TwoPort) and element.behaviour.position is not None
    junction = net.junctions.get(end.owner)
    if junction is None or junction.kind is not JunctionKind.ZERO:
        return False
    others = (bond.other(end.owner) for bond in net.bonds_at(end.owner))
    return any(other.port == "b" and is_mechanism_output(net, other) for other in others)


def input_is_gone(net: Net, end: End) -> bool:
    """Whether a bond has left the output of a transformer of a mechanism whose input does not move."""
    element = net.elements.get(end.owner)
    return element is not None and is_mechanism_output(net, end) and not net.incident[end.owner]


def hold(net: Net, bond: Bond, end: End) -> None:
    """Put a source of no flow in the place of a bond without flow, unless one is there."""
    if not end.port and any(_is_hold(net, other, end) for other in net.bonds_at(end.owner)):
        return
    element = net.elements.get(end.owner)
    source = element.source if element is not None else net.junctions[end.owner].source
    path = net.fresh(end.owner / "held", "_") if end.owner / "held" in net.incident else end.owner / "held"
    behaviour = PowerSource(kind=ElementKind.FLOW_SOURCE, value=ZERO)
    held = Element(path=path, kind=behaviour.kind, ports=("port",), behaviour=behaviour, row=path, source=source)
    net.elements[path] = held
    net.incident[path] = {}
    net.add(Bond(path / "port", end, End(path, "port"), bond.domain))


def _is_hold(net: Net, bond: Bond, end: End) -> bool:
    element = net.elements.get(bond.other(end.owner).owner)
    return element is not None and isinstance(element.behaviour, PowerSource) and is_zero(element.behaviour.value)
