"""Text of expressions: read back by Python it gives the same value, with few brackets."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings

from propermodel.diagnostics import Path
from propermodel.expressions import absolute, minimum, sin, where
from propermodel.expressions.core import SymbolKind, constant, lookup, slope, symbol
from propermodel.expressions.interpret import interpret
from propermodel.expressions.printing import format_number, to_text
from tests.expressions.strategies import X, Y, Z, expressions, points


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (X + Y - Z, "x + y - z"),
        (X - (Y - Z), "x - (y - z)"),
        (X - (Y + Z), "x - (y + z)"),
        (X * Y / Z, "x*y/z"),
        (X / (Y * Z), "x/(y*z)"),
        (X * (Y / Z), "x*y/z"),
        ((X + Y) * Z, "(x + y)*z"),
        (-(X + Y), "-(x + y)"),
        (-X * Y, "-x*y"),
        ((-X) ** 2, "(-x)**2"),
        (X**-2, "x**(-2)"),
        ((X**2) ** 3, "(x**2)**3"),
        (2.5 * X, "2.5*x"),
        (1e-9 * X, "1e-09*x"),
        (X * constant(3.0, "N"), "x*3 N"),
        (constant(3.0, "N") ** 2, "(3 N)**2"),
        (absolute(sin(X)), "abs(sin(x))"),
        (minimum(X, 2.0), "min(x, 2)"),
        (where(X > 0.0, Y, Z), "where(0 < x, y, z)"),
        ((X < 0.0) & ((Y < 0.0) | (Z < 1.0)), "x < 0 and (y < 0 or z < 1)"),
        (~(X < 0.0), "not x < 0"),
    ],
)
def test_text_of_an_expression(expr, text):
    assert to_text(expr) == text
    assert repr(expr) == text


def test_text_of_tables():
    table = symbol(SymbolKind.TABLE, Path(("engine", "map")), "N.m")
    assert to_text(lookup(table, X, Y)) == "engine.map(x, y)"
    assert to_text(slope(table, 1, X, Y)) == "dengine.map/d1(x, y)"


def test_names_stand_for_subexpressions():
    shared = X * Y
    assert to_text(shared + sin(shared), {shared: "torque"}) == "torque + sin(torque)"


PYTHON = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tanh", "exp", "sqrt", "atan2")},
    "abs": abs,
    "min": min,
    "max": max,
    "sign": lambda x: float((x > 0) - (x < 0)),
    "where": lambda c, a, b: a if c else b,
}


@given(expressions(), points)
@settings(max_examples=200)
def test_text_read_by_python_has_the_same_value(expr, point):
    names = {str(leaf.data.path): value for leaf, value in point.items()}
    value = eval(to_text(expr), {"__builtins__": {}}, {**PYTHON, **names})
    assert float(value) == pytest.approx(interpret(expr, point), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.0, "1"), (-3.0, "-3"), (0.1, "0.1"), (1e20, "1e+20"), (2.0**53, "9007199254740992.0"), (math.inf, "inf")],
)
def test_numbers_are_short_and_exact(value, text):
    assert format_number(value) == text
    assert float(text) == value


def test_text_of_a_deep_expression():
    chain = X
    for _ in range(3000):
        chain = sin(chain)
    assert to_text(chain).count("sin(") == 3000


def test_an_expression_whose_shared_parts_would_never_end_is_described() -> None:
    x = symbol(SymbolKind.STATE, Path(("x",)), "1")
    for _ in range(200):
        x = x * x + 1.0
    assert repr(x) == "<expression of 402 nodes with 1 symbols>"
