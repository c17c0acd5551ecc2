"""Evaluates expressions with plain numbers: for tests, parameter values and constants."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

from propermodel.diagnostics import ModelError
from propermodel.expressions.core import Expr, Op, postorder


def _negative(a: float) -> float:
    return -a


def _sign(a: float) -> float:
    return float((a > 0) - (a < 0))


def _minimum(a: float, b: float) -> float:
    return a if a <= b else b


def _maximum(a: float, b: float) -> float:
    return a if a >= b else b


def _both(a: float, b: float) -> bool:
    return bool(a) and bool(b)


def _either(a: float, b: float) -> bool:
    return bool(a) or bool(b)


def _where(condition: float, if_true: float, if_false: float) -> float:
    return if_true if condition else if_false


FUNCTIONS: dict[Op, Callable[..., float]] = {
    Op.ADD: operator.add,
    Op.SUBTRACT: operator.sub,
    Op.MULTIPLY: operator.mul,
    Op.DIVIDE: operator.truediv,
    Op.POWER: math.pow,
    Op.NEGATE: _negative,
    Op.ABSOLUTE: math.fabs,
    Op.SIGN: _sign,
    Op.SQUARE_ROOT: math.sqrt,
    Op.EXPONENTIAL: math.exp,
    Op.LOGARITHM: math.log,
    Op.SINE: math.sin,
    Op.COSINE: math.cos,
    Op.TANH: math.tanh,
    Op.FLOOR: math.floor,
    Op.ARCTANGENT: math.atan2,
    Op.MINIMUM: _minimum,
    Op.MAXIMUM: _maximum,
    Op.LESS: operator.lt,
    Op.LESS_EQUAL: operator.le,
    Op.EQUAL: operator.eq,
    Op.AND: _both,
    Op.OR: _either,
    Op.NOT: operator.not_,
    Op.WHERE: _where,
}


def interpret(expr: Expr, values: Mapping[Expr, float] | None = None) -> float:
    """The value of an expression, given the values of its symbols.

    Raises:
        ModelError: a symbol has no value.
    """
    return expr.data[0] if expr.op is Op.CONSTANT else interpret_all([expr], values)[0]


@lru_cache(maxsize=4096)
def _order(exprs: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """The order in which expressions are computed; kept, as many designs ask for the same with other numbers."""
    return tuple(postorder(exprs))


def interpret_all(exprs: Sequence[Expr], values: Mapping[Expr, float] | None = None) -> list[float]:
    """The values of several expressions that share parts."""
    given = {} if values is None else values
    known: dict[Expr, float] = {}
    for node in _order(tuple(exprs)):
        if node in given:
            known[node] = given[node]
        elif node.op is Op.CONSTANT:
            known[node] = node.data[0]
        elif node.op in FUNCTIONS:
            known[node] = _apply(node.op, [known[arg] for arg in node.args])
        else:
            raise ModelError.of(
                "expression/no-value",
                f"'{node!r}' has no value here",
                help="give it a number, or use an expression of parameters only",
            )
    return [known[expr] for expr in exprs]


def _apply(op: Op, args: list[float]) -> float:
    try:
        return float(FUNCTIONS[op](*args))
    except (ArithmeticError, ValueError):
        # As in generated code, the branch of a `where` that is not taken may be infinite or undefined.
        return _ieee(op, args)


def _ieee(op: Op, args: list[float]) -> float:
    """What the processor gives where Python refuses: an infinity, or no number."""
    import numpy as np

    functions: dict[Op, Callable[..., np.float64]] = {
        Op.MULTIPLY: np.multiply,
        Op.DIVIDE: np.divide,
        Op.POWER: np.power,
        Op.SQUARE_ROOT: np.sqrt,
        Op.EXPONENTIAL: np.exp,
        Op.LOGARITHM: np.log,
        Op.SINE: np.sin,
        Op.COSINE: np.cos,
        Op.FLOOR: np.floor,
    }
    with np.errstate(all="ignore"):
        return float(functions[op](*args))
