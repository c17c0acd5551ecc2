"""Dense linear equations as straight-line arithmetic, the same for printed code and for numbers."""

from __future__ import annotations

from typing import Protocol, TypeVar

T = TypeVar("T")


class Arithmetic(Protocol[T]):
    """The operations elimination needs, on numbers or on names of numbers, one or several lanes."""

    def subtract_product(self, a: T, b: T, c: T) -> T:
        """The value a - b c."""
        ...

    def divide(self, a: T, b: T) -> T:
        """The quotient."""
        ...

    def swapped_if_larger(self, a: list[T], b: list[T]) -> tuple[list[T], list[T]]:
        """Both lists, exchanged in the lanes where the first entry of `b` is larger in size than that of `a`."""
        ...


def solve_dense(matrix: list[list[T]], right: list[T], arithmetic: Arithmetic[T]) -> list[T]:
    """The solution for one right-hand side; see `solve_columns`."""
    return [row[0] for row in solve_columns(matrix, [[item] for item in right], arithmetic)]


def solve_columns(matrix: list[list[T]], right: list[list[T]], arithmetic: Arithmetic[T]) -> list[list[T]]:
    """The solutions for several right-hand sides, the columns of `right`, by elimination with partial pivoting.

    A singular matrix gives numbers that are not finite. Lanes pivot on their own, so rows are exchanged by choice
    rather than by index.
    """
    size = len(right)
    rows = [[*row, *right[i]] for i, row in enumerate(matrix)]
    for k in range(size):
        for i in range(k + 1, size):
            rows[k][k:], rows[i][k:] = arithmetic.swapped_if_larger(rows[k][k:], rows[i][k:])
        for i in range(k + 1, size):
            factor = arithmetic.divide(rows[i][k], rows[k][k])
            for j in range(k + 1, len(rows[i])):
                rows[i][j] = arithmetic.subtract_product(rows[i][j], factor, rows[k][j])
    solution: list[list[T]] = [[] for _ in range(size)]
    for k in reversed(range(size)):
        for column, entry in enumerate(rows[k][size:]):
            rest = entry
            for j in range(k + 1, size):
                rest = arithmetic.subtract_product(rest, rows[k][j], solution[j][column])
            solution[k].append(arithmetic.divide(rest, rows[k][k]))
    return solution
