"""Plain evaluation."""

from __future__ import annotations

import math

import pytest

from propermodel.diagnostics import ModelError
from propermodel.expressions import atan2, cos, exp, floor, log, maximum, minimum, sign, sin, sqrt, tanh, where
from propermodel.expressions.interpret import interpret, interpret_all
from tests.expressions.strategies import X, Y


@pytest.mark.parametrize(
    ("expr", "expected"),
    [
        (X + Y, 0.3 - 1.7),
        (X - Y, 0.3 + 1.7),
        (X * Y, 0.3 * -1.7),
        (X / Y, 0.3 / -1.7),
        (X**2.5, 0.3**2.5),
        (-X, -0.3),
        (abs(Y), 1.7),
        (sign(Y), -1.0),
        (sqrt(X), math.sqrt(0.3)),
        (exp(Y), math.exp(-1.7)),
        (log(X), math.log(0.3)),
        (sin(Y), math.sin(-1.7)),
        (cos(Y), math.cos(-1.7)),
        (tanh(Y), math.tanh(-1.7)),
        (atan2(Y, X), math.atan2(-1.7, 0.3)),
        (floor(Y), -2.0),
        (minimum(X, Y), -1.7),
        (maximum(X, Y), 0.3),
        (where((X > 0.0) & (Y <= -1.7), X, Y), 0.3),
        (where((X < 0.0) | ~(Y < 0.0), X, Y), -1.7),
    ],
)
def test_every_operation(expr, expected):
    assert interpret(expr, {X: 0.3, Y: -1.7}) == pytest.approx(expected, rel=1e-15)


def test_several_at_once():
    assert interpret_all([X + Y, X * Y, X], {X: 2.0, Y: 3.0}) == [5.0, 6.0, 2.0]


def test_subexpression_may_be_given():
    assert interpret(sin(X * Y) + 1.0, {sin(X * Y): 4.0, X: 0.0, Y: 0.0}) == 5.0


def test_symbol_without_a_value():
    with pytest.raises(ModelError) as caught:
        interpret(X + Y, {X: 1.0})
    assert str(caught.value) == (
        "error[expression/no-value]: 'y' has no value here\n"
        "  help: give it a number, or use an expression of parameters only"
    )


@pytest.mark.parametrize(
    ("expr", "value"),
    [
        (1.0 / X, math.inf),
        (-1.0 / X, -math.inf),
        (log(X), -math.inf),
        (X**-2, math.inf),
        (exp(X + 1000.0), math.inf),
        (floor(1.0 / X), math.inf),
    ],
)
def test_infinite_values_are_those_of_the_processor(expr, value):
    assert interpret(expr, {X: 0.0}) == value


@pytest.mark.parametrize("expr", [sqrt(X - 1.0), log(X - 1.0), (X - 1.0) ** 0.5, X / abs(X), sin(1.0 / X)])
def test_undefined_values_are_not_numbers(expr):
    assert math.isnan(interpret(expr, {X: 0.0}))
    assert interpret(where(Y > 0.0, expr, 3.0), {X: 0.0, Y: -1.0}) == 3.0
