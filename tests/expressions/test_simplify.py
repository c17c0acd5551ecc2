"""Simplified expressions have the value they had, and look like a textbook's."""

from __future__ import annotations

import math

import pytest
import sympy
from hypothesis import given, settings

from propermodel.diagnostics import Path
from propermodel.expressions import Expr, absolute, sqrt
from propermodel.expressions.core import SymbolKind, symbol
from propermodel.expressions.interpret import interpret
from propermodel.expressions.printing import to_text
from propermodel.expressions.simplify import simplify
from tests.expressions.strategies import SYMBOLS, Pair, expressions, pairs, points


def parameter(name: str) -> Expr:
    return symbol(SymbolKind.PARAMETER, Path((name,)))


def state(name: str) -> Expr:
    return symbol(SymbolKind.STATE, Path((name,)))


k, c, m, n, R1, R2, R3 = (parameter(name) for name in ("k", "c", "m", "n", "R1", "R2", "R3"))
x, v, w, F = (state(name) for name in "xvwF")


@settings(deadline=None, max_examples=200)
@given(expressions(kinks=False, size=10), points)
def test_the_value_is_kept(expr: Expr, point: dict[Expr, float]):
    before, after = interpret(expr, point), interpret(simplify(expr), point)
    scale = max(1.0, *(abs(interpret(part, point)) for part in expr.args), abs(before))
    assert math.isclose(before, after, rel_tol=1e-9, abs_tol=1e-9 * scale**2)


@settings(deadline=None, max_examples=60)
@given(pairs(kinks=True, size=5), points)
def test_sympy_agrees(pair: Pair, point: dict[Expr, float]):
    ours, theirs = pair
    numbers = {sympy.Symbol(str(leaf.data.path), real=True): point[leaf] for leaf in SYMBOLS}
    expected = float(sympy.sympify(theirs).subs(numbers))
    assert math.isclose(interpret(simplify(ours), point), expected, rel_tol=1e-8, abs_tol=1e-8)


@settings(deadline=None, max_examples=100)
@given(expressions(kinks=True, size=10))
def test_the_same_expression_is_always_written_alike(expr: Expr):
    assert simplify(expr) is simplify(expr)
    assert to_text(simplify(-expr + expr)) == "0"


@pytest.mark.parametrize(
    ("expr", "written"),
    [
        (-k * x - c * v + F, "F - k*x - c*v"),
        (k * x + c * (v - w) - (c * (v - w) + k * x) + F, "F"),
        (-(c * (v - w)), "c*(w - v)"),
        (R1 * v + R2 * v, "(R1 + R2)*v"),
        ((F - v) / R1 - v / R2, "(F - v)/R1 - v/R2"),
        (1.0 / (1.0 / R1 + 1.0 / (R2 + R3)), "R1*(R2 + R3)/(R1 + R2 + R3)"),
        (F / (1.0 + n * k * n / m), "m*F/(n**2*k + m)"),
        (F - n * n * k * F / (m + n * n * k), "m*F/(n**2*k + m)"),
        (R1 / (R1 + R2) + R2 / (R1 + R2), "1"),
        (c * (v - w) * absolute(v - w), "c*abs(v - w)*(v - w)"),
        (0.5 * c * v * v, "c*v**2/2"),
        (c * v / (1.0 + k * absolute(v)), "c*v/(1 + k*abs(v))"),
        (sqrt(x + x), "sqrt(2*x)"),
        (0.1 * x + 0.2 * x - 0.3 * x, "0"),
    ],
)
def test_it_looks_like_a_textbook(expr: Expr, written: str):
    assert to_text(simplify(expr)) == written


def test_equal_sums_cancel_however_they_were_built():
    assert simplify((R1 + R2 - v) / (R2 - v + R1)) is simplify(parameter("a") / parameter("a"))
    assert to_text(simplify((v - w) * k / (w - v))) == "-k"
