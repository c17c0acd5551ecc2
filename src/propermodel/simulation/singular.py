"""Why a run met something that is no finite number: divisors that vanish, and equations that determine nothing.

Structure says that a block of equations can be solved; numbers may take it back: a parameter of exactly zero, terms
that cancel. Looked for only after a run has failed, so that others pay nothing for it.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from propermodel.codegen.machine import Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import SimulationError
from propermodel.equations.system import SolvedBlock
from propermodel.expressions.core import Expr, Op, leaves, postorder
from propermodel.simulation.point import Point
from propermodel.simulation.zeros import listed, zero_parameters

# Equations whose matrix has a smaller singular value than this share of its largest determine nothing.
SINGULAR = 1e-12


def singular_reason(compiled: CompiledModel, memory: Memory, powers: Iterable[Expr] = ()) -> str:
    """What is singular at the time and state of a memory, as a sentence without its end; empty if nothing is.

    Looked for in what the states follow from, and in `powers`.
    """
    try:
        point = Point(compiled.system, compiled.lowered, memory)
    except SimulationError:
        return ""
    for block in compiled.system.solved:
        if _is_singular(block, point):
            names = listed(str(path) for path in dict.fromkeys(block.paths))
            zero = zero_parameters((entry for row in block.matrix for entry in row), point.value)
            cause = f"because {zero}" if zero else "because terms cancel"
            return f"the equations of {names} do not determine their variables with these numbers, {cause}"
    zeros = [divisor for divisor in _divisors(compiled, powers) if point.value(divisor) == 0.0]
    for divisor in zeros:
        zero = zero_parameters([divisor], point.value)
        if zero:
            return f"something is divided by zero, because {zero}"
    if zeros:
        names = listed(dict.fromkeys(str(leaf.data.path) for leaf in leaves(zeros[0])))
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


def _divisors(compiled: CompiledModel, powers: Iterable[Expr]) -> list[Expr]:
    exprs = [*(state.derivative for state in compiled.system.states), *powers]
    return list(dict.fromkeys(node.args[1] for node in postorder(exprs) if node.op is Op.DIVIDE))
