"""Ideal switches: laws in which a held value decides whether effort or flow vanishes.

Which states are free then depends on the switches: an open switch in series with a coil holds its current, a closed
one across a capacitor its voltage. The equations of such a block are kept with their rates. Where a position of the
switches makes some of them dependent, they say something about the states; their rates take their place, as in
Luenberger's shuffle algorithm (Time-invariant descriptor systems, Automatica 14, 1978). Numbers, the weights, say
which: they change only at events, when `simulation.switches` finds them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.diagnostics import Path
from propermodel.equations.system import BlockKind, ImplicitBlock, Switching
from propermodel.equations.unknowns import Unknown
from propermodel.expressions.core import (
    ONE,
    TIME,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    constant,
    leaves,
    symbol,
    where,
)
from propermodel.expressions.derivatives import directional_derivative, partial_derivatives

_INFINITE = constant(math.inf)


def other_way(residual: Expr, element: Path, effort: Expr, flow: Expr) -> Expr | None:
    """What the implicit law of an element says when its switch is the other way; None where it is no ideal switch.

    An ideal switch is a condition of own held values that chooses between an expression of its effort and one of its
    flow.
    """
    if residual.op is not Op.WHERE:
        return None
    condition, first, second = residual.args
    held = leaves(condition)
    if not held or any(h.data.kind is not SymbolKind.DISCRETE or h.data.path.parent != element for h in held):
        return None
    own = {effort, flow}
    mentioned = [own.intersection(leaves(branch)) for branch in (first, second)]
    if any(len(found) != 1 for found in mentioned) or mentioned[0] == mentioned[1]:
        return None
    return where(condition, second, first)


def dependences(unknowns: Sequence[Unknown], rates: Mapping[Expr, Expr]) -> list[tuple[int, int]]:
    """What switches need besides their residuals: the rates of the states in these, and one another.

    An edge (i, j) says that unknown i depends on unknown j.
    """
    index = {u.symbol: i for i, u in enumerate(unknowns)}
    switches = [i for i, u in enumerate(unknowns) if u.kind is BlockKind.SWITCH]
    found: list[tuple[int, int]] = []
    for i in switches:
        for state in _behind(i, unknowns, index):
            found += [(i, index[leaf]) for leaf in leaves(rates.get(state, ZERO)) if leaf in index]
    if len(switches) < 2:
        return found
    needs: list[set[int]] = [{index[leaf] for leaf in leaves(u.residual) if leaf in index} for u in unknowns]
    for i, j in found:
        needs[i].add(j)
    for i in switches:
        reached = _reached(i, needs)
        found += [(j, i) for j in switches if j in reached]
    return found


def _behind(start: int, unknowns: Sequence[Unknown], index: Mapping[Expr, int]) -> list[Expr]:
    """The states that the residual of a switch depends on, also through unknowns that are no switches."""
    seen = {start}
    states: dict[Expr, None] = {}
    pending = [start]
    while pending:
        unknown = unknowns[pending.pop()]
        for leaf in leaves(unknown.residual, unknown.other):
            number = index.get(leaf)
            if number is None:
                states[leaf] = None
            elif number not in seen and unknowns[number].kind is not BlockKind.SWITCH:
                seen.add(number)
                pending.append(number)
    return list(states)


def _reached(start: int, needs: Sequence[set[int]]) -> set[int]:
    seen: set[int] = set()
    pending = [start]
    while pending:
        for j in needs[pending.pop()]:
            if j not in seen:
                seen.add(j)
                pending.append(j)
    return seen


@dataclass(frozen=True)
class Switched:
    """A block with switches, its equations by themselves, and the blocks that went into it."""

    block: ImplicitBlock
    switching: Switching
    absorbed: tuple[ImplicitBlock, ...]


def switched_block(
    rows: Sequence[tuple[Unknown, Expr, Expr]], rate_of: Callable[[Expr], Expr], earlier: Sequence[ImplicitBlock]
) -> Switched:
    """The block of some unknowns with their residuals, and with what these are when the switches are the other way.

    Blocks that the residuals need are solved together with them, as rates of their unknowns are not known otherwise.
    """
    absorbed = _needed([residual for _, residual, _ in rows], earlier)
    unknowns = [u for block in absorbed for u in block.unknowns] + [unknown.symbol for unknown, _, _ in rows]
    residuals = [r for block in absorbed for r in block.residuals] + [residual for _, residual, _ in rows]
    others = [u for block in absorbed for u in block.unknowns]
    others += [other if u.kind is BlockKind.SWITCH else u.symbol for u, _, other in rows]
    paths = [path for block in absorbed for path in block.paths] + [u.element for u, _, _ in rows]
    moving = [leaf for leaf in leaves(*residuals) if leaf.data.kind is SymbolKind.STATE]
    rates = dict.fromkeys(leaves(*residuals), ZERO) | {state: rate_of(state) for state in moving} | {TIME: ONE}
    drifts = directional_derivative(residuals, rates)
    size = len(unknowns)

    def weights(name: str) -> tuple[tuple[Expr, ...], ...]:
        return tuple(
            tuple(symbol(SymbolKind.UNKNOWN, path / f"{name}_{i}_{j}", "") for j in range(size))
            for i, path in enumerate(paths)
        )

    of_residual, of_drift, of_other = (weights(f"switching_{word}") for word in ("residual", "drift", "other"))
    tolerance = tuple(symbol(SymbolKind.UNKNOWN, path / f"switching_tolerance_{i}", "") for i, path in enumerate(paths))
    weighted: list[Expr] = []
    for i in range(size):
        total, said = ZERO, ZERO
        for j in range(size):
            total = total + of_residual[i][j] * residuals[j] + of_drift[i][j] * drifts[j] + of_other[i][j] * others[j]
            said = said + of_other[i][j] * residuals[j]
        # What says nothing about states must hold by itself.
        weighted.append(total + where(abs(said) <= tolerance[i], ZERO, _INFINITE))
    return Switched(
        ImplicitBlock(
            unknowns=tuple(unknowns),
            residuals=tuple(weighted),
            jacobian=_matrix(weighted, unknowns),
            paths=tuple(paths),
        ),
        Switching(
            unknowns=tuple(unknowns),
            residuals=tuple(residuals),
            jacobian=_matrix(residuals, unknowns),
            drift_jacobian=_matrix(drifts, unknowns),
            of_residual=of_residual,
            of_drift=of_drift,
            of_other=of_other,
            tolerance=tolerance,
            paths=tuple(paths),
        ),
        tuple(absorbed),
    )


def _needed(residuals: Sequence[Expr], earlier: Sequence[ImplicitBlock]) -> list[ImplicitBlock]:
    """The earlier blocks whose unknowns the residuals mention, also those that these need, in order."""
    needed: set[ImplicitBlock] = set()
    pending = list(residuals)
    while pending:
        mentioned = set(leaves(*pending))
        more = [block for block in earlier if block not in needed and mentioned.intersection(block.unknowns)]
        needed.update(more)
        pending = [residual for block in more for residual in block.residuals]
    return [block for block in earlier if block in needed]


def _matrix(rows: Sequence[Expr], unknowns: Sequence[Expr]) -> tuple[tuple[Expr, ...], ...]:
    partials = partial_derivatives(rows, unknowns)
    return tuple(tuple(p.get(u, ZERO) for u in unknowns) for p in partials)
