"""Where linear equations may cease to determine their unknowns along a run: a determinant that can pass zero.

Structure says that a block can be solved, and most blocks can be whatever their signals do: masses behind a lever,
resistances in a ring. Where a signal, a state or time may turn the sign of a determinant (a resistance that becomes
negative, a gain of a loop that reaches 1), the sign is watched along the run, as events are. What passes zero is not
what jumps over it: a determinant that changes its sign at a switch is regular on both sides.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from random import Random

import numpy as np

from propermodel.diagnostics import Path
from propermodel.equations.events import SystemEvent
from propermodel.equations.solve import determinant
from propermodel.equations.system import SolvedBlock
from propermodel.expressions.core import Expr, Op, SymbolKind, constant, leaves, postorder, where
from propermodel.expressions.interpret import interpret_all

_DRAWS = 60
_DECADES = 2.0  # values are drawn over as many decades above and below 1, of either sign where a sign is free
_WELL_CONDITIONED = 1e-9  # a determinant whose rows, scaled, give less than this has no sure sign
_AT_LEAST = constant(1e-300)  # what makes a guard positive where the determinant is exactly zero


@dataclass(frozen=True, slots=True, kw_only=True)
class RankLoss(SystemEvent):
    """A determinant changes its sign; where it passes zero, the equations of these elements determine nothing."""

    paths: tuple[Path, ...]
    changing: tuple[Path, ...]  # states, signals and time that the determinant depends on


def rank_losses(blocks: Iterable[SolvedBlock]) -> tuple[RankLoss, ...]:
    """What to watch: for every block whose determinant may change its sign along a run, either change."""
    found: list[RankLoss] = []
    for block in blocks:
        if not block.matrix or not may_change_sign(block.matrix):
            continue
        value = determinant(block.matrix, block.paths)
        paths = tuple(dict.fromkeys(block.paths))
        changing = tuple(leaf.data.path for leaf in leaves(value) if leaf.data.kind is not SymbolKind.PARAMETER)
        for signed in (value, -value):
            guard = where(signed > 0.0, signed, where(signed >= 0.0, _AT_LEAST, signed))
            found.append(RankLoss(element=paths[0], guard=guard, changes=(), paths=paths, changing=changing))
    return tuple(found)


def may_change_sign(matrix: Sequence[Sequence[Expr]]) -> bool:
    """Whether the determinant has either sign for some values of what changes along a run, parameters being positive.

    Tried with random values: what is positive by structure, as sums of inertias are, has one sign for all of them.
    """
    entries = [entry for row in matrix for entry in row]
    symbols = leaves(*entries)
    if all(leaf.data.kind is SymbolKind.PARAMETER for leaf in symbols):
        return False
    tables = [node for node in postorder(entries) if node.op in (Op.LOOKUP, Op.SLOPE)]
    random = Random(len(entries))  # the same model gives the same equations
    signs: set[float] = set()
    for _ in range(_DRAWS):
        given = {leaf: _drawn(random, leaf.data.kind is SymbolKind.PARAMETER) for leaf in symbols}
        given.update({node: _drawn(random, is_positive=False) for node in tables})
        values = np.array(interpret_all(entries, given)).reshape(len(matrix), -1)
        scale = np.max(np.abs(values), axis=1, keepdims=True)
        if not np.all(np.isfinite(values)) or not np.all(scale > 0.0):
            continue
        sign, size = np.linalg.slogdet(values / scale)
        if size > np.log(_WELL_CONDITIONED):
            signs.add(float(sign))
    return len(signs) > 1


def _drawn(random: Random, is_positive: bool) -> float:
    value = 10.0 ** random.uniform(-_DECADES, _DECADES)
    return value if is_positive or random.random() < 0.5 else -value
