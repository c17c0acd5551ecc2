"""Why a run met something that is no finite number: divisors that vanish, and equations that determine nothing.

Structure says that a block of equations can be solved; numbers may take it back: a parameter of exactly zero, terms
that cancel. Looked for only after a run has failed, so that others pay nothing for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from propermodel.codegen.machine import Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import SimulationError
from propermodel.equations.system import SolvedBlock
from propermodel.expressions.core import Expr, Op, SymbolKind, leaves, postorder
from propermodel.simulation.point import Point

# Equations whose matrix has a smaller singular value than this share of its largest determine nothing.
SINGULAR = 1e-12
MOST_NAMED = 6


def singular_reason(compiled: CompiledModel, memory: Memory) -> str:
    """What is singular at the time and state of a memory, as a sentence without its end; empty if nothing is."""
    try:
        point = Point(compiled.system, compiled.lowered, memory)
    except SimulationError:
        return ""
    for block in compiled.system.solved:
        if _is_singular(block, point):
            names = _listed(str(path) for path in dict.fromkeys(block.paths))
            zero = _zero_parameters([entry for row in block.matrix for entry in row], point)
            cause = f"because {zero}" if zero else "because terms cancel"
            return f"the equations of {names} do not determine their variables with these numbers, {cause}"
    zeros = [divisor for divisor in _divisors(compiled) if point.value(divisor) == 0.0]
    for divisor in zeros:
        zero = _zero_parameters([divisor], point)
        if zero:
            return f"something is divided by zero, because {zero}"
    if zeros:
        names = _listed(dict.fromkeys(str(leaf.data.path) for leaf in leaves(zeros[0])))
        return f"something is divided by zero, a result of {names}"
    return ""


def _is_singular(block: SolvedBlock, point: Point) -> bool:
    size = len(block.matrix)
    known = point.lowered.program.layout.slots
    if not size or not all(leaf in known for row in block.matrix for leaf in leaves(*row)):
        return False
    matrix = point.values([entry for row in block.matrix for entry in row]).reshape(size, size)
    if not np.all(np.isfinite(matrix)):
        return False
    scale = np.max(np.abs(matrix), axis=1, keepdims=True)
    if np.any(scale == 0.0):
        return True
    values = np.linalg.svd(matrix / scale, compute_uv=False)
    return bool(values[-1] <= SINGULAR * values[0])


def _divisors(compiled: CompiledModel) -> list[Expr]:
    rates = [state.derivative for state in compiled.system.states]
    return list(dict.fromkeys(node.args[1] for node in postorder(rates) if node.op is Op.DIVIDE))


def _zero_parameters(exprs: Sequence[Expr], point: Point) -> str:
    """The parameters among these expressions that are exactly zero, with the verb; empty if there are none."""
    found = [
        str(leaf.data.path)
        for leaf in leaves(*exprs)
        if leaf.data.kind is SymbolKind.PARAMETER and point.value(leaf) == 0.0
    ]
    if not found:
        return ""
    return f"{_listed(found)} {'is' if len(found) == 1 else 'are'} 0"


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    shown = ", ".join(every[:MOST_NAMED])
    return shown if len(every) <= MOST_NAMED else f"{shown} and {len(every) - MOST_NAMED} more"
