"""Random expressions of three symbols, built by the operators as an author would."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy
from hypothesis import strategies as st

from propermodel.diagnostics import Path
from propermodel.expressions import (
    Expr,
    absolute,
    atan2,
    cos,
    exp,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tanh,
    where,
)
from propermodel.expressions.core import SymbolKind, as_expr, symbol

X, Y, Z = (symbol(SymbolKind.PARAMETER, Path((name,))) for name in "xyz")
SYMBOLS = (X, Y, Z)
SYMPY = {leaf: sympy.Symbol(str(leaf.data.path), real=True) for leaf in SYMBOLS}

Pair = tuple[Expr, Any]

# Each function stays finite for any argument; the pairs are ours and SymPy's.
UNARY: list[tuple[Callable[[Any], Any], Callable[[Any], Any]]] = [
    (lambda a: -a, lambda a: -a),
    (sin, sympy.sin),
    (cos, sympy.cos),
    (tanh, sympy.tanh),
    (lambda a: exp(tanh(a)), lambda a: sympy.exp(sympy.tanh(a))),
    (lambda a: sqrt(1.0 + a * a), lambda a: sympy.sqrt(1 + a * a)),
    (lambda a: a**2, lambda a: a**2),
    (lambda a: (1.0 + a * a) ** -1.5, lambda a: (1 + a * a) ** sympy.Rational(-3, 2)),
]
KINKED: list[tuple[Callable[[Any], Any], Callable[[Any], Any]]] = [
    (absolute, sympy.Abs),
    (sign, sympy.sign),
]
BINARY: list[tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = [
    (lambda a, b: a + b, lambda a, b: a + b),
    (lambda a, b: a - b, lambda a, b: a - b),
    (lambda a, b: a * b, lambda a, b: a * b),
    (lambda a, b: a / (1.0 + b * b), lambda a, b: a / (1 + b * b)),
    (lambda a, b: atan2(a, 2.0 + sin(b)), lambda a, b: sympy.atan2(a, 2 + sympy.sin(b))),
]
KINKED_BINARY: list[tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = [
    (minimum, sympy.Min),
    (maximum, sympy.Max),
    (lambda a, b: where(as_expr(a) < b, a, b * 2.0), lambda a, b: sympy.Piecewise((a, a < b), (2 * b, True))),
]


def pairs(kinks: bool, size: int = 6) -> st.SearchStrategy[Pair]:
    """An expression and the same of SymPy."""
    leaves = st.one_of(
        st.sampled_from([(leaf, SYMPY[leaf]) for leaf in SYMBOLS]),
        st.sampled_from([-1.0, 0.0, 0.5, 1.0, 2.0]).map(lambda c: (as_expr(c), sympy.Float(c))),
    )
    unary = UNARY + (KINKED if kinks else [])
    binary = BINARY + (KINKED_BINARY if kinks else [])

    def extend(inner: st.SearchStrategy[Pair]) -> st.SearchStrategy[Pair]:
        return st.one_of(
            st.builds(lambda f, a: (f[0](a[0]), f[1](a[1])), st.sampled_from(unary), inner),
            st.builds(lambda f, a, b: (f[0](a[0], b[0]), f[1](a[1], b[1])), st.sampled_from(binary), inner, inner),
        )

    return st.recursive(leaves, extend, max_leaves=size)


def expressions(kinks: bool = True, size: int = 8) -> st.SearchStrategy[Expr]:
    """An expression alone."""
    return pairs(kinks, size).map(lambda pair: pair[0])


points = st.tuples(*(st.floats(-2.0, 2.0).map(lambda v: v + 1e-3) for _ in SYMBOLS)).map(
    lambda values: dict(zip(SYMBOLS, values, strict=True))
)
