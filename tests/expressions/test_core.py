"""Expressions are shared, simplified without changing their value, and no Python truth values."""

from __future__ import annotations

import gc
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from hypothesis import given, settings

from propermodel.diagnostics import ModelError, Path
from propermodel.expressions import (
    atan,
    clip,
    cos,
    equals,
    exp,
    maximum,
    minimum,
    sin,
    sqrt,
    tan,
    where,
)
from propermodel.expressions.core import (
    MINUS_ONE,
    ONE,
    ZERO,
    Op,
    SymbolKind,
    as_expr,
    constant,
    leaves,
    negate,
    postorder,
    rebuild,
    substitute,
    symbol,
)
from propermodel.expressions.interpret import interpret
from tests.expressions.strategies import SYMBOLS, X, Y, Z, expressions, points


def test_expressions_built_alike_are_one_object():
    assert (X + Y) * sin(X) is (X + Y) * sin(X)
    assert X + Y == X + Y
    assert X + Y != Y + X
    assert hash(X * Y) == hash(X * Y)
    path = Path(("a", "effort"))
    assert symbol(SymbolKind.EFFORT, path, "N") is symbol(SymbolKind.EFFORT, path, "N")


def test_symbols_differ_by_kind_path_and_unit():
    path = Path(("a", "flow"))
    assert symbol(SymbolKind.EFFORT, path, "N") is not symbol(SymbolKind.FLOW, path, "N")
    assert symbol(SymbolKind.FLOW, path, "N") is not symbol(SymbolKind.FLOW, path, "W")
    assert constant(1.0, "N") is not constant(1.0)


def test_expressions_nobody_uses_are_forgotten():
    unused = weakref.ref(X * 17.25 + Y * 3.5)
    gc.collect()
    assert unused() is None


def test_expressions_are_immutable():
    with pytest.raises(AttributeError, match="expressions are immutable"):
        X.op = Op.ADD


@pytest.mark.parametrize(
    ("given_", "simplified"),
    [
        (X + 0.0, X),
        (0.0 + X, X),
        (X - 0.0, X),
        (0.0 - X, -X),
        (X - X, ZERO),
        (X * 0.0, ZERO),
        (X * 1.0, X),
        (X * -1.0, -X),
        (negate(-X), X),
        ((-X) * (-Y), X * Y),
        (X + (-Y), X - Y),
        (X - (-Y), X + Y),
        (-(X - Y), Y - X),
        (X / 1.0, X),
        (X / X, ONE),
        (X**0, ONE),
        (X**1, X),
        (constant(2.0) * 3.0, constant(6.0)),
        (sqrt(4.0), constant(2.0)),
        (where(X > 0.0, Y, Y), Y),
        (~~(X > 0.0), X > 0.0),
        (constant(0.0, "N") + X, X),
    ],
)
def test_simplification(given_, simplified):
    assert given_ is simplified


def test_units_of_constants_survive_arithmetic():
    # A number with a unit is not folded with bare numbers: its unit is needed for checking.
    force = constant(2.0, "N")
    assert (force * 3.0).op is Op.MULTIPLY
    assert (-force).data == (-2.0, "N")
    assert (force + force).op is Op.ADD


@given(expressions(), points)
@settings(max_examples=150)
def test_rebuilding_keeps_the_value(expr, point):
    rebuilt = {}
    for node in postorder([expr]):
        rebuilt[node] = rebuild(node.op, [rebuilt[a] for a in node.args], node.data) if node.args else node
    assert interpret(rebuilt[expr], point) == pytest.approx(interpret(expr, point), rel=1e-12, abs=1e-12)


@given(expressions(), expressions(), points)
@settings(max_examples=100)
def test_substitution_is_evaluation_at_the_substituted_value(outer, inner, point):
    substituted = substitute(outer, {X: inner})
    expected = interpret(outer, {**point, X: interpret(inner, point)})
    assert interpret(substituted, point) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_substitution_is_simultaneous():
    assert substitute(X - Y, {X: Y, Y: X}) is Y - X


@pytest.mark.parametrize("use", [bool, lambda c: 1 if c else 2, lambda c: c and c, lambda c: not c])
def test_conditions_have_no_truth_value(use):
    with pytest.raises(ModelError) as caught:
        use(X > 0.0)
    assert str(caught.value) == (
        "error[expression/truth-value]: an expression has no truth value while a model is being described\n"
        "  help: write where(condition, a, b) instead of 'if', and & | ~ instead of 'and or not'"
    )


def test_chained_comparison_is_refused():
    with pytest.raises(ModelError):
        _ = 0.0 < X < 1.0


def test_conditions_combine():
    inside = (X > 0.0) & ~(X >= 1.0) | equals(X, 5.0)
    assert [interpret(inside, {X: x}) for x in (-1.0, 0.5, 1.0, 5.0)] == [0.0, 1.0, 0.0, 1.0]
    assert inside.is_condition
    assert not X.is_condition


def test_numbers_are_no_conditions():
    with pytest.raises(TypeError, match="expected a condition such as 'x > 0', got x"):
        where(X, Y, Z)
    with pytest.raises(TypeError, match="expected a condition"):
        _ = (X > 0.0) & Y


def test_only_numbers_become_constants():
    assert as_expr(np.float64(2.5)) is constant(2.5)
    assert as_expr(3) is constant(3.0)
    for wrong in ("3", None, True, [1.0]):
        with pytest.raises(TypeError, match="expected a number or an expression"):
            as_expr(wrong)


def test_exponents_are_numbers():
    assert X ** constant(2.0) is X**2
    with pytest.raises(TypeError, match=r"exp\(y \* log\(x\)\)"):
        _ = X**Y


def test_division_by_the_constant_zero_is_refused():
    with pytest.raises(ZeroDivisionError):
        _ = X / 0.0


def test_derived_functions():
    at = {X: 0.7, Y: -0.4}
    assert interpret(tan(X), at) == pytest.approx(np.tan(0.7))
    assert interpret(atan(Y), at) == pytest.approx(np.arctan(-0.4))
    assert interpret(clip(X, 0.0, 0.5), at) == 0.5
    assert interpret(clip(Y, 0.0, 0.5), at) == 0.0
    assert interpret(minimum(X, Y, 3.0), at) == -0.4
    assert interpret(maximum(X, Y, 3.0), at) == 3.0
    assert interpret(exp(X) * cos(Y), at) == pytest.approx(np.exp(0.7) * np.cos(-0.4))


def test_leaves_come_in_order_of_appearance():
    assert leaves(Y * X + Z, X) == (Y, X, Z)
    assert MINUS_ONE not in leaves(X * -1.0)


def test_postorder_lists_every_node_once_after_its_arguments():
    shared = X * Y
    order = postorder([shared + sin(shared), shared])
    assert len(order) == len(set(order))
    assert all(order.index(arg) < order.index(node) for node in order for arg in node.args)
    assert set(SYMBOLS[:2]) <= set(order)


def test_threads_that_make_the_same_symbols_share_them():
    together = Barrier(4)

    def made(turn: int) -> list[object]:
        together.wait()
        return [symbol(SymbolKind.SIGNAL, Path((f"turn_{turn}", f"x_{k}")), "m") for k in range(100)]

    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            for turn in range(40):
                first, *others = pool.map(made, [turn] * 4)
                assert all(mine is theirs for other in others for mine, theirs in zip(first, other, strict=True))
    finally:
        sys.setswitchinterval(usual)
