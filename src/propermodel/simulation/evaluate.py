"""The value of an expression with tables, at one instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from propermodel.codegen.machine import TableData
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, Op, leaves, postorder
from propermodel.expressions.interpret import interpret_all


@dataclass(frozen=True, slots=True)
class HeldTable:
    """The numbers of a table, and whether it keeps its last value outside its grid."""

    data: TableData
    holds: bool


def evaluate(exprs: Sequence[Expr], given: Mapping[Expr, float], tables: Mapping[Path, HeldTable]) -> list[float]:
    """The values of expressions of given symbols and tables; a table that is not given counts as zero.

    Raises:
        ModelError: a symbol has no value.
    """
    look_ups = _look_ups(tuple(exprs))
    if not look_ups:
        return interpret_all(exprs, given)
    known = dict(given)
    for node in look_ups:
        known[node.args[0]] = 0.0
        at = interpret_all(node.args[1:], known)
        table = tables.get(node.args[0].data.path)
        known[node] = 0.0 if table is None else _interpolated(table, at, node.data if node.op is Op.SLOPE else None)
    return interpret_all(exprs, known)


@lru_cache(maxsize=1024)
def _look_ups(exprs: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """The look-ups below some expressions, arguments first."""
    return tuple(node for node in postorder(exprs) if node.op in (Op.LOOKUP, Op.SLOPE))


def has_all(expr: Expr, given: Mapping[Expr, float], tables: Mapping[Path, HeldTable]) -> bool:
    """Whether an expression only needs what is given."""
    return all(leaf in given or leaf.data.path in tables for leaf in leaves(expr))


def _interpolated(table: HeldTable, at: Sequence[float], axis: int | None) -> float:
    numbers = np.reshape(table.data.values, [len(grid) for grid in table.data.grids])
    for number, (x, grid) in enumerate(zip(at, table.data.grids, strict=True)):
        cell = int(np.clip(np.searchsorted(grid, x, side="right") - 1, 0, len(grid) - 2))
        width = grid[cell + 1] - grid[cell]
        along = (x - grid[cell]) / width
        if number == axis:
            outside = table.holds and not 0.0 <= along <= 1.0
            numbers = numbers[cell] * 0.0 if outside else (numbers[cell + 1] - numbers[cell]) / width
        else:
            share = min(max(along, 0.0), 1.0) if table.holds else along
            numbers = numbers[cell] * (1.0 - share) + numbers[cell + 1] * share
    return float(numbers)
