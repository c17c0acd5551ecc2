"""The arithmetic of the interpreted machine: operations, tables and Newton's method with NumPy.

A value is a float64, or an array of one per lane; the order of operations is that of the native code.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from propermodel.codegen.dense import solve_dense
from propermodel.codegen.program import Solve
from propermodel.codegen.schedule import Call, power_plan, whole_power
from propermodel.codegen.tables import PreparedTable
from propermodel.expressions.core import Expr, Op

Number = Any  # np.float64, or an array with one entry per lane
MOST_HALVINGS = 5


def _power(exponent: float) -> Callable[[Number, Number], Number]:
    plan = power_plan(exponent)
    if plan is None:
        return np.power

    def by_multiplication(base: Number, _: Number) -> Number:
        result: Number = whole_power(base, plan.whole, operator.mul) if plan.whole else None
        if plan.has_root:
            result = np.sqrt(base) if result is None else result * np.sqrt(base)
        return 1.0 / result if plan.is_inverse else result

    return by_multiplication


def choose(condition: Number, a: Number, b: Number) -> Number:
    """One value where the condition holds, the other elsewhere."""
    return np.where(condition, a, b)[()]


def _sign(a: Number) -> Number:
    return choose(a > 0.0, 1.0, choose(a < 0.0, -1.0, 0.0))


def _minimum(a: Number, b: Number) -> Number:
    return choose(a <= b, a, b)


def _maximum(a: Number, b: Number) -> Number:
    return choose(a >= b, a, b)


_FUNCTIONS: dict[Op, Callable[..., Number]] = {
    Op.ADD: operator.add,
    Op.SUBTRACT: operator.sub,
    Op.MULTIPLY: operator.mul,
    Op.DIVIDE: operator.truediv,
    Op.NEGATE: operator.neg,
    Op.ABSOLUTE: abs,
    Op.SIGN: _sign,
    Op.SQUARE_ROOT: np.sqrt,
    Op.EXPONENTIAL: np.exp,
    Op.LOGARITHM: np.log,
    Op.SINE: np.sin,
    Op.COSINE: np.cos,
    Op.TANH: np.tanh,
    Op.ARCTANGENT: np.arctan2,
    Op.FLOOR: np.floor,
    Op.MINIMUM: _minimum,
    Op.MAXIMUM: _maximum,
    Op.LESS: operator.lt,
    Op.LESS_EQUAL: operator.le,
    Op.EQUAL: operator.eq,
    Op.AND: operator.and_,
    Op.OR: operator.or_,
    Op.NOT: np.logical_not,
    Op.WHERE: choose,
}
# Arguments that are conditions stay true or false there; everywhere else they count as 1 or 0.
_TRUTHS = {Op.AND: 2, Op.OR: 2, Op.NOT: 1, Op.WHERE: 1}


def operation_of(node: Expr) -> tuple[Callable[..., Number], int]:
    """The function of a node's arguments that gives its value, and how many of the first are conditions."""
    if node.op is Op.POWER:
        return _power(node.args[1].data[0]), 0
    return _FUNCTIONS[node.op], _TRUTHS.get(node.op, 0)


def interpolate(table: PreparedTable, given: Sequence[Number], holds: bool, axis: int | None) -> Number:
    """The value of a table at coordinates, or its slope along one axis."""
    cells: list[Any] = []
    away: list[Number] = []
    for item, grid in zip(given, table.axes, strict=True):
        # Not-a-number belongs to cell 0, although NumPy sorts it last.
        cell = np.where(np.isnan(item), 0, np.searchsorted(grid.grid, item, side="right"))
        cells.append(cell)
        held = _held(item, grid.grid[0], grid.grid[-1]) if holds else item
        away.append(held - grid.pairs[cell, 1][()])
    c = np.moveaxis(table.cells[tuple(cells)], -1, 0)
    if len(cells) == 1:
        return c[0] + c[1] * away[0] if axis is None else c[1]
    if axis is None:
        return (c[0] + c[1] * away[0]) + (c[2] + c[3] * away[0]) * away[1]
    return c[1] + c[3] * away[1] if axis == 0 else c[2] + c[3] * away[0]


def _held(a: Number, low: Number, high: Number) -> Number:
    above = choose(a < low, low, a)
    return choose(above > high, high, above)


