"""Exact elimination of linear equations with expressions as entries."""

from __future__ import annotations

from collections.abc import Sequence

from propermodel.diagnostics import Diagnostic, Involved, Path, StructureError
from propermodel.expressions.core import Expr, divide, is_zero, number


def eliminate(matrix: Sequence[Sequence[Expr]], right: Sequence[Expr], paths: Sequence[Path]) -> list[Expr]:
    """The solution of a small linear system in expressions.

    The pivot of each column is the diagonal where that is not structurally zero: for dependent storage and passive
    loops the diagonal holds positive terms only.

    Raises:
        StructureError: the system is structurally singular; the elements are named.
    """
    size = len(right)
    rows = [list(row) for row in matrix]
    values = list(right)
    for column in range(size):
        pivot = _pivot(rows, column, paths)
        rows[column], rows[pivot] = rows[pivot], rows[column]
        values[column], values[pivot] = values[pivot], values[column]
        for row in range(column + 1, size):
            if is_zero(rows[row][column]):
                continue
            factor = divide(rows[row][column], rows[column][column])
            for k in range(column + 1, size):
                rows[row][k] = rows[row][k] - factor * rows[column][k]
            values[row] = values[row] - factor * values[column]
    for column in reversed(range(size)):
        for k in range(column + 1, size):
            values[column] = values[column] - rows[column][k] * values[k]
        values[column] = divide(values[column], rows[column][column])
    return values


def _pivot(rows: list[list[Expr]], column: int, paths: Sequence[Path]) -> int:
    candidates = [row for row in range(column, len(rows)) if not is_zero(rows[row][column])]
    if not candidates:
        raise StructureError(
            [
                Diagnostic(
                    "equations/singular",
                    "the equations of these elements do not determine their variables",
                    involved=tuple(Involved(str(path), "takes part") for path in dict.fromkeys(paths)),
                    help="an inertia or compliance too few, the same constraint stated twice, or a signal that feeds "
                    "itself without a delay",
                )
            ]
        )
    if column in candidates:
        return column
    return next((row for row in candidates if number(rows[row][column]) is not None), candidates[0])
