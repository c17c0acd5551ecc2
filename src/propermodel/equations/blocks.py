"""The implicit part in blocks: linear ones are eliminated, the others are left to Newton's method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from propermodel.causality.graph_algorithms import strong_components
from propermodel.diagnostics import Faults
from propermodel.equations.condense import condense
from propermodel.equations.solve import eliminate
from propermodel.equations.switching import dependences, switched_block
from propermodel.equations.system import BlockKind, ImplicitBlock, SolvedBlock, Switching
from propermodel.equations.unknowns import Unknown
from propermodel.expressions.core import Expr, Substitution, constant, is_zero, leaves
from propermodel.expressions.derivatives import partial_derivatives


@dataclass
class Blocks:
    """The implicit part in the order in which it is solved; `solution` has what is eliminated."""

    solved: list[SolvedBlock] = field(default_factory=list[SolvedBlock])
    implicit: list[ImplicitBlock] = field(default_factory=list[ImplicitBlock])
    switching: list[Switching] = field(default_factory=list[Switching])
    solution: dict[Expr, Expr] = field(default_factory=dict[Expr, Expr])


def solve_blocks(unknowns: list[Unknown], rates: Mapping[Expr, Expr], faults: Faults) -> Blocks:
    """Sort the unknowns into blocks; eliminate linear ones, leave the others to Newton's method.

    Args:
        unknowns: The unknowns of the implicit part.
        rates: The rate of every state, and of time, in terms of states and unknowns.
        faults: Where blocks that are singular by structure are told.
    """
    index = {u.symbol: i for i, u in enumerate(unknowns)}
    edges = [(i, index[leaf]) for i, u in enumerate(unknowns) for leaf in leaves(u.residual) if leaf in index]
    edges += dependences(unknowns, rates)
    found = Blocks()
    for component in strong_components(len(unknowns), edges):
        members = [unknowns[i] for i in component]
        with faults.collecting():
            if any(u.kind is BlockKind.SWITCH for u in members):
                _add_switched(found, members, rates)
            else:
                _add(found, members)
    return found


def _add(found: Blocks, members: list[Unknown]) -> None:
    symbols = [u.symbol for u in members]
    substitute = Substitution(found.solution)
    residuals = [substitute(u.residual) for u in members]
    matrix = jacobian(residuals, symbols)
    paths = tuple(u.element for u in members)
    inside = set(symbols)
    is_open = any(u.kind is BlockKind.CONSTRAINT for u in members)
    if is_open or any(inside & set(leaves(entry)) for row in matrix for entry in row):
        block, eliminated = _reduce_block(members, residuals, matrix)
        _keep(found, members, block, eliminated, _stubborn(members, matrix), matrix)
        return
    at_zero = Substitution(dict.fromkeys(symbols, constant(0.0)))
    right = [-at_zero(residual) for residual in residuals]
    values = eliminate(matrix, right, list(paths))
    found.solution.update(zip(symbols, values, strict=True))
    found.solved.append(
        SolvedBlock(
            unknowns=tuple(symbols),
            paths=paths,
            kinds=tuple(u.kind for u in members),
            matrix=tuple(tuple(row) for row in matrix),
        )
    )


def _keep(
    found: Blocks,
    members: list[Unknown],
    block: ImplicitBlock,
    eliminated: dict[Expr, Expr],
    stubborn: set[int],
    matrix: list[list[Expr]],
) -> None:
    found.solution.update(eliminated)
    found.implicit.append(block)
    inner = [u for u in members if u.symbol in eliminated]
    if inner:
        linear = [i for i in range(len(members)) if i not in stubborn]
        found.solved.append(
            SolvedBlock(
                unknowns=tuple(u.symbol for u in inner),
                paths=tuple(u.element for u in inner),
                kinds=tuple(u.kind for u in inner),
                matrix=tuple(tuple(matrix[i][j] for j in linear) for i in linear),
            )
        )


def _add_switched(found: Blocks, members: list[Unknown], rates: Mapping[Expr, Expr]) -> None:
    """Keep switches and what is nonlinear, with the blocks that their residuals need, and eliminate the rest."""
    substitute = Substitution(found.solution)
    symbols = [u.symbol for u in members]
    residuals = [substitute(u.residual) for u in members]
    matrix = jacobian(residuals, symbols)
    stubborn = _stubborn(members, matrix) | {i for i, u in enumerate(members) if u.kind is BlockKind.SWITCH}
    keep = sorted(stubborn)
    eliminated = _eliminated(members, residuals, matrix, keep)
    finish = Substitution(eliminated)
    switched = switched_block(
        [(members[i], finish(residuals[i]), finish(substitute(members[i].other))) for i in keep],
        lambda state: finish(substitute(rates[state])),
        found.implicit,
    )
    found.implicit[:] = [block for block in found.implicit if block not in switched.absorbed]
    _keep(found, members, switched.block, eliminated, stubborn, matrix)
    found.switching.append(switched.switching)


def jacobian(residuals: list[Expr], symbols: list[Expr]) -> list[list[Expr]]:
    """The derivative of each residual (row) with respect to each unknown (column)."""
    partials = partial_derivatives(residuals, symbols)
    return [[p.get(s, constant(0.0)) for s in symbols] for p in partials]


def _stubborn(members: list[Unknown], matrix: list[list[Expr]]) -> set[int]:
    """The members that are not eliminated: those in which a block is not linear, those without a diagonal.

    The efforts of closed loops are eliminated with numbers, with pivots: their matrix may become singular on the way.
    """
    inside = {u.symbol for u in members}
    nonlinear = {leaf for row in matrix for entry in row for leaf in leaves(entry) if leaf in inside}
    return {
        i
        for i, u in enumerate(members)
        if u.kind is BlockKind.CONSTRAINT or u.symbol in nonlinear or is_zero(matrix[i][i])
    }


def _eliminated(
    members: list[Unknown], residuals: list[Expr], matrix: list[list[Expr]], keep: list[int]
) -> dict[Expr, Expr]:
    """What the members that are not kept are in terms of those that are."""
    drop = [i for i in range(len(members)) if i not in keep]
    if not drop:
        return {}
    at_zero = Substitution({members[i].symbol: constant(0.0) for i in drop})
    values = eliminate(
        [[matrix[i][j] for j in drop] for i in drop],
        [-at_zero(residuals[i]) for i in drop],
        [members[i].element for i in drop],
    )
    return {members[i].symbol: value for i, value in zip(drop, values, strict=True)}


def _reduce_block(
    members: list[Unknown], residuals: list[Expr], matrix: list[list[Expr]]
) -> tuple[ImplicitBlock, dict[Expr, Expr]]:
    """Eliminate the unknowns that a nonlinear block only contains linearly; Newton's method gets the others."""
    stubborn = _stubborn(members, matrix)
    keep = [i for i in range(len(members)) if i in stubborn]
    eliminated = _eliminated(members, residuals, matrix, keep)
    substitute = Substitution(eliminated)
    symbols = tuple(members[i].symbol for i in keep)
    left = tuple(substitute(residuals[i]) for i in keep)
    condensed = condense(symbols, left)
    if condensed is not None:
        symbols, left = condensed.unknowns, condensed.residuals
        finish = Substitution(condensed.eliminated)
        eliminated = {unknown: finish(value) for unknown, value in eliminated.items()} | condensed.eliminated
    block = ImplicitBlock(
        unknowns=symbols,
        residuals=left,
        jacobian=tuple(tuple(row) for row in jacobian(list(left), list(symbols))),
        paths=tuple(members[i].element for i in keep),
    )
    return block, eliminated
