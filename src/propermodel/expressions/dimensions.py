"""Dimensional consistency of expressions. The dimension None is that of zero, which fits any."""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.expressions.core import CONDITIONS, Expr, Op, is_zero, number, postorder
from propermodel.expressions.printing import to_text
from propermodel.expressions.units import DIMENSIONLESS, Dimension, dimension_text, parse_unit


def _scaled(dimension: Dimension, power: float) -> Dimension:
    return tuple((name, p * power) for name, p in dimension if p * power)


def product(a: Dimension, b: Dimension, sign: float = 1.0) -> Dimension:
    """The dimension of a product, or with the sign -1 of a quotient."""
    powers = dict(a)
    for name, p in b:
        powers[name] = powers.get(name, 0.0) + sign * p
    return tuple(sorted((name, p) for name, p in powers.items() if abs(p) > 1e-12))


class DimensionMismatch(Exception):
    """Two things that must have one dimension have not; the text says which."""


def _same(node: Expr, dimensions: list[Dimension | None]) -> Dimension | None:
    known = [d for d in dimensions if d is not None]
    if any(d != known[0] for d in known):
        texts = " and ".join(dimension_text(d) for d in known)
        raise DimensionMismatch(f"'{to_text(node)}' combines {texts}")
    return known[0] if known else None


def _dimensionless(node: Expr, dimensions: list[Dimension | None]) -> Dimension:
    for d in dimensions:
        if d is not None and d != DIMENSIONLESS:
            raise DimensionMismatch(f"the argument of '{to_text(node)}' is not dimensionless but {dimension_text(d)}")
    return DIMENSIONLESS


def dimension_of(root: Expr, leaf_units: Mapping[Expr, str] | None = None) -> Dimension | None:
    """The dimension of an expression; None when it is zero and fits any.

    Raises:
        DimensionMismatch: a sum, comparison or function inside mixes dimensions.
    """
    known: dict[Expr, Dimension | None] = {}
    for node in postorder([root]):
        known[node] = _node_dimension(node, [known[arg] for arg in node.args], leaf_units or {})
    return known[root]


def _node_dimension(node: Expr, args: list[Dimension | None], leaf_units: Mapping[Expr, str]) -> Dimension | None:
    if is_zero(node):
        return None
    match node.op:
        case Op.CONSTANT:
            return parse_unit(node.data[1]).dimension
        case Op.SYMBOL:
            return parse_unit(leaf_units.get(node, node.data.unit)).dimension
        case Op.ADD | Op.SUBTRACT | Op.MINIMUM | Op.MAXIMUM | Op.LESS | Op.LESS_EQUAL | Op.EQUAL:
            result = _same(node, args)
            return DIMENSIONLESS if node.op in CONDITIONS else result
        case Op.WHERE:
            return _same(node, args[1:])
        case Op.MULTIPLY:
            return None if args[0] is None or args[1] is None else product(args[0], args[1])
        case Op.DIVIDE:
            return None if args[0] is None else product(args[0], args[1] or (), -1.0)
        case Op.POWER:
            return None if args[0] is None else _scaled(args[0], number(node.args[1]) or 0.0)
        case Op.SQUARE_ROOT:
            return None if args[0] is None else _scaled(args[0], 0.5)
        case Op.NEGATE | Op.ABSOLUTE | Op.FLOOR:
            return args[0]
        case Op.ARCTANGENT:
            _same(node, args)
            return DIMENSIONLESS
        case Op.LOOKUP | Op.SLOPE:
            units: tuple[str, ...] = getattr(node.args[0].data, "coordinate_units", ())
            for given, unit in zip(args[1:], units, strict=False):
                if given is not None and given != parse_unit(unit).dimension:
                    raise DimensionMismatch(
                        f"'{to_text(node)}' looks up {dimension_text(given)} on a grid in {unit or '1'}"
                    )
            return args[0] if node.op is Op.LOOKUP else None
        case Op.SIGN:
            return DIMENSIONLESS
        case _:
            return _dimensionless(node, args)
