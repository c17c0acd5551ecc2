"""Evaluates expressions with plain numbers: for tests, parameter values and constants."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from propermodel.diagnostics import ModelError
from propermodel.expressions.core import Expr, Op, postorder

FUNCTIONS: dict[Op, Callable[..., float]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUBTRACT: lambda a, b: a - b,
    Op.MULTIPLY: lambda a, b: a * b,
    Op.DIVIDE: lambda a, b: a / b,
    Op.POWER: lambda a, b: a**b,
    Op.NEGATE: lambda a: -a,
    Op.ABSOLUTE: abs,
    Op.SIGN: lambda a: float((a > 0) - (a < 0)),
    Op.SQUARE_ROOT: math.sqrt,
    Op.EXPONENTIAL: math.exp,
    Op.LOGARITHM: math.log,
    Op.SINE: math.sin,
    Op.COSINE: math.cos,
    Op.TANH: math.tanh,
    Op.FLOOR: math.floor,
    Op.ARCTANGENT: math.atan2,
    Op.MINIMUM: lambda a, b: a if a <= b else b,
    Op.MAXIMUM: lambda a, b: a if a >= b else b,
    Op.LESS: lambda a, b: float(a < b),
    Op.LESS_EQUAL: lambda a, b: float(a <= b),
    Op.EQUAL: lambda a, b: float(a == b),
    Op.AND: lambda a, b: float(bool(a) and bool(b)),
    Op.OR: lambda a, b: float(bool(a) or bool(b)),
    Op.NOT: lambda a: float(not a),
    Op.WHERE: lambda c, a, b: a if c else b,
}


def interpret(expr: Expr, values: Mapping[Expr, float] | None = None) -> float:
    """The value of an expression, given the values of its symbols.

    Raises:
        ModelError: a symbol has no value.
    """
    return interpret_all([expr], values)[0]


def interpret_all(exprs: Sequence[Expr], values: Mapping[Expr, float] | None = None) -> list[float]:
    """The values of several expressions that share parts."""
    known: dict[Expr, float] = dict(values or {})
    for node in postorder(exprs):
        if node in known:
            continue
        if node.op is Op.CONSTANT:
            known[node] = node.data[0]
        elif node.op in FUNCTIONS:
            known[node] = float(FUNCTIONS[node.op](*(known[arg] for arg in node.args)))
        else:
            raise ModelError.of(
                "expression/no-value",
                f"'{node!r}' has no value here",
                help="give it a number, or use an expression of parameters only",
            )
    return [known[expr] for expr in exprs]
