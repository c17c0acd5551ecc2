"""Whether a dependence cancels: what appears in an expression need not matter to it.

A gyrator whose two sides share one flow adds its effort once with each sign. No rewriting rule catches all such
cases; an expression that vanishes at random values of all its symbols vanishes identically.
"""

from __future__ import annotations

import math
from random import Random

from propermodel.expressions.core import Expr, Op, is_zero, leaves, postorder
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.expressions.interpret import interpret, interpret_all

# Values of symbols: positive, so that roots and logarithms exist.
_LOW, _HIGH = 0.6, 1.4
_POINTS = 3
# Sums that cancel leave this share of their terms, by rounding.
_ROUNDING = 1e-11


def is_independent(expr: Expr, leaf: Expr) -> bool:
    """Whether an expression does not change with one of its symbols, though it mentions it."""
    slope = partial_derivatives([expr], [leaf])[0].get(leaf)
    if slope is None or is_zero(slope):
        return True
    order = postorder([slope])
    if any(node.op in (Op.LOOKUP, Op.SLOPE) for node in order):
        return False
    random = Random(len(order))  # the same model gives the same equations
    for _ in range(_POINTS):
        given = {symbol: random.uniform(_LOW, _HIGH) for symbol in leaves(slope)}
        terms = [arg for node in order if node.op in (Op.ADD, Op.SUBTRACT) for arg in node.args]
        scale = max((abs(x) for x in interpret_all(terms, given) if math.isfinite(x)), default=1.0)
        value = interpret(slope, given)
        if not abs(value) <= _ROUNDING * scale:
            return False
    return True
