"""Immutable scalar expressions, tables, derivatives and units."""

from propermodel.expressions.core import (
    TIME as time,
)
from propermodel.expressions.core import (
    Expr,
    ExprLike,
    absolute,
    atan,
    atan2,
    clip,
    cos,
    equals,
    exp,
    floor,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
    where,
)

__all__ = [
    "Expr",
    "ExprLike",
    "absolute",
    "atan",
    "atan2",
    "clip",
    "cos",
    "equals",
    "exp",
    "floor",
    "log",
    "maximum",
    "minimum",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
    "time",
    "where",
]
