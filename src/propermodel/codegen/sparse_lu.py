"""Sparse linear equations solved by straight-line expressions on a fixed pattern.

The pivots are those on the diagonal, in an order that is chosen once, by structure. Nothing is exchanged at run time:
a pivot that has lost its figures to cancellation is reported by `is_weak`, and what is solved with it means nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.codegen.ordering import elimination_order
from propermodel.expressions.core import ONE, ZERO, Expr, absolute, divide, less_equal, multiply, subtract

# Of what a pivot is the sum of: less is rounding.
NOTHING = 1e-14


@dataclass(frozen=True)
class SparseFactors:
    """The factors of a matrix: `L U` in the order of the pivots, with ones on the diagonal of L.

    `lower[k]` holds the factors by which row k is subtracted from others, `upper[k]` what is right of the pivot in row
    k, `reciprocals[k]` one over the pivot.
    """

    order: tuple[int, ...]
    lower: Mapping[int, Mapping[int, Expr]]
    upper: Mapping[int, Mapping[int, Expr]]
    reciprocals: Mapping[int, Expr]

    def mapped(self, function: Callable[[Expr], Expr]) -> SparseFactors:
        """The same with other expressions for the same numbers."""

        def rows(given: Mapping[int, Mapping[int, Expr]]) -> dict[int, dict[int, Expr]]:
            return {k: {i: function(entry) for i, entry in row.items()} for k, row in given.items()}

        reciprocals = {k: function(entry) for k, entry in self.reciprocals.items()}
        return SparseFactors(self.order, rows(self.lower), rows(self.upper), reciprocals)

    def solve(self, right: Sequence[Expr]) -> list[Expr]:
        """The solution for a right-hand side."""
        values = list(right)
        for k in self.order:
            for i, factor in self.lower[k].items():
                values[i] = subtract(values[i], multiply(factor, values[k]))
        for k in reversed(self.order):
            for j, entry in self.upper[k].items():
                values[k] = subtract(values[k], multiply(entry, values[j]))
            values[k] = multiply(values[k], self.reciprocals[k])
        return values


@dataclass(frozen=True)
class Factorisation:
    """The factors, and for each pivot the condition under which it is nothing but rounding."""

    factors: SparseFactors
    is_weak: tuple[Expr, ...]  # by row, as in the matrix


def factorise(size: int, entries: Mapping[tuple[int, int], Expr], unit: Expr = ONE) -> Factorisation:
    """The factors of a matrix with these entries by row and column; every entry of the diagonal must be there.

    `unit` is a positive size that the diagonal has by its nature: a pivot that is small beside it is weak, too.
    """
    order = elimination_order(size, entries)
    rows: list[dict[int, Expr]] = [{} for _ in range(size)]
    users: list[dict[int, None]] = [{} for _ in range(size)]  # the rows with an entry in a column
    for (i, j), entry in entries.items():
        rows[i][j] = entry
        users[j][i] = None
    lower: dict[int, dict[int, Expr]] = {}
    upper: dict[int, dict[int, Expr]] = {}
    reciprocals: dict[int, Expr] = {}
    is_weak: dict[int, Expr] = {}
    for k in order:
        pivot = rows[k].pop(k)
        is_weak[k] = less_equal(absolute(pivot), multiply(NOTHING, unit + absolute(entries[k, k])))
        reciprocals[k] = divide(ONE, pivot)
        upper[k] = rows[k]
        lower[k] = {}
        for i in users[k]:
            if i != k:
                factor = lower[k][i] = multiply(rows[i].pop(k), reciprocals[k])
                for j, entry in upper[k].items():
                    rows[i][j] = subtract(rows[i].get(j, ZERO), multiply(factor, entry))
                    users[j][i] = None
        for j in upper[k]:
            del users[j][k]
    factors = SparseFactors(tuple(order), lower, upper, reciprocals)
    return Factorisation(factors, tuple(is_weak[k] for k in range(size)))
