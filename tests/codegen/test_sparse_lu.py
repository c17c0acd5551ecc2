"""Straight-line factors of sparse matrices against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.codegen.machine import FloatArray
from propermodel.codegen.ordering import elimination_order
from propermodel.codegen.sparse_lu import factorise
from propermodel.diagnostics import Path
from propermodel.expressions.core import ONE, Expr, SymbolKind, symbol
from propermodel.expressions.interpret import interpret_all


def entries_of(matrix: FloatArray) -> tuple[dict[tuple[int, int], Expr], dict[Expr, float]]:
    """A symbol for every entry that is not zero, and what it stands for."""
    entries: dict[tuple[int, int], Expr] = {}
    values: dict[Expr, float] = {}
    for i, j in np.argwhere(matrix):
        leaf = entries[int(i), int(j)] = symbol(SymbolKind.PARAMETER, Path((f"a{i}_{j}",)))
        values[leaf] = float(matrix[i, j])
    return entries, values


@given(seed=st.integers(0, 10**6), size=st.integers(1, 12), density=st.floats(0.05, 0.6))
@settings(max_examples=60)
def test_the_solution_is_that_of_dense_elimination(seed: int, size: int, density: float) -> None:
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(size, size)) * (random.random((size, size)) < density)
    np.fill_diagonal(matrix, -1.0 - np.abs(matrix).sum(axis=1))
    right = random.normal(size=size)
    entries, values = entries_of(matrix)
    sides = [symbol(SymbolKind.PARAMETER, Path((f"b{i}",))) for i in range(size)]
    values |= dict(zip(sides, map(float, right), strict=True))
    found = factorise(size, entries)
    solution = interpret_all(found.factors.solve(sides), values)
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, right), rtol=1e-10, atol=1e-12)
    assert not any(interpret_all(found.is_weak, values))


def test_an_arrow_is_factorised_without_new_entries() -> None:
    # Everything is coupled to state 0: eliminated first, it would couple all the others.
    size = 30
    entries = [(0, i) for i in range(size)] + [(i, 0) for i in range(size)] + [(i, i) for i in range(size)]
    assert 0 in elimination_order(size, entries)[-2:]
    found = factorise(size, {(i, j): symbol(SymbolKind.PARAMETER, Path((f"a{i}_{j}",))) for i, j in entries})
    assert sum(len(row) for row in found.factors.upper.values()) == size - 1


def test_a_long_chain_needs_as_much_as_it_is_long() -> None:
    size = 3000
    entries = [(i, j) for i in range(size) for j in (i - 1, i, i + 1) if 0 <= j < size]
    symbols = {(i, j): symbol(SymbolKind.PARAMETER, Path((f"a{i}_{j}",))) for i, j in entries}
    found = factorise(size, symbols)
    assert sum(len(row) for row in found.factors.lower.values()) == size - 1


@pytest.mark.parametrize(
    ("matrix", "weak"),
    [
        ([[1.0, 2.0], [2.0, 4.0]], [False, True]),  # singular by cancellation
        ([[1e-15, 1.0], [1.0, 1.0]], [True, False]),  # small beside what a diagonal is by its nature
        ([[1e20, 1e20], [-1e20, 1.0]], [False, False]),
        ([[float("nan"), 1.0], [1.0, 1.0]], [False, False]),  # shows elsewhere
    ],
)
def test_a_pivot_that_is_rounding_is_told(matrix: list[list[float]], weak: list[bool]) -> None:
    entries, values = entries_of(np.array(matrix))
    assert [bool(x) for x in interpret_all(factorise(2, entries, ONE).is_weak, values)] == weak
