"""Names for equations: the shortest that tell owners apart."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from propermodel.bondgraph.graph import BondGraph
from propermodel.diagnostics import Path, shortest_endings
from propermodel.expressions.core import Expr, Op, SymbolKind, symbol
from propermodel.modelling.model import Variable


@dataclass(frozen=True, slots=True)
class Name:
    """The name of a symbol: the shortest path of its owner that no other owner shares, and the quantity."""

    owner: Path
    quantity: str

    def __str__(self) -> str:
        return str(self.owner / self.quantity)


def shortest_names(symbols: Iterable[Expr]) -> dict[Expr, Name]:
    """A name for every symbol; owners are shortened from the left as long as no two are alike."""
    symbols = list(dict.fromkeys(symbols))
    owners = shortest_endings(dict.fromkeys(leaf.data.path.parent for leaf in symbols))
    names = {leaf: Name(owners[leaf.data.path.parent], leaf.data.path.name) for leaf in symbols}
    taken: dict[Name, list[Expr]] = {}
    for leaf, name in names.items():
        taken.setdefault(name, []).append(leaf)
    for name, leaves in taken.items():
        for leaf in leaves[1:]:
            # A parameter and a variable of one owner may be called alike.
            names[leaf] = Name(name.owner, f"{name.quantity}_{leaf.data.kind}")
    return names


def quantity_symbol(graph: BondGraph, leaf: Expr) -> Expr:
    """An effort, flow or unknown under the word of its domain, at the element or port that it belongs to."""
    path = leaf.data.path
    word = path.name.removesuffix("_rate")
    if word not in (Variable.EFFORT.value, Variable.FLOW.value):
        return leaf
    port = path.parent
    bond = graph.original.bonds.get(port) or graph.normal.bonds.get(port)
    node = graph.node_ports.get(port)
    domain = graph.domains.get(bond.domain if bond is not None else node.domain if node is not None else "")
    if domain is None:
        return leaf
    called = (domain.effort if word == Variable.EFFORT.value else domain.flow).replace(" ", "_")
    element = graph.original.elements.get(port.parent) or graph.normal.elements.get(port.parent)
    owner = port.parent if element is not None and len(element.ports) == 1 else port
    if word != path.name:
        called = f"{called}_rate"
    return symbol(leaf.data.kind, owner / called, leaf.data.unit)


def parameter_aliases(graph: BondGraph) -> dict[Expr, Expr]:
    """Parameters that only repeat another one, by that one: what an author turns is what the equations show."""
    values = {parameter.symbol: parameter.value for parameter in graph.parameters.values()}
    found: dict[Expr, Expr] = {}
    for leaf in values:
        top = leaf
        while (value := values.get(top)) is not None and value.op is Op.SYMBOL and value in values:
            top = value
        if top is not leaf:
            found[leaf] = top
    return found


def input_symbols(graph: BondGraph) -> dict[Expr, Expr]:
    """The look-up of every input of the model, by a symbol with the input's name."""
    found: dict[Expr, Expr] = {}
    for table in graph.tables.values():
        if table.is_input:
            leaf = symbol(SymbolKind.SIGNAL, table.path, table.spec.unit)
            named = quantity_symbol(graph, leaf)
            found[table.symbol] = named
    return found
