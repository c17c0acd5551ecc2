"""Models that fall apart: parts that neither exchange power nor observe each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.diagnostics import MOST_OFFERED, NO_SOURCE, Diagnostic, Involved, Path, Severity, Source, in_words
from propermodel.expressions.core import Expr, SymbolKind, leaves
from propermodel.modelling.model import Part

Place = Path | Expr  # an element, a junction, a signal block; or a signal that belongs to none of them

_MOST_NAMED = 4  # components named of each part


def separate_parts(graph: BondGraph) -> tuple[Diagnostic, ...]:
    """A warning where a model is in several parts as it is wired; all of them are simulated."""
    parts = _parts(graph)
    if len(parts) < 2:
        return ()
    names = _Names(graph)
    root = graph.model.root
    involved = [names.involved(members) for members in parts[:MOST_OFFERED]]
    if len(parts) > MOST_OFFERED:
        involved.append(Involved("...", f"and {len(parts) - MOST_OFFERED} more"))
    return (
        Diagnostic(
            "structure/disconnected",
            f"{graph.model.name} is in {in_words(len(parts))} parts that do not act on each other",
            where=graph.model.name,
            source=root.definition.source,
            involved=tuple(involved),
            help="connect them where they should meet; as it is, each of them is simulated by itself",
            severity=Severity.WARNING,
        ),
    )


def _parts(graph: BondGraph) -> list[list[Element]]:
    """The elements by part, in the order of the model."""
    neighbours: dict[Place, list[Place]] = {}
    for a, b in _ties(graph):
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    part_of: dict[Place, int] = {}
    parts: list[list[Element]] = []
    for path, element in graph.original.elements.items():
        if path not in part_of:
            _mark(path, len(parts), neighbours, part_of)
            parts.append([])
        parts[part_of[path]].append(element)
    return parts


def _mark(start: Place, number: int, neighbours: dict[Place, list[Place]], part_of: dict[Place, int]) -> None:
    """Give everything that can be reached from a place the number of a part."""
    part_of[start] = number
    pending = [start]
    while pending:
        for place in neighbours.get(pending.pop(), ()):
            if place not in part_of:
                part_of[place] = number
                pending.append(place)


def _ties(graph: BondGraph) -> Iterator[tuple[Place, Place]]:
    """What belongs together: ends of bonds, a signal and what it is made of, an event and what it looks at.

    The ports of one component belong together, too: a body that flies is one thing, although its motions along x and
    y do not act on each other.
    """
    for bond in graph.original.bonds.values():
        yield bond.tail.owner, bond.head.owner
    for bond in graph.activated:
        yield bond.felt.parent, bond.given.parent
    first: dict[Path, Path] = {}
    for port, node in graph.node_ports.items():
        if port.parent:
            yield first.setdefault(port.parent, node.junction), node.junction
    for leaf, value in graph.signals.items():
        yield from _tied(graph, _place(graph, leaf), [value])
    for state in graph.signal_states:
        yield from _tied(graph, _place(graph, state.symbol), [state.derivative])
    for controller in graph.controllers:
        for held, value in controller.updates:
            yield from _tied(graph, controller.path, [held, value])
    for event in graph.events:
        changes = [expression for change in event.changes for expression in change]
        yield from _tied(graph, event.element, [event.condition, *changes])


def _tied(graph: BondGraph, place: Place, expressions: Iterable[Expr]) -> Iterator[tuple[Place, Place]]:
    for leaf in leaves(*expressions):
        if leaf.data.kind not in (SymbolKind.PARAMETER, SymbolKind.TIME):
            yield place, _place(graph, leaf)


def _place(graph: BondGraph, leaf: Expr) -> Place:
    """The element or junction that a symbol belongs to, or the symbol itself."""
    path: Path = leaf.data.path
    while path := path.parent:
        if path in graph.original.elements or path in graph.original.junctions:
            return path
        if path in graph.node_ports:
            return graph.node_ports[path].junction
    return leaf


class _Names:
    """Calls the members of a part by the outermost components that lie wholly within it."""

    def __init__(self, graph: BondGraph) -> None:
        self.model = graph.model
        self.sizes = Counter(place for element in graph.original.elements for place in _above(element))

    def involved(self, members: list[Element]) -> Involved:
        """The part as a line of the diagnostic."""
        sizes = Counter(place for element in members for place in _above(element.path))
        whole = {
            next(place for place in _above(element.path) if sizes[place] == self.sizes[place]): None
            for element in members
        }
        first, *others = map(str, whole)
        shown = others[: _MOST_NAMED - 1]
        rest = f" and {len(others) - len(shown)} more" if len(others) > len(shown) else ""
        role = f"with {', '.join(shown)}{rest}" if others else "stands alone"
        return Involved(first, role, _source(self.model.root, next(iter(whole))) or members[0].source)


def _above(path: Path) -> list[Path]:
    """The components that an element lies in, outermost first, and itself."""
    return [Path(path[:length]) for length in range(1, len(path) + 1)]


def _source(root: Part, path: Path) -> Source | None:
    """Where a component is declared, if it is not made by another."""
    part: Part | None = root
    for name in path:
        part = None if part is None else next((p for p in part.definition.parts if p.name == name), None)
    return None if part is None or part.source == NO_SOURCE else part.source
