"""Derivatives by elimination are those of forward differentiation, for less."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.expressions import Expr, log, sin, where
from propermodel.expressions.core import ONE, ZERO, Op, as_expr, postorder
from propermodel.expressions.derivatives import Tangent, partial_derivatives
from propermodel.expressions.interpret import interpret
from propermodel.expressions.jacobian import accumulated_derivatives
from tests.expressions.strategies import SYMBOLS, X, Y, Z, expressions, points


@given(roots=st.lists(expressions(), min_size=1, max_size=4), at=points)
@settings(max_examples=100)
def test_both_ways_of_differentiation_agree(roots: list[Expr], at: dict[Expr, float]) -> None:
    roots.append(roots[0] * roots[-1] + sin(roots[0]))  # one that depends on the others
    ours, theirs = accumulated_derivatives(roots, SYMBOLS), partial_derivatives(roots, SYMBOLS)
    for mine, other in zip(ours, theirs, strict=True):
        for leaf in SYMBOLS:
            expected = interpret(other.get(leaf, ZERO), at)
            assert interpret(mine.get(leaf, ZERO), at) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_root_may_be_a_leaf_or_know_nothing_of_the_leaves() -> None:
    assert accumulated_derivatives([X, as_expr(3.0), Z], [X, Y]) == [{X: ONE}, {}, {}]


def test_what_a_condition_leaves_out_may_be_infinite() -> None:
    (tangent,) = accumulated_derivatives([where(X > 0.0, 2.0 * log(X), 3.0 * X)], [X])
    # The slope of the branch that is left out is chosen away, not multiplied by zero.
    assert tangent[X].op is Op.WHERE
    assert tangent[X].args[2] is as_expr(3.0)


def test_what_many_paths_share_is_multiplied_once() -> None:
    # From three leaves through a chain of twenty nodes: one product for each node, and three at the end.
    root = X + Y + Z
    for _ in range(20):
        root = sin(root)
    (mine,), (other,) = (way([root], SYMBOLS) for way in (accumulated_derivatives, partial_derivatives))
    assert _products(mine) == 19
    assert _products(other) == 19  # the three rows are alike, so they are one
    uneven = X * Y + Y * Z + Z * X
    for _ in range(20):
        uneven = sin(uneven)
    (mine,), (other,) = (way([uneven], SYMBOLS) for way in (accumulated_derivatives, partial_derivatives))
    assert _products(mine) == 19 + 3
    assert _products(other) == 20 * 3


def _products(tangent: Tangent) -> int:
    nodes = postorder(tangent.values())
    inside = set(postorder([X * Y + Y * Z + Z * X]))
    return sum(1 for node in nodes if node.op is Op.MULTIPLY and node not in inside)
