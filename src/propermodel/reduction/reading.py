"""Which elements outputs, signals and laws look at: directly or through signals, but not through physics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, leaves
from propermodel.expressions.within import expressions_in
from propermodel.reduction.freezing import OBSERVED


def elements_of_outputs(graph: BondGraph, outputs: Iterable[Path]) -> set[Path]:
    """The energy elements at which observables are read; what controllers hold leads no further."""
    outputs = tuple(outputs)
    by_path = {leaf.data.path: leaf for leaf in _followed(graph)}
    starts = [by_path[path] for path in outputs if path in by_path]
    ports = [path.parent for path in outputs if path not in by_path]
    return _at_ports(graph, (*ports, *_ports_read(_followed(graph), starts)))


def elements_of_laws(graph: BondGraph, element: Element) -> set[Path]:
    """The other energy elements that the law of an element reads through signals."""
    own = {element.path / port for port in element.ports}
    read = _ports_read({**_followed(graph), **_held(graph)}, expressions_in(element.behaviour))
    return _at_ports(graph, (port for port in read if port not in own)) - {element.path}


Definitions = Mapping[Expr, tuple[Expr, ...]]  # what a signal follows from


def _followed(graph: BondGraph) -> Definitions:
    """Signals and the states of signals."""
    found: dict[Expr, tuple[Expr, ...]] = {leaf: (value,) for leaf, value in graph.signals.items()}
    return found | {state.symbol: (state.derivative,) for state in graph.signal_states}


def _held(graph: BondGraph) -> Definitions:
    """What controllers hold and events change."""
    found: dict[Expr, tuple[Expr, ...]] = {}
    for controller in graph.controllers:
        found |= {leaf: (value,) for leaf, value in controller.updates}
    for event in graph.events:
        for leaf, value in event.changes:
            found[leaf] = (*found.get(leaf, ()), value, event.condition)
    return found


def _ports_read(definitions: Definitions, starts: Iterable[Expr]) -> Iterator[Path]:
    """The ports of elements and components whose variables expressions depend on."""
    pending = list(starts)
    seen: set[Expr] = set()
    while pending:
        for leaf in leaves(pending.pop()):
            if leaf in seen:
                continue
            seen.add(leaf)
            if leaf in definitions:
                pending.extend(definitions[leaf])
            elif leaf.data.kind in OBSERVED:
                yield leaf.data.path.parent


def _at_ports(graph: BondGraph, ports: Iterable[Path]) -> set[Path]:
    elements = graph.normal.elements
    places = set(ports)
    bonds = {bond for path in places for bond in (path, *_inside(graph, path))}
    found = {path for path in places if path in elements}
    for bond in graph.normal.bonds.values():
        if bond.name in bonds:
            found.update(end.owner for end in (bond.tail, bond.head) if end.port)
    # What is looked at is a sum or a flow at these elements; two-ports lead on to parts that it does not see.
    return {path for path in found if elements[path].kind.is_energetic}


def _inside(graph: BondGraph, port: Path) -> tuple[Path, ...]:
    node = graph.node_ports.get(port)
    return node.inside if node is not None else ()
