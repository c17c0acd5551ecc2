"""Who has information from whom: signals between sensors, controllers and modulated elements.

What only computes (gains, sums, look-ups) is followed through, so that a picture shows where information comes from and
where it acts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, SymbolKind, leaves
from propermodel.expressions.within import expressions_in
from propermodel.modelling.model import JunctionKind, Variable

_PHYSICAL = (
    SymbolKind.EFFORT,
    SymbolKind.FLOW,
    SymbolKind.POWER,
    SymbolKind.DISPLACEMENT,
    SymbolKind.MOMENTUM,
    SymbolKind.STATE,
)


class SignalPaths:
    """Follows signals of a graph back to what gives them."""

    def __init__(self, graph: BondGraph) -> None:
        self._graph = graph
        self._controllers = {controller.path for controller in graph.controllers}
        self._blocks = {state.symbol: state.symbol.data.path.parent for state in graph.signal_states}
        self._inputs = {table.symbol: path for path, table in graph.tables.items() if table.is_input}
        self._generators: set[Path] = set()
        self._known: dict[Expr, frozenset[Path]] = {}

    @property
    def controllers(self) -> tuple[Path, ...]:
        """The controllers, which are nodes of their own."""
        return tuple(sorted(self._controllers))

    @property
    def blocks(self) -> tuple[Path, ...]:
        """Signal blocks with states of their own."""
        return tuple(dict.fromkeys(self._blocks.values()))

    @property
    def generators(self) -> tuple[Path, ...]:
        """Signal blocks that give functions of time, as far as something was found to use them."""
        return tuple(sorted(self._generators))

    @property
    def inputs(self) -> tuple[Path, ...]:
        """The inputs of the model that a scenario drives."""
        return tuple(self._inputs.values())

    def into_element(self, element: Element) -> tuple[Path, ...]:
        """What modulates an element."""
        found: set[Path] = set()
        for expr in expressions_in(element.behaviour):
            for leaf in leaves(expr):
                if is_foreign(leaf, element):
                    found |= self._givers(leaf)
        found.discard(element.path)
        return tuple(sorted(found))

    def into_controller(self, path: Path) -> tuple[Path, ...]:
        """What a controller reads."""
        controller = next(c for c in self._graph.controllers if c.path == path)
        found = self._all(new for _, new in controller.updates)
        return tuple(sorted(found - {path}))

    def into_block(self, path: Path) -> tuple[Path, ...]:
        """What the states of a signal block follow."""
        rates = [s.derivative for s in self._graph.signal_states if self._blocks[s.symbol] == path]
        return tuple(sorted(self._all(rates) - {path}))

    def _all(self, exprs: Iterable[Expr]) -> set[Path]:
        return {giver for expr in exprs for leaf in leaves(expr) for giver in self._givers(leaf)}

    def _givers(self, leaf: Expr) -> frozenset[Path]:
        """The nodes that a symbol's value comes from, found without recursion into long chains of signals."""
        pending = [leaf]
        while pending:
            current = pending[-1]
            if current in self._known:
                pending.pop()
                continue
            definition = self._graph.signals.get(current)
            if definition is None:
                self._known[current] = self._origin(current)
                continue
            inner = leaves(definition)
            waiting = [other for other in inner if other not in self._known and other not in pending]
            if waiting:
                pending.extend(waiting)
                continue
            found = frozenset[Path]().union(*(self._known.get(other, frozenset()) for other in inner))
            depends_on_time = any(other.data.kind is SymbolKind.TIME for other in inner)
            if depends_on_time and found.isdisjoint(self._inputs.values()):
                self._generators.add(current.data.path.parent)
                found |= {current.data.path.parent}
            self._known[current] = found
        return self._known[leaf]

    def _origin(self, leaf: Expr) -> frozenset[Path]:
        symbol = leaf.data
        if leaf in self._blocks:
            return frozenset({self._blocks[leaf]})
        if leaf in self._inputs:
            return frozenset({self._inputs[leaf]})
        if symbol.kind is SymbolKind.DISCRETE:
            owner = _nearest(symbol.path, self._controllers)
            return frozenset() if owner is None else frozenset({owner})
        if symbol.kind in _PHYSICAL:
            place = self._place(symbol.path)
            return frozenset() if place is None else frozenset({place})
        return frozenset()

    def _place(self, path: Path) -> Path | None:
        """The junction or element whose variable is read: a variable that a junction shares is the junction's."""
        normal = self._graph.normal
        bond = normal.bonds.get(path.parent)
        if bond is not None:
            shared = JunctionKind.ONE if path.name == Variable.FLOW.value else JunctionKind.ZERO
            for end in (bond.tail, bond.head):
                junction = normal.junctions.get(end.owner)
                if junction is not None and junction.kind is shared:
                    return junction.path
            return next((end.owner for end in (bond.head, bond.tail) if end.owner in normal.elements), None)
        return _nearest(path, normal.elements)


def is_foreign(leaf: Expr, element: Element) -> bool:
    """Whether a symbol in a law of an element is a signal, or a variable of something else."""
    symbol = leaf.data
    if symbol.kind in (SymbolKind.PARAMETER, SymbolKind.TABLE, SymbolKind.TIME):
        return False
    return symbol.kind is SymbolKind.SIGNAL or not symbol.path.is_below(element.path)


def _nearest(path: Path, among: Iterable[Path] | Mapping[Path, object]) -> Path | None:
    """The path itself or the nearest one around it that is among some."""
    known = among if isinstance(among, set | Mapping) else set(among)
    for length in range(len(path), 0, -1):
        if (candidate := Path(path[:length])) in known:
            return candidate
    return None
