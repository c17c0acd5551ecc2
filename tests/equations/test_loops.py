"""Loops of definitions, torn."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from propermodel.diagnostics import Path, StructureError
from propermodel.equations.loops import Resolution
from propermodel.equations.solve import eliminate
from propermodel.expressions.core import Expr, SymbolKind, constant, postorder, symbol
from propermodel.expressions.interpret import interpret, interpret_all

A, B, C, D = (symbol(SymbolKind.EFFORT, Path((name, "port", "effort")), "") for name in "abcd")
P = symbol(SymbolKind.PARAMETER, Path(("p",)))


def test_definitions_are_substituted():
    resolution = Resolution({A: B + 1.0, B: C * 2.0, C: P}, [])
    assert resolution.torn == {}
    assert interpret(resolution.values[A], {P: 3.0}) == 7.0


def test_loop_is_torn_at_a_candidate():
    # a = 2 b + p, b = c, c = a / 4: a = 2 p, b = c = p / 2
    resolution = Resolution({A: 2.0 * B + P, B: C, C: A / 4.0}, [C])
    ((unknown, target),) = resolution.torn.items()
    assert target is C
    residual = unknown - resolution.torn_value(unknown)
    assert interpret(residual, {P: 3.0, unknown: 1.5}) == pytest.approx(0.0)
    assert interpret(resolution.values[A], {P: 3.0, unknown: 1.5}) == pytest.approx(6.0)


def test_two_loops_are_torn_apart():
    resolution = Resolution({A: B + P, B: A * 0.5, C: D + A, D: C * 0.25}, [B, D])
    assert set(resolution.torn.values()) == {B, D}


@given(st.integers(1, 5), st.integers(0, 10_000))
def test_elimination_solves_the_system(size, seed):
    numbers = random.Random(seed)
    entries = [[numbers.uniform(-1.0, 1.0) + 3.0 * (i == j) for j in range(size)] for i in range(size)]
    right = [numbers.uniform(-2.0, 2.0) for _ in range(size)]
    # Entries as symbols, so that nothing folds.
    names = [[symbol(SymbolKind.PARAMETER, Path((f"m{i}{j}",))) for j in range(size)] for i in range(size)]
    sides = [symbol(SymbolKind.PARAMETER, Path((f"r{i}",))) for i in range(size)]
    values = {names[i][j]: entries[i][j] for i in range(size) for j in range(size)}
    values |= dict(zip(sides, right, strict=True))
    solution = interpret_all(eliminate(names, sides, [Path(("x",))] * size), values)
    for row, side in zip(entries, right, strict=True):
        assert sum(m * x for m, x in zip(row, solution, strict=True)) == pytest.approx(side, rel=1e-9, abs=1e-9)


def test_elimination_of_a_star_grows_with_its_size():
    """One unknown that all others are tied to comes last, though it stands first: nothing fills in."""

    def entry(name: str) -> Expr:
        return symbol(SymbolKind.PARAMETER, Path((name,)), "")

    def operations(size: int) -> int:
        matrix = [[constant(0.0)] * size for _ in range(size)]
        for i in range(size):
            matrix[0][i] = matrix[i][0] = entry(f"tie{i}")
            matrix[i][i] = entry(f"own{i}")
        right = [entry(f"given{i}") for i in range(size)]
        return len(postorder(eliminate(matrix, right, [Path(("a",))] * size)))

    assert operations(80) <= 4.5 * operations(20)


def test_elimination_exchanges_rows_where_the_diagonal_is_empty():
    zero, p = constant(0.0), P
    x, y = eliminate([[zero, p], [constant(2.0), zero]], [constant(6.0), constant(8.0)], [Path(("a",))] * 2)
    assert (interpret(x, {P: 3.0}), interpret(y, {P: 3.0})) == (4.0, 2.0)


def test_singular_system_names_its_elements():
    zero = constant(0.0)
    with pytest.raises(StructureError) as caught:
        eliminate([[P, zero], [P, zero]], [P, P], [Path(("left",)), Path(("right",))])
    assert str(caught.value) == (
        "error[equations/singular]: the equations of these elements do not determine their variables\n"
        "      left   takes part\n"
        "      right  takes part\n"
        "  help: an inertia or compliance too few, the same constraint stated twice, or a signal that feeds itself "
        "without a delay"
    )
