"""Resolving definitions into expressions of states; algebraic loops are found and torn."""

from __future__ import annotations

from collections.abc import Iterable

from propermodel.causality.graph_algorithms import strong_components
from propermodel.expressions.core import Expr, Substitution, SymbolKind, leaves, symbol


class Resolution:
    """Definitions with everything defined substituted; torn symbols stand as unknowns."""

    def __init__(self, values: dict[Expr, Expr], candidates: Iterable[Expr]) -> None:
        self.definitions = values
        self.torn: dict[Expr, Expr] = {}  # unknown: the symbol it stands for
        self._tear_loops(list(dict.fromkeys(candidates)))
        replaced = dict(values)
        replaced.update({target: unknown for unknown, target in self.torn.items()})
        self.values = self._resolve(replaced)

    def torn_value(self, unknown: Expr) -> Expr:
        """What the definition of a torn symbol gives, in terms of unknowns."""
        return self.complete(self.definitions[self.torn[unknown]])

    def complete(self, expr: Expr) -> Expr:
        """An expression with every defined symbol replaced."""
        mapping = {leaf: self.values[leaf] for leaf in leaves(expr) if leaf in self.values}
        return Substitution(mapping)(expr)

    def _tear_loops(self, candidates: list[Expr]) -> None:
        symbols = list(self.definitions)
        index = {s: i for i, s in enumerate(symbols)}
        uses = [[index[leaf] for leaf in leaves(self.definitions[s]) if leaf in index] for s in symbols]
        preferred = {index[c] for c in candidates if c in index}
        cut: set[int] = set()
        pending = [list(range(len(symbols)))]
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
                cut.add(self._choose(nodes, uses, preferred - cut))
                pending.append(nodes)
        for node in sorted(cut):
            target = symbols[node]
            unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
            self.torn[unknown] = target

    def _choose(self, nodes: list[int], uses: list[list[int]], preferred: set[int]) -> int:
        """The symbol of a loop to tear: the result of a law with most uses inside the loop, otherwise any."""
        inside = set(nodes)
        used: dict[int, int] = dict.fromkeys(nodes, 0)
        for node in nodes:
            for other in uses[node]:
                if other in inside:
                    used[other] += 1
        pool = [n for n in nodes if n in preferred] or nodes
        return max(pool, key=lambda n: (used[n] * sum(o in inside for o in uses[n]), -n))

    def _resolve(self, values: dict[Expr, Expr]) -> dict[Expr, Expr]:
        substitute = Substitution({})
        return {target: substitute.define(target, values[target]) for target in self._sorted(values)}

    def _sorted(self, values: dict[Expr, Expr]) -> list[Expr]:
        order: list[Expr] = []
        state: dict[Expr, bool] = {}
        for start in values:
            stack = [start]
            while stack:
                top = stack[-1]
                if state.get(top):
                    stack.pop()
                    continue
                missing = [
                    leaf for leaf in leaves(values[top]) if leaf in values and not state.get(leaf) and leaf is not top
                ]
                if missing and top not in state:
                    state[top] = False
                    stack.extend(missing)
                else:
                    state[top] = True
                    order.append(top)
                    stack.pop()
        return order
