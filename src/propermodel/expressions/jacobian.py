"""Jacobians with few operations: the graph of local derivatives is eliminated node by node, cheapest first.

Forward differentiation carries a row of derivatives through every node, also where many paths meet in one node and part
again. Eliminating such a node multiplies what enters by what leaves it, once; which node comes first decides how much
is computed (Griewank and Walther, Evaluating Derivatives, 2008, chapter 9). Markowitz' rule takes the node with the
fewest products.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable

from propermodel.expressions.core import ONE, ZERO, Expr, Op, is_zero, multiply, postorder, where
from propermodel.expressions.derivatives import Tangent, local_partials


def accumulated_derivatives(roots: Iterable[Expr], wrt: Iterable[Expr]) -> list[Tangent]:
    """The non-zero derivatives of each root with respect to the given leaves; `partial_derivatives` in less code."""
    roots = list(roots)
    graph = _Edges(roots, dict.fromkeys(wrt))
    graph.eliminate()
    return [graph.into(root) for root in roots]


class _Edges:
    """The derivatives of nodes with respect to their arguments; only nodes that depend on the given leaves."""

    def __init__(self, roots: list[Expr], leaves: dict[Expr, None]) -> None:
        self._leaves = leaves
        self._roots = dict.fromkeys(roots)
        self._below: dict[Expr, Tangent] = {leaf: {} for leaf in leaves}
        self._above: dict[Expr, dict[Expr, None]] = {leaf: {} for leaf in leaves}
        self._order: dict[Expr, int] = {}  # of the nodes, arguments first
        for node in postorder(roots):
            if node not in self._below:
                self._add(node)

    def _add(self, node: Expr) -> None:
        edges: Tangent = {}
        for partial, arg in zip(local_partials(node), node.args, strict=True):
            if arg in self._below and not is_zero(partial):
                edges[arg] = _plus(edges[arg], partial) if arg in edges else partial
        if not edges:
            return
        self._order[node] = len(self._order)
        self._below[node] = edges
        self._above[node] = {}
        for arg in edges:
            self._above[arg][node] = None

    def _products(self, node: Expr) -> int:
        return len(self._below[node]) * len(self._above[node])

    def eliminate(self) -> None:
        """Eliminate all nodes between the roots and the leaves, then roots that other roots depend on."""
        left = {node for node in self._order if node not in self._roots}
        heap = [(self._products(node), self._order[node], node) for node in left]
        heapq.heapify(heap)
        while heap:
            products, _, node = heapq.heappop(heap)
            if node not in left or products != self._products(node):
                continue  # eliminated, or another entry tells its present count
            left.remove(node)
            for other in (*self._below[node], *self._eliminate(node)):
                if other in left:
                    heapq.heappush(heap, (self._products(other), self._order[other], other))
        for node in self._order:
            if node in self._roots:
                self._eliminate(node)

    def _eliminate(self, node: Expr) -> list[Expr]:
        """Lead all paths through a node past it; the nodes above it."""
        below, above = self._below[node], list(self._above[node])
        for user in above:
            edges = self._below[user]
            factor = edges.pop(node)
            for arg, partial in below.items():
                product = _times(factor, partial)
                edges[arg] = _plus(edges[arg], product) if arg in edges else product
                self._above[arg][user] = None
        self._above[node] = {}
        if node not in self._roots:
            for arg in below:
                del self._above[arg][node]
        return above

    def into(self, root: Expr) -> Tangent:
        """The derivatives of a root with respect to the leaves."""
        if root in self._leaves:
            return {root: ONE}
        return {leaf: value for leaf, value in self._below.get(root, {}).items() if not is_zero(value)}


def _times(a: Expr, b: Expr) -> Expr:
    """The product; what a condition leaves out is left out also where it is infinite."""
    for chooser, other in ((a, b), (b, a)):
        if chooser.op is Op.WHERE:
            condition, first, second = chooser.args
            if first is ONE and second is ZERO:
                return where(condition, other, ZERO)
            if first is ZERO and second is ONE:
                return where(condition, ZERO, other)
    return multiply(a, b)


def _plus(a: Expr, b: Expr) -> Expr:
    """The sum; what one condition chooses is added within its two cases."""
    if a.op is Op.WHERE and b.op is Op.WHERE and a.args[0] is b.args[0]:
        return where(a.args[0], a.args[1] + b.args[1], a.args[2] + b.args[2])
    return a + b
