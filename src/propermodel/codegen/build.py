"""Builds the machine that runs a program."""

from __future__ import annotations

from enum import StrEnum

from propermodel.codegen.llvm_compiler import vector_lanes
from propermodel.codegen.machine import Machine, Method
from propermodel.codegen.native import NativeMachine
from propermodel.codegen.program import Program

INTERPRETED_LANES = 256  # where the numbers of an operation cost more than its call


class Backend(StrEnum):
    """What executes a program."""

    NATIVE = "native"  # compiled by LLVM
    INTERPRETED = "interpreted"  # NumPy, some hundred times slower


def build_machine(program: Program, method: Method, lanes: int = 1, backend: Backend = Backend.NATIVE) -> Machine:
    """The machine for a program; `lanes` runs are done side by side."""
    if lanes < 1:
        raise ValueError(f"a machine has at least one lane, not {lanes}")
    if lanes > 1 and program.guards is not None:
        raise ValueError("a program with events runs in one lane: every run meets its own instants")
    if lanes > 1 and method.is_adaptive:
        raise ValueError("a method that controls its steps runs in one lane: every run has steps of its own")
    # Most runs are native: the others are loaded when they are asked for.
    if not method.is_generated:
        from propermodel.codegen.sundials import SundialsMachine

        return SundialsMachine(program, build_machine(program, Method.EULER, backend=backend))
    if backend is Backend.INTERPRETED:
        from propermodel.codegen.interpreted import InterpretedMachine

        return InterpretedMachine(program, method, lanes)
    return NativeMachine(program, method, lanes)


def best_lanes(backend: Backend) -> int:
    """How many runs side by side cost least for each."""
    return INTERPRETED_LANES if backend is Backend.INTERPRETED else vector_lanes()
