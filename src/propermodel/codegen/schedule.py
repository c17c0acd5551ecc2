"""The order in which a backend computes a `Function`: every node once, arguments first, solves in their place."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeVar

from propermodel.codegen.program import Array, Assign, Function, Layout, Program, Slot, Solve
from propermodel.expressions.core import TIME, Expr, Op, postorder

READABLE = frozenset(
    {
        Array.TIME,
        Array.STATE,
        Array.DISCRETE,
        Array.PARAMETER,
        Array.UNKNOWN,
        Array.STEP,
        Array.FACTOR,
        Array.STAGE,
    }
)
_MOST_MULTIPLIED = 32  # a larger whole exponent is left to the general power

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Store:
    """Store the value of a node, known by then, in a slot."""

    slot: Slot
    value: Expr


@dataclass(frozen=True, slots=True)
class Call:
    """Solve an implicit block; `captures` are the nodes computed before it that its residuals read."""

    number: int
    solve: Solve
    captures: tuple[Expr, ...]
    inner: tuple[Expr, ...]  # nodes that depend on the unknowns, arguments first
    is_affine: bool  # one correction is exact


# A node that is neither a leaf nor known from elsewhere is to be computed.
Item = Expr | Store | Call


class Level(IntEnum):
    """How often a value can change."""

    RUN = 0  # parameters
    SAMPLE = 1  # what controllers hold
    STEP = 2


def is_leaf(node: Expr) -> bool:
    """Whether a node needs no computation."""
    return not node.args


def number_solves(program: Program) -> dict[Solve, int]:
    """The number of every implicit block: those of `rates` in order, then those that appear elsewhere only."""
    numbers: dict[Solve, int] = {}
    for function in program.functions:
        for step in function.steps:
            if isinstance(step, Solve):
                numbers.setdefault(step, len(numbers))
    return numbers


class Order:
    """Collects nodes in computing order; what has been visited once is not visited again."""

    def __init__(self, known: Callable[[Expr], bool]) -> None:
        self._known = known
        self._seen: set[Expr] = set()

    def new_below(self, root: Expr) -> list[Expr]:
        """The nodes below a root that are neither known nor seen, arguments first."""
        seen, known = self._seen, self._known
        result: list[Expr] = []
        stack = [root]
        while stack:
            node = stack[-1]
            if node not in seen:
                if node.args and not known(node):
                    missing = [arg for arg in node.args if arg not in seen]
                    if missing:
                        missing.reverse()
                        stack.extend(missing)
                        continue
                    result.append(node)
                seen.add(node)
            stack.pop()
        return result


def sequence(function: Function, numbers: dict[Solve, int], known: Callable[[Expr], bool]) -> list[Item]:
    """The items of a function in computing order; `known` nodes are available without being computed."""
    order = Order(known)
    items: list[Item] = []
    for step in function.steps:
        if isinstance(step, Assign):
            items.extend(order.new_below(step.value))
            items.append(Store(step.slot, step.value))
        else:
            call = _call(step, numbers[step], known)
            for capture in call.captures:
                items.extend(order.new_below(capture))
            items.append(call)
    return items


def _call(solve: Solve, number: int, known: Callable[[Expr], bool]) -> Call:
    unknowns = set(solve.unknowns)
    inner: dict[Expr, None] = {}
    captures: dict[Expr, None] = {}
    order = Order(lambda _: False)
    for root in (*solve.residuals, *(entry for row in solve.jacobian for entry in row)):
        for node in order.new_below(root):
            if any(arg in unknowns or arg in inner for arg in node.args):
                inner[node] = None
                captures.update(
                    (arg, None) for arg in node.args if not is_leaf(arg) and arg not in inner and not known(arg)
                )
        if not is_leaf(root) and root not in inner and not known(root):
            captures[root] = None
    return Call(number, solve, tuple(captures), tuple(inner), _is_affine(solve, inner, unknowns))


def _is_affine(solve: Solve, inner: dict[Expr, None], unknowns: set[Expr]) -> bool:
    def depends(node: Expr) -> bool:
        return node in unknowns or node in inner

    if any(depends(entry) for row in solve.jacobian for entry in row):
        return False
    for node in inner:
        match node.op:
            case Op.ADD | Op.SUBTRACT | Op.NEGATE:
                continue
            case Op.MULTIPLY if not all(depends(arg) for arg in node.args):
                continue
            case Op.DIVIDE if not depends(node.args[1]):
                continue
            case Op.WHERE if not depends(node.args[0]):
                continue
            case _:
                return False
    return True


def leaf_slot(layout: Layout, leaf: Expr) -> Slot:
    """Where a leaf is read from.

    Raises:
        ValueError: it has no slot, or one that functions only write.
    """
    slot = layout.slots.get(leaf)
    if slot is None:
        if leaf is TIME:
            return Slot(Array.TIME, 0)
        raise ValueError(f"'{leaf!r}' has no slot in the layout")
    if slot.array not in READABLE:
        raise ValueError(f"'{leaf!r}' is read from {slot.array}, which functions only write")
    return slot


_LEVELS = {Array.PARAMETER: Level.RUN, Array.DISCRETE: Level.SAMPLE}


def roots_of(function: Function) -> list[Expr]:
    """The expressions whose values a function needs, in order."""
    roots: list[Expr] = []
    for step in function.steps:
        if isinstance(step, Assign):
            roots.append(step.value)
        else:
            roots += (*step.residuals, *(entry for row in step.jacobian for entry in row))
    return roots


def nodes_of(functions: Iterable[Function]) -> list[Expr]:
    """Every node of some functions once, leaves included, arguments first."""
    return postorder(root for function in functions for root in roots_of(function))


def node_levels(functions: Iterable[Function], layout: Layout) -> dict[Expr, Level]:
    """How often each node of some functions can change, arguments first."""
    levels: dict[Expr, Level] = {}
    for node in nodes_of(functions):
        if not is_leaf(node):
            levels[node] = max(levels[arg] for arg in node.args)
        elif node.op is Op.CONSTANT or node in layout.table_index:
            levels[node] = Level.RUN
        else:
            levels[node] = _LEVELS.get(leaf_slot(layout, node).array, Level.STEP)
    return levels


def frontier(functions: Iterable[Function], levels: dict[Expr, Level]) -> list[Expr]:
    """The computed nodes below `STEP` that are used by nodes at `STEP`, or stored: what is worth keeping.

    `levels` has the nodes of these functions.
    """
    used = dict.fromkeys(root for function in functions for root in roots_of(function))
    for node, level in levels.items():
        if level is Level.STEP:
            used.update((arg, None) for arg in node.args)
    return [node for node in used if not is_leaf(node) and levels[node] < Level.STEP]


def whole_power(base: T, exponent: int, multiply: Callable[[T, T], T]) -> T:
    """A positive whole power by repeated squaring."""
    result: T | None = None
    while True:
        if exponent & 1:
            result = base if result is None else multiply(result, base)
        exponent >>= 1
        if not exponent:
            assert result is not None
            return result
        base = multiply(base, base)


@dataclass(frozen=True, slots=True)
class PowerPlan:
    """A power as `base**whole * sqrt(base)**root`, inverted if asked for; None where this does not fit."""

    whole: int
    has_root: bool
    is_inverse: bool


def power_plan(exponent: float) -> PowerPlan | None:
    """How to compute a power by multiplications and a square root, if it can be."""
    size = abs(exponent)
    if size > _MOST_MULTIPLIED or (2.0 * size) != int(2.0 * size) or size == 0.0:
        return None
    return PowerPlan(int(size), size != int(size), exponent < 0.0)
