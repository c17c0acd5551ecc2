"""The Jacobian of a program's rates on its exact pattern, through implicit blocks, with controllers held."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from propermodel.codegen.dense import solve_columns
from propermodel.codegen.program import Array, Assign, Function, Layout, Solve
from propermodel.diagnostics import SimulationError
from propermodel.expressions.core import TIME, ZERO, Expr, absolute, divide, is_zero, less, multiply, subtract, where
from propermodel.expressions.derivatives import Tangent
from propermodel.expressions.jacobian import accumulated_derivatives

# The slopes of larger blocks would make more code than all the rest.
MOST_UNKNOWNS = 24


@dataclass(frozen=True)
class StateJacobian:
    """The derivatives of the rates: by (rate, state), and of each rate with respect to time; zeros are left out.

    They are expressions of what the rates are made of, and hold once the implicit blocks are solved. At kinks they are
    one-sided; tables are linear within their cells, conditions and discrete values stay as they are.
    """

    size: int
    entries: Mapping[tuple[int, int], Expr]
    drift: Mapping[int, Expr]


def state_jacobian(function: Function, layout: Layout) -> StateJacobian:
    """The Jacobian of a function that computes RATE, with its solves.

    Raises:
        SimulationError: an implicit block has too many unknowns.
    """
    states = {leaf: slot.index for leaf, slot in layout.slots.items() if slot.array is Array.STATE}
    solves = [step for step in function.steps if isinstance(step, Solve)]
    rates = {
        step.slot.index: step.value
        for step in function.steps
        if isinstance(step, Assign) and step.slot.array is Array.RATE
    }
    unknowns = [unknown for solve in solves for unknown in solve.unknowns]
    residuals = [residual for solve in solves for residual in solve.residuals]
    found = accumulated_derivatives([*rates.values(), *residuals], [*states, TIME, *unknowns])
    slopes: dict[Expr, Tangent] = {}
    at = len(rates)
    for solve in solves:
        slopes.update(_slopes(solve, found[at : at + len(solve.residuals)], slopes))
        at += len(solve.residuals)
    entries: dict[tuple[int, int], Expr] = {}
    drift: dict[int, Expr] = {}
    for i, tangent in zip(rates, found, strict=False):
        for leaf, value in _total(tangent, slopes).items():
            if leaf is TIME:
                drift[i] = value
            else:
                entries[i, states[leaf]] = value
    return StateJacobian(layout.lengths.get(Array.STATE, 0), entries, drift)


def _total(tangent: Tangent, slopes: Mapping[Expr, Tangent]) -> Tangent:
    """Derivatives with respect to leaves and unknowns, with the unknowns' own derivatives in the place of these."""
    result = {leaf: value for leaf, value in tangent.items() if leaf not in slopes}
    for unknown, factor in tangent.items():
        for leaf, value in slopes.get(unknown, {}).items():
            term = multiply(factor, value)
            result[leaf] = result[leaf] + term if leaf in result else term
    return {leaf: value for leaf, value in result.items() if not is_zero(value)}


def _slopes(solve: Solve, residuals: list[Tangent], known: Mapping[Expr, Tangent]) -> dict[Expr, Tangent]:
    """The derivatives of the unknowns z of r(z, x) = 0: dz/dx = - (dr/dz)^-1 dr/dx."""
    size = len(solve.unknowns)
    if size > MOST_UNKNOWNS:
        names = ", ".join(str(path) for path in dict.fromkeys(solve.paths[:3]))
        raise SimulationError.of(
            "simulation/large-block",
            f"an implicit method needs the derivatives of {size} unknowns that must be solved for together ({names}, "
            f"...); it can do so for {MOST_UNKNOWNS}",
            help="use rk4, or break the loop or the rigid coupling by a compliance",
        )
    own = set(solve.unknowns)
    outer = [_total({leaf: v for leaf, v in row.items() if leaf not in own}, known) for row in residuals]
    leaves = list(dict.fromkeys(leaf for row in outer for leaf in row))
    matrix = [[row.get(unknown, ZERO) for unknown in solve.unknowns] for row in residuals]
    right = [[row.get(leaf, ZERO) for leaf in leaves] for row in outer]
    solution = solve_columns(matrix, right, SymbolicArithmetic())
    return {
        unknown: {leaf: -value for leaf, value in zip(leaves, row, strict=True) if not is_zero(value)}
        for unknown, row in zip(solve.unknowns, solution, strict=True)
    }


class SymbolicArithmetic:
    """The arithmetic of elimination on expressions; rows are exchanged at run time, except where zeros decide."""

    def subtract_product(self, a: Expr, b: Expr, c: Expr) -> Expr:
        return subtract(a, multiply(b, c))

    def divide(self, a: Expr, b: Expr) -> Expr:
        return multiply(a, math.inf) if is_zero(b) else divide(a, b)

    def swapped_if_larger(self, a: list[Expr], b: list[Expr]) -> tuple[list[Expr], list[Expr]]:
        if is_zero(b[0]):
            return a, b
        if is_zero(a[0]):
            return b, a
        is_larger = less(absolute(a[0]), absolute(b[0]))
        first = [where(is_larger, y, x) for x, y in zip(a, b, strict=True)]
        return first, [where(is_larger, x, y) for x, y in zip(a, b, strict=True)]
