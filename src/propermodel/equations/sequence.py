"""The order in which controllers that are due together run."""

from __future__ import annotations

from propermodel.bondgraph.graph import BondGraph, SampledController
from propermodel.causality.graph_algorithms import strong_components
from propermodel.expressions.core import Expr, SymbolKind, leaves


def in_sequence(graph: BondGraph) -> list[SampledController]:
    """Controllers so that each sees the outputs of those it reads from; a circle keeps the order of the model."""
    owner = {held: i for i, c in enumerate(graph.controllers) for held, _ in c.starts}
    reach = _Reach(graph)
    edges = [
        (i, owner[held])
        for i, controller in enumerate(graph.controllers)
        for _, value in controller.updates
        for held in reach.held(value)
        if held in owner and owner[held] != i
    ]
    order = strong_components(len(graph.controllers), edges)
    return [graph.controllers[i] for component in order for i in sorted(component)]


class _Reach:
    """The held values that an expression reads through signals (not through the physics in between)."""

    def __init__(self, graph: BondGraph) -> None:
        self.signals = graph.signals

    def held(self, expr: Expr) -> frozenset[Expr]:
        found: set[Expr] = set()
        seen: set[Expr] = set()
        pending = [expr]
        while pending:
            for leaf in leaves(pending.pop()):
                if leaf in seen:
                    continue
                seen.add(leaf)
                if leaf.data.kind is SymbolKind.DISCRETE:
                    found.add(leaf)
                elif leaf in self.signals:
                    pending.append(self.signals[leaf])
        return frozenset(found)