class _Lanes:
    """The arithmetic of elimination on numbers."""

    def subtract_product(self, a: Number, b: Number, c: Number) -> Number:
        return a - b * c

    def divide(self, a: Number, b: Number) -> Number:
        return a / b

    def swapped_if_larger(self, a: list[Number], b: list[Number]) -> tuple[list[Number], list[Number]]:
        is_larger = abs(b[0]) > abs(a[0])
        first = [choose(is_larger, y, x) for x, y in zip(a, b, strict=True)]
        return first, [choose(is_larger, x, y) for x, y in zip(a, b, strict=True)]


Evaluate = Callable[[list[Number]], tuple[list[Number], list[list[Number]]]]


def newton(call: Call, start: list[Number], active: Number, evaluate: Evaluate) -> tuple[list[Number], Number]:
    """The solution of an implicit block and the lanes without one; see `llvm_newton.py` for the method."""
    solve = call.solve
    if call.is_affine:
        residuals, jacobian = evaluate(start)
        solution = [x - d for x, d in zip(start, solve_dense(jacobian, residuals, _Lanes()), strict=True)]
        is_good = np.all([abs(x) < math.inf for x in solution], axis=0)
        return solution, active & ~is_good
    x, rest = _iterate(solve, start, active, evaluate)
    if np.any(rest):
        x = [choose(rest, 0.0, item) for item in x]
        x, rest = _iterate(solve, x, rest, evaluate)
    return x, rest


def _iterate(solve: Solve, x: list[Number], active: Number, evaluate: Evaluate) -> tuple[list[Number], Number]:
    residuals, jacobian = evaluate(x)
    for count in range(1, solve.most_iterations + 1):
        step = solve_dense(jacobian, residuals, _Lanes())
        x, active = _accept_small(solve, x, step, active, x)
        if not np.any(active) or count == solve.most_iterations:
            break
        weights = _weights(solve, jacobian)
        norm = _norm(weights, residuals)
        # Where the whole step leads to residuals that the same Jacobian calls small, no other Jacobian is needed.
        first = [choose(active, here - d, here) for here, d in zip(x, step, strict=True)]
        again = solve_dense(jacobian, evaluate(first)[0], _Lanes())
        x, active = _accept_small(solve, first, again, active, x)
        if not np.any(active):
            break
        factor: Number = np.ones_like(active, dtype=np.float64)[()]
        halvings = 0
        while True:
            tried = [choose(active, here - factor * d, here) for here, d in zip(x, step, strict=True)]
            residuals, jacobian = evaluate(tried)
            grew = active & ~(_norm(weights, residuals) <= norm)
            if not np.any(grew) or halvings == MOST_HALVINGS:
                break
            factor = choose(grew, factor * 0.5, factor)
            halvings += 1
        x = tried
    return x, active


def _accept_small(
    solve: Solve, before: list[Number], step: list[Number], active: Number, stay: list[Number]
) -> tuple[list[Number], Number]:
    """Move and freeze the lanes whose corrections are all small; the lanes that are left stay."""
    moved = [here - d for here, d in zip(before, step, strict=True)]
    allowed = [solve.tolerance * (abs(there) + s) for there, s in zip(moved, solve.scales, strict=True)]
    # An infinite correction is not small beside an infinite unknown.
    small = [(abs(d) <= most) & (abs(d) < math.inf) for d, most in zip(step, allowed, strict=True)]
    is_small = np.all(small, axis=0)
    x = [choose(active & is_small, there, here) for there, here in zip(moved, stay, strict=True)]
    return x, active & ~is_small


def _weights(solve: Solve, jacobian: list[list[Number]]) -> list[Number]:
    if len(jacobian) == 1:
        return [1.0]
    weights: list[Number] = []
    for row in jacobian:
        total: Number = 0.0
        for entry, scale in zip(row, solve.scales, strict=True):
            total = total + abs(entry) * (scale or 1.0)
        weights.append(1.0 / total)
    return weights


def _norm(weights: list[Number], residuals: list[Number]) -> Number:
    total: Number = 0.0
    for weight, residual in zip(weights, residuals, strict=True):
        weighed = weight * residual
        total = total + weighed * weighed
    return total
