"""Resolving definitions into expressions of states; algebraic loops are found and torn."""

from __future__ import annotations

from collections.abc import Iterable

from propermodel.causality.graph_algorithms import strong_components
from propermodel.expressions.core import Expr, Substitution, SymbolKind, leaves, symbol


class Resolution:
    """Definitions with everything defined substituted; torn symbols stand as unknowns."""

    def __init__(self, values: dict[Expr, Expr], candidates: Iterable[Expr]) -> None:
        self.definitions = values
        symbols = list(values)
        index = {s: i for i, s in enumerate(symbols)}
        uses = [[index[leaf] for leaf in leaves(value) if leaf in index] for value in values.values()]
        preferred = {index[c] for c in candidates if c in index}
        torn = {node: _unknown_for(symbols[node]) for node in sorted(_cut_loops(uses, preferred))}
        self.torn = {unknown: symbols[node] for node, unknown in torn.items()}  # unknown: the symbol it stands for
        for node in torn:
            uses[node] = []
        substitute = Substitution({})
        self.values = {
            symbols[node]: substitute.define(symbols[node], torn.get(node, values[symbols[node]]))
            for node in _sorted(uses)
        }

    def torn_value(self, unknown: Expr) -> Expr:
        """What the definition of a torn symbol gives, in terms of unknowns."""
        return self.complete(self.definitions[self.torn[unknown]])

    def complete(self, expr: Expr) -> Expr:
        """An expression with every defined symbol replaced."""
        mapping = {leaf: self.values[leaf] for leaf in leaves(expr) if leaf in self.values}
        return Substitution(mapping)(expr)


def _unknown_for(target: Expr) -> Expr:
    return symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)


def _cut_loops(uses: list[list[int]], preferred: set[int]) -> set[int]:
    """Symbols without whose definitions no loop is left."""
    cut: set[int] = set()
    pending = [list(range(len(uses)))]
    while pending:
        members = pending.pop()
        local = {node: i for i, node in enumerate(members)}
        edges = [(local[i], local[j]) for i in members if i not in cut for j in uses[i] if j in local]
        for component in strong_components(len(members), edges):
            nodes = [members[i] for i in component]
            if len(nodes) == 1 and nodes[0] not in uses[nodes[0]]:
                continue
            if len(nodes) == 1 and nodes[0] in cut:
                continue
            cut.add(_choose(nodes, uses, preferred - cut))
            pending.append(nodes)
    return cut


def _choose(nodes: list[int], uses: list[list[int]], preferred: set[int]) -> int:
    """The symbol of a loop to tear: the result of a law with most uses inside the loop, otherwise any."""
    inside = set(nodes)
    used: dict[int, int] = dict.fromkeys(nodes, 0)
    for node in nodes:
        for other in uses[node]:
            if other in inside:
                used[other] += 1
    pool = [n for n in nodes if n in preferred] or nodes
    return max(pool, key=lambda n: (used[n] * sum(o in inside for o in uses[n]), -n))


def _sorted(uses: list[list[int]]) -> list[int]:
    """The nodes of a graph without loops, those that others use first."""
    order: list[int] = []
    done = [False] * len(uses)
    for start in range(len(uses)):
        stack = [start]
        while stack:
            top = stack[-1]
            missing = [] if done[top] else [node for node in uses[top] if not done[node]]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            if not done[top]:
                done[top] = True
                order.append(top)
    return order
