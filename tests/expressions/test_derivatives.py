"""Derivatives against SymPy and against difference quotients."""

from __future__ import annotations

import math

import pytest
import sympy
from hypothesis import assume, given, settings

from propermodel.diagnostics import Path
from propermodel.expressions import Expr, absolute, exp, floor, log, maximum, minimum, sign, sqrt, where
from propermodel.expressions.core import (
    ONE,
    ZERO,
    SymbolKind,
    as_expr,
    equals,
    is_zero,
    lookup,
    postorder,
    slope,
    symbol,
)
from propermodel.expressions.derivatives import derivative, directional_derivative, partial_derivatives
from propermodel.expressions.interpret import interpret
from tests.expressions.strategies import SYMBOLS, SYMPY, X, Y, Z, expressions, pairs, points


@given(pairs(kinks=False), points)
@settings(max_examples=60)
def test_derivatives_are_those_of_sympy(pair, point):
    ours, theirs = pair
    values = {SYMPY[leaf]: value for leaf, value in point.items()}
    for leaf in SYMBOLS:
        expected = float(sympy.diff(theirs, SYMPY[leaf]).evalf(20, subs=values))
        assert interpret(derivative(ours, leaf), point) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@given(expressions(), points)
@settings(max_examples=200)
def test_derivatives_are_limits_of_difference_quotients(expr, point):
    for leaf in SYMBOLS:

        def quotient(h: float, leaf: Expr = leaf) -> float:
            return (interpret(expr, {**point, leaf: point[leaf] + h}) - interpret(expr, point)) / h

        # At a kink or jump, or near one, the two sides do not agree.
        right, left = quotient(1e-6), quotient(-1e-6)
        assume(math.isclose(right, left, rel_tol=1e-3, abs_tol=1e-4))
        assert interpret(derivative(expr, leaf), point) == pytest.approx((right + left) / 2, rel=1e-3, abs=1e-4)


@given(expressions(), points)
@settings(max_examples=100)
def test_directional_derivative_is_the_sum_of_partials_times_rates(expr, point):
    rates = {X: Y, Y: as_expr(2.0), Z: ZERO}
    partials = partial_derivatives([expr], SYMBOLS)[0]
    total = sum(interpret(partials.get(s, ZERO), point) * interpret(r, point) for s, r in rates.items())
    assert interpret(directional_derivative([expr], rates)[0], point) == pytest.approx(total, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("expr", "at", "slope_there"),
    [
        (exp(X), 0.5, math.exp(0.5)),
        (log(X), 0.5, 2.0),
        (sqrt(X), 0.25, 1.0),
        (X**3, 2.0, 12.0),
        (X**-2, 2.0, -0.25),
        (X**0.5, 4.0, 0.25),
        (absolute(X), -3.0, -1.0),
        (X * absolute(X), -3.0, 6.0),
        (sign(X), 1.0, 0.0),
        (floor(X), 1.5, 0.0),
        (minimum(X, 2.0 * X), 1.0, 1.0),
        (maximum(X, 2.0 * X), 1.0, 2.0),
        (where(X > 1.0, X * X, 3.0 * X), 2.0, 4.0),
        (where(X > 1.0, X * X, 3.0 * X), 0.5, 3.0),
    ],
)
def test_derivative_of_one_function(expr, at, slope_there):
    assert interpret(derivative(expr, X), {X: at}) == pytest.approx(slope_there)


def test_second_derivative():
    twice = derivative(derivative(X**4 + X * Y, X), X)
    assert interpret(twice, {X: 2.0, Y: 5.0}) == pytest.approx(12 * 4)


def test_derivative_with_respect_to_what_is_not_there_is_zero():
    assert is_zero(derivative(X * X, Y))
    assert partial_derivatives([X * X], [X, Y]) == [{X: derivative(X * X, X)}]


def test_root_of_an_absolute_value_has_a_finite_slope_where_it_vanishes():
    # The turbulent law sign(x) sqrt(|x|) is evaluated at rest, where its slope is infinite.
    law = sign(X) * sqrt(absolute(X))
    assert interpret(derivative(law, X), {X: 0.0}) == 0.0


def test_value_not_taken_is_not_differentiated_into_nonsense():
    law = where(X > 0.0, sqrt(X), ZERO)
    assert interpret(where(equals(X, 0.0), ONE, derivative(law, X)), {X: 0.0}) == 1.0


def test_derivative_of_a_table_is_its_slope_times_the_inner_derivative():
    table = symbol(SymbolKind.TABLE, Path(("map",)), "N")
    value = lookup(table, X * 2.0, Y)
    first, second = partial_derivatives([value], [X, Y])[0].values()
    assert first is slope(table, 0, X * 2.0, Y) * 2.0
    assert second is slope(table, 1, X * 2.0, Y)


def test_deep_expressions_meet_no_recursion_limit():
    chain = X
    for _ in range(3000):
        chain = chain * Y + Z
    slopes = partial_derivatives([chain], SYMBOLS)[0]
    point = {X: 1.0, Y: 1.0, Z: 2.0}
    assert interpret(chain, point) == 6001.0
    assert interpret(slopes[X], point) == 1.0
    assert interpret(slopes[Z], point) == 3000.0
    assert interpret(slopes[Y], point) == 3000.0 * (1.0 + 2999.0)


def test_derivatives_share_what_they_have_in_common():
    # Forward differentiation of a chain of n products needs a multiple of n nodes, not of n squared or 2**n.
    def size(n: int) -> int:
        chain = X
        for _ in range(n):
            chain = chain * chain
        return len(postorder([derivative(chain, X)]))

    assert size(40) <= 2.2 * size(20)
