"""Derivatives of expressions by forward differentiation of the shared graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from propermodel.expressions.core import (
    ONE,
    ZERO,
    Expr,
    Op,
    constant,
    cos,
    divide,
    equals,
    is_zero,
    less_equal,
    multiply,
    number,
    postorder,
    power,
    sign,
    sin,
    slope,
    subtract,
    where,
)

Tangent = dict[Expr, Expr]


def local_partials(node: Expr) -> tuple[Expr, ...]:
    """The derivative of one node with respect to each of its arguments; one-sided at kinks."""
    a = node.args
    match node.op:
        case Op.ADD:
            return (ONE, ONE)
        case Op.SUBTRACT:
            return (ONE, -ONE)
        case Op.MULTIPLY:
            return (a[1], a[0])
        case Op.DIVIDE:
            return (divide(ONE, a[1]), -divide(node, a[1]))
        case Op.POWER:
            exponent = number(a[1])
            assert exponent is not None
            return (multiply(constant(exponent), power(a[0], exponent - 1.0)), ZERO)
        case Op.NEGATE:
            return (-ONE,)
        case Op.ABSOLUTE:
            return (sign(a[0]),)
        case Op.SQUARE_ROOT:
            # Infinite at zero; laws use a root of an absolute value there with a factor that vanishes.
            return (where(equals(node, ZERO), ZERO, divide(constant(0.5), node)),)
        case Op.EXPONENTIAL:
            return (node,)
        case Op.LOGARITHM:
            return (divide(ONE, a[0]),)
        case Op.SINE:
            return (cos(a[0]),)
        case Op.COSINE:
            return (-sin(a[0]),)
        case Op.TANH:
            return (subtract(ONE, multiply(node, node)),)
        case Op.ARCTANGENT:
            squared = a[0] * a[0] + a[1] * a[1]
            return (divide(a[1], squared), -divide(a[0], squared))
        case Op.MINIMUM:
            first = less_equal(a[0], a[1])
            return (where(first, ONE, ZERO), where(first, ZERO, ONE))
        case Op.MAXIMUM:
            first = less_equal(a[1], a[0])
            return (where(first, ONE, ZERO), where(first, ZERO, ONE))
        case Op.WHERE:
            return (ZERO, where(a[0], ONE, ZERO), where(a[0], ZERO, ONE))
        case Op.LOOKUP:
            return (ZERO, *(slope(a[0], axis, *a[1:]) for axis in range(len(a) - 1)))
        case _:
            # Steps (sign, floor, conditions) are flat almost everywhere; a slope is constant within its cell
            # along its own axis, and its variation along the other axis is left out of second derivatives.
            return tuple(ZERO for _ in a)


def _combine(node: Expr, tangents: list[Tangent]) -> Tangent:
    result: Tangent = {}
    if node.op is Op.WHERE:
        condition = node.args[0]
        for leaf in dict.fromkeys((*tangents[1], *tangents[2])):
            result[leaf] = where(condition, tangents[1].get(leaf, ZERO), tangents[2].get(leaf, ZERO))
        return result
    for partial, tangent in zip(local_partials(node), tangents, strict=True):
        if is_zero(partial):
            continue
        for leaf, value in tangent.items():
            term = multiply(partial, value)
            result[leaf] = result[leaf] + term if leaf in result else term
    return {leaf: value for leaf, value in result.items() if not is_zero(value)}


def partial_derivatives(roots: Iterable[Expr], wrt: Iterable[Expr]) -> list[Tangent]:
    """The non-zero derivatives of each root with respect to the given leaves."""
    roots = list(roots)
    known: dict[Expr, Tangent] = {leaf: {leaf: ONE} for leaf in wrt}
    for node in postorder(roots):
        if node in known:
            continue
        tangents = [known[arg] for arg in node.args]
        known[node] = _combine(node, tangents) if any(tangents) else {}
    return [known[root] for root in roots]


@lru_cache(maxsize=1024)
def kept_derivatives(roots: tuple[Expr, ...], wrt: tuple[Expr, ...]) -> tuple[Tangent, ...]:
    """The same, kept for those who ask again, as every design of a model does; not to be changed."""
    return tuple(partial_derivatives(roots, wrt))


def combine_tangents(node: Expr, tangents: Sequence[Sequence[Expr]]) -> tuple[Expr, ...]:
    """The derivatives of a node in several directions, from those of each of its arguments."""
    if node.op is Op.WHERE:
        return tuple(where(node.args[0], a, b) for a, b in zip(tangents[1], tangents[2], strict=True))
    if node.op in (Op.MINIMUM, Op.MAXIMUM):
        a, b = node.args
        is_first = less_equal(a, b) if node.op is Op.MINIMUM else less_equal(b, a)
        return tuple(where(is_first, x, y) for x, y in zip(tangents[0], tangents[1], strict=True))
    result = [ZERO] * len(tangents[0])
    for partial, given in zip(local_partials(node), tangents, strict=True):
        if is_zero(partial):
            continue
        for k, tangent in enumerate(given):
            if not is_zero(tangent):
                result[k] = result[k] + multiply(partial, tangent)
    return tuple(result)


def derivative(expr: Expr, leaf: Expr) -> Expr:
    """The partial derivative of an expression with respect to one leaf."""
    return partial_derivatives([expr], [leaf])[0].get(leaf, ZERO)


def directional_derivative(roots: Iterable[Expr], rates: Mapping[Expr, Expr]) -> list[Expr]:
    """The rate of change of each root when each leaf changes at its given rate."""
    roots = list(roots)
    known: dict[Expr, Expr] = dict(rates)
    for node in postorder(roots):
        if node in known:
            continue
        if all(is_zero(known[arg]) for arg in node.args):
            known[node] = ZERO
        elif node.op is Op.WHERE:
            known[node] = where(node.args[0], known[node.args[1]], known[node.args[2]])
        else:
            total = ZERO
            for partial, arg in zip(local_partials(node), node.args, strict=True):
                total = total + multiply(partial, known[arg])
            known[node] = total
    return [known[root] for root in roots]
