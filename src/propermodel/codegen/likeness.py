"""Which nodes are built alike: by the same operations from the same kinds of leaves, wherever these stand in memory.

Of two nodes that are built alike neither depends on the other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Sequence

from propermodel.expressions.core import Expr, Op, postorder


class Likeness:
    """Numbers for nodes, the same for those that are built alike; arguments are numbered before their users.

    `kind` tells what matters of an operand that has no number.
    """

    def __init__(self, kind: Callable[[Expr], Hashable]) -> None:
        self._kind = kind
        self._numbers: dict[Expr, int] = {}
        self._known: dict[Hashable, int] = {}

    def number(self, node: Expr) -> int:
        """The number of a node, which it has from now on."""
        if node.op is Op.POWER:
            what: Hashable = (node.op, node.args[1], self.of_operand(node.args[0]))
        else:
            coordinates = node.args[1:] if node.op in (Op.LOOKUP, Op.SLOPE) else node.args
            what = (node.op, node.data, *map(self.of_operand, coordinates))
        number = self._numbers[node] = self._known.setdefault(what, len(self._known))
        return number

    def of_operand(self, node: Expr) -> Hashable:
        """The number of an operand, or its kind."""
        return self._numbers[node] if node in self._numbers else self._kind(node)


def alike_together(values: Sequence[Expr], kind: Callable[[Expr], Hashable]) -> list[int]:
    """An order of values in which those built alike follow each other, as their operands do in the order of computing.

    Of those with the same first operand there is one in each sequence.
    """
    likeness = Likeness(kind)
    places: dict[Expr, int] = {}
    for node in postorder(values):
        places[node] = len(places)
        if node.args:
            likeness.number(node)
    first: dict[Hashable, int] = {}
    others: Counter[Hashable] = Counter()
    keys: list[tuple[int, int, list[int]]] = []
    for k, value in enumerate(values):
        number = likeness.of_operand(value)
        beside = (number, value.args[:1])
        keys.append((first.setdefault(number, k), others[beside], [places[arg] for arg in value.args]))
        others[beside] += 1
    return sorted(range(len(values)), key=keys.__getitem__)
