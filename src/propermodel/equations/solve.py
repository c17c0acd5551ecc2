"""Exact elimination of linear equations with expressions as entries."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from propermodel.diagnostics import Diagnostic, Involved, Path, StructureError
from propermodel.expressions.core import ONE, ZERO, Expr, divide, is_zero, number


def eliminate(matrix: Sequence[Sequence[Expr]], right: Sequence[Expr], paths: Sequence[Path]) -> list[Expr]:
    """The solution of a small linear system in expressions.

    The pivot of each column is the diagonal where that is not structurally zero: for dependent storage and passive
    loops the diagonal holds positive terms only. Of the columns left the one comes next that fills in least
    (Markowitz), so that chains and ladders stay as sparse as they are.

    Raises:
        StructureError: the system is structurally singular; the elements are named.
    """
    rows, values = _sparse(matrix), list(right)
    order, _ = _triangulate(rows, values, paths)
    for place, column in reversed(list(enumerate(order))):
        for k in order[place + 1 :]:
            if k in rows[column]:
                values[column] = values[column] - rows[column][k] * values[k]
        values[column] = divide(values[column], rows[column][column])
    return values


def determinant(matrix: Sequence[Sequence[Expr]], paths: Sequence[Path]) -> Expr:
    """The determinant of a small matrix of expressions: the product of the pivots of `eliminate`.

    Raises:
        StructureError: the matrix is structurally singular; the elements are named.
    """
    rows = _sparse(matrix)
    order, is_odd = _triangulate(rows, [ZERO] * len(rows), paths)
    product = -ONE if is_odd else ONE
    for column in order:
        product = product * rows[column][column]
    return product


def _sparse(matrix: Sequence[Sequence[Expr]]) -> list[dict[int, Expr]]:
    return [{column: entry for column, entry in enumerate(row) if not is_zero(entry)} for row in matrix]


def _triangulate(rows: list[dict[int, Expr]], values: list[Expr], paths: Sequence[Path]) -> tuple[list[int], bool]:
    """Eliminate below the pivots, in place; the order of the columns, and whether rows changed places oddly often."""
    left, order, is_odd = list(range(len(rows))), list[int](), False
    while left:
        column = _next_column(rows, left)
        pivot = _pivot(rows, column, left, paths)
        is_odd ^= pivot != column
        rows[column], rows[pivot] = rows[pivot], rows[column]
        values[column], values[pivot] = values[pivot], values[column]
        left.remove(column)
        order.append(column)
        for row in left:
            if column not in rows[row]:
                continue
            factor = divide(rows[row].pop(column), rows[column][column])
            for k in left:
                if k in rows[column]:
                    _subtract(rows[row], k, factor * rows[column][k])
            values[row] = values[row] - factor * values[column]
    return order, is_odd


def _subtract(row: dict[int, Expr], column: int, term: Expr) -> None:
    """Take a term from an entry of a row."""
    entry = row[column] - term if column in row else -term
    if is_zero(entry):
        row.pop(column, None)
    else:
        row[column] = entry


def _next_column(rows: list[dict[int, Expr]], left: list[int]) -> int:
    """The column that fills in least when its diagonal is the pivot; the first where no diagonal can be one."""
    remaining = set(left)
    in_column = Counter(column for row in left for column in rows[row] if column in remaining)
    usable = [column for column in left if column in rows[column]]

    def fill(column: int) -> int:
        return (in_column[column] - 1) * (len(remaining.intersection(rows[column])) - 1)

    return min(usable, key=fill) if usable else left[0]


def _pivot(rows: list[dict[int, Expr]], column: int, left: list[int], paths: Sequence[Path]) -> int:
    candidates = [row for row in left if column in rows[row]]
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
