# pyright: basic
"""Elementary functions that a scalar function computes at one place become one call on a vector of arguments.

An exponential or a hyperbolic tangent takes as long for four numbers as for one, and gives each the same bits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TypeVar

from propermodel.expressions.core import Expr, Op

BUNDLED = frozenset(
    {Op.EXPONENTIAL, Op.LOGARITHM, Op.SINE, Op.COSINE, Op.TANH, Op.ARCTANGENT},
)
WIDEST = 4

Other = TypeVar("Other")


@dataclass(frozen=True, slots=True)
class Bundle:
    """Nodes of one operation, none of which depends on another."""

    nodes: tuple[Expr, ...]


def bundled(items: Iterable[Expr | Other], barriers: type | tuple[type, ...]) -> Iterator[Expr | Other | Bundle]:
    """Items in computing order with nodes bundled where they can be; nothing moves past a barrier.

    Items that are neither nodes nor barriers stay behind the nodes that come before them.
    """
    segment: list[Expr | Other] = []
    for item in items:
        if isinstance(item, barriers):
            yield from _Segment(segment).ordered()
            yield item
            segment = []
        else:
            segment.append(item)
    yield from _Segment(segment).ordered()


@dataclass
class _Segment:
    items: list
    _bundles: dict[Expr, Bundle] = field(default_factory=dict)
    _inside: set[Expr] = field(default_factory=set)
    _done: set[Expr] = field(default_factory=set)

    def ordered(self) -> Iterator:
        self._find_bundles()
        for item in self.items:
            if isinstance(item, Expr):
                yield from self._with_arguments(item)
            else:
                yield item

    def _find_bundles(self) -> None:
        """Bundle what has as many bundled operations below it: such nodes cannot depend on each other."""
        levels: dict[Expr, int] = {}
        alike: dict[tuple[Op, int], list[Expr]] = {}
        for node in self.items:
            if not isinstance(node, Expr):
                continue
            level = max((levels.get(arg, 0) for arg in node.args), default=0)
            if node.op in BUNDLED:
                alike.setdefault((node.op, level), []).append(node)
                level += 1
            levels[node] = level
        self._inside = set(levels)
        for nodes in alike.values():
            for first in range(0, len(nodes), WIDEST):
                members = tuple(nodes[first : first + WIDEST])
                if len(members) > 1:
                    self._bundles.update(dict.fromkeys(members, Bundle(members)))

    def _with_arguments(self, root: Expr) -> Iterator[Expr | Bundle]:
        """What is still to be computed for a node, and the node."""
        stack = [root]
        while stack:
            node = stack[-1]
            if node not in self._done:
                bundle = self._bundles.get(node)
                members = (node,) if bundle is None else bundle.nodes
                missing = [a for m in members for a in m.args if a in self._inside and a not in self._done]
                if missing:
                    missing.reverse()
                    stack.extend(missing)
                    continue
                self._done.update(members)
                yield bundle or node
            stack.pop()
