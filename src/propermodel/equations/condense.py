"""Fewer unknowns for Newton's method: what nonlinear operations see of a block is often less than its unknowns.

Several inertias that act on one shaft enter a lossy gear only through the torque they transmit together. Such a
quantity is affine in the unknowns; made an unknown itself, it leaves the others to exact elimination.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from propermodel.diagnostics import Path, StructureError
from propermodel.equations.solve import eliminate
from propermodel.expressions.core import (
    Expr,
    Op,
    Substitution,
    SymbolKind,
    constant,
    leaves,
    postorder,
    rebuild,
    symbol,
)
from propermodel.expressions.derivatives import partial_derivatives


@dataclass(frozen=True)
class Condensed:
    """A smaller block, and the unknowns that follow from its solution."""

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    eliminated: dict[Expr, Expr]


def condense(unknowns: Sequence[Expr], residuals: Sequence[Expr]) -> Condensed | None:
    """The block in the quantities that nonlinear operations see; None where these are not fewer."""
    bases = _seen_by_nonlinear(unknowns, residuals)
    inside = set(unknowns)
    if not bases or len(bases) >= len(unknowns):
        return None
    transmitted = {
        base: symbol(SymbolKind.UNKNOWN, Path((*unknowns[0].data.path, f"transmitted_{number}")), "")
        for number, base in enumerate(base for base in bases if base not in inside)
    }
    kept = [i for i, unknown in enumerate(unknowns) if unknown in bases]
    gone = [i for i in range(len(unknowns)) if i not in kept]
    substitute = Substitution(transmitted)
    rewritten = [substitute(residual) for residual in residuals]
    definitions = [
        w - rebuild(base.op, [substitute(arg) for arg in base.args], base.data) for base, w in transmitted.items()
    ]
    symbols = [unknowns[i] for i in gone]
    partials = partial_derivatives([rewritten[i] for i in gone], symbols)
    matrix = [[p.get(s, constant(0.0)) for s in symbols] for p in partials]
    varying = inside | set(transmitted.values())
    if any(leaf in varying for row in matrix for entry in row for leaf in leaves(entry)):
        return None
    at_zero = Substitution({s: constant(0.0) for s in symbols})
    try:
        values = eliminate(matrix, [-at_zero(rewritten[i]) for i in gone], [s.data.path for s in symbols])
    except StructureError:
        # The residuals of what would go do not determine it alone; the block stays as it is.
        return None
    eliminated = dict(zip(symbols, values, strict=True))
    finish = Substitution(eliminated)
    return Condensed(
        unknowns=(*(unknowns[i] for i in kept), *transmitted.values()),
        residuals=tuple(finish(r) for r in (*(rewritten[i] for i in kept), *definitions)),
        eliminated=eliminated,
    )


def _seen_by_nonlinear(unknowns: Sequence[Expr], residuals: Sequence[Expr]) -> list[Expr]:
    """The expressions that enter nonlinear operations, freed of factors and terms without unknowns; in order.

    They are found one by one: what only depends on those found before is no new quantity.
    """
    order = postorder(residuals)
    depends: dict[Expr, bool] = dict.fromkeys(unknowns, True)
    for node in order:
        depends.setdefault(node, any(depends[arg] for arg in node.args))
    bases: list[Expr] = []
    while len(bases) < len(unknowns):
        found = _next_seen(unknowns, order, depends, bases)
        if found is None:
            break
        bases.append(found)
    return bases


def _next_seen(
    unknowns: Sequence[Expr], order: list[Expr], depends: dict[Expr, bool], bases: list[Expr]
) -> Expr | None:
    direct: dict[Expr, bool] = {unknown: unknown not in bases for unknown in unknowns}
    for node in order:
        if node in direct:
            continue
        if node in bases or not depends[node]:
            direct[node] = False
        elif _is_affine(node, depends):
            direct[node] = any(direct[arg] for arg in node.args)
        else:
            seen = next((arg for arg in node.args if direct[arg]), None)
            if seen is not None:
                return _base(seen, depends)
            direct[node] = False
    return None


def _is_affine(node: Expr, depends: dict[Expr, bool]) -> bool:
    """Whether a node is affine in its arguments that depend on unknowns."""
    match node.op:
        case Op.ADD | Op.SUBTRACT | Op.NEGATE:
            return True
        case Op.MULTIPLY:
            return not all(depends[arg] for arg in node.args)
        case Op.DIVIDE:
            return not depends[node.args[1]]
        case Op.WHERE:
            return not depends[node.args[0]]
        case _:
            return False


def _base(node: Expr, depends: dict[Expr, bool]) -> Expr:
    while True:
        moving = [arg for arg in node.args if depends[arg]]
        if node.op in (Op.ADD, Op.SUBTRACT, Op.NEGATE, Op.MULTIPLY, Op.DIVIDE) and len(moving) == 1:
            node = moving[0]
        else:
            return node
