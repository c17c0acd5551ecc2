"""A condition that ends a run: one more guard, in a variant of the model that is otherwise laid out the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from propermodel.codegen.machine import Machine, Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError, one_of
from propermodel.equations.events import SystemEvent, guard_of
from propermodel.expressions.core import TIME, Expr, Substitution, leaves, symbol


def stopping(compiled: CompiledModel, condition: Expr) -> CompiledModel:
    """The model with an event that changes nothing, the last one, which happens when the condition becomes true.

    Raises:
        SimulationError: what is given is no condition, or mentions what the model does not have.
    """
    if not condition.is_condition:
        raise SimulationError.of(
            "simulation/until",
            "what a run shall go on until is a number, not a condition",
            help="compare: simulate(..., until=ball.flange.flow < 0.0)",
        )
    absolute = Substitution({leaf: _value(compiled, leaf) for leaf in leaves(condition)})(condition)
    return compiled.with_event(SystemEvent(element=Path(), guard=guard_of(absolute), changes=()))


def _value(compiled: CompiledModel, leaf: Expr) -> Expr:
    """What a leaf of the condition is in terms of states, held values, parameters and time."""
    layout = compiled.lowered.program.layout
    meant = leaf if leaf is TIME else symbol(leaf.data.kind, leaf.data.path, leaf.data.unit)
    value = compiled.system.values.get(meant, meant)
    if all(part in layout.slots or part in layout.table_index for part in leaves(value)):
        return value
    raise SimulationError.of(
        "simulation/until",
        f"a run shall go on until a condition on '{leaf.data.path}', which nothing in the model is or uses",
        help=one_of(str(leaf.data.path), map(str, compiled.lowered.observables)),
    )


def add_guard(machine: Machine, memory: Memory, *, is_continued: bool) -> Memory:
    """The memory of a run of the variant; a run that is continued waits for the condition to become true anew."""
    wider = replace(memory, guard=np.append(memory.guard, -1.0))
    if is_continued:
        wider.guard[-1] = machine.guards(wider)[-1]
    return wider


def drop_guard(memory: Memory) -> Memory:
    """The memory as the model without the condition has it."""
    return replace(memory, guard=memory.guard[:-1].copy())
