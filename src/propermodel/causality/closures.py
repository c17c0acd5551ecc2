"""Where kinematic loops close: sources that hold the outputs of mechanisms.

A flow source at an output of a mechanism would need its flows solved backwards, through slopes that vanish at dead
centres. Its effort is found instead, as that which keeps its flow (a Lagrange multiplier): for the strokes it is an
effort source.
"""

from __future__ import annotations

from propermodel.bondgraph.graph import Bond, Element, End, Structure
from propermodel.diagnostics import Path
from propermodel.modelling.model import ElementKind, JunctionKind, TwoPort


def is_mechanism(element: Element | None) -> bool:
    """Whether an element is a transformer of a mechanism."""
    return element is not None and isinstance(element.behaviour, TwoPort) and element.behaviour.position is not None


def closures(structure: Structure) -> tuple[Path, ...]:
    """The flow sources that hold an output of a mechanism, in the order of the model."""
    if not any(is_mechanism(element) for element in structure.elements.values()):
        return ()
    at = structure.at()
    return tuple(
        element.path
        for element in structure.elements.values()
        if element.kind is ElementKind.FLOW_SOURCE and _holds_output(structure, at, element)
    )


def _holds_output(structure: Structure, at: dict[Path, list[Bond]], element: Element) -> bool:
    (bond,) = at[element.path]
    near = bond.other(element.path)
    junction = structure.junctions.get(near.owner)
    if junction is None or junction.kind is JunctionKind.ZERO:
        return _is_output(structure, at, near)
    return any(_is_output(structure, at, b.other(near.owner)) for b in at[near.owner] if b is not bond)


def _is_output(structure: Structure, at: dict[Path, list[Bond]], end: End) -> bool:
    """Whether a bond end is the output of a mechanism, or the 0-junction that sums one up."""
    junction = structure.junctions.get(end.owner)
    if junction is None:
        return end.port == "b" and is_mechanism(structure.elements[end.owner])
    if junction.kind is not JunctionKind.ZERO:
        return False
    ends = (bond.other(end.owner) for bond in at[end.owner])
    return any(e.port == "b" and is_mechanism(structure.elements[e.owner]) for e in ends)
