# pyright: basic
"""Prints a whole program as one LLVM module."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.codegen.arrangement import PRINTING, Arrangement, Printing
from propermodel.codegen.likeness import alike_together
from propermodel.codegen.llvm_attempt import reserve_attempt, write_attempt
from propermodel.codegen.llvm_events import reserve_events, write_events
from propermodel.codegen.llvm_fastest import is_watching, reserve_watch
from propermodel.codegen.llvm_functions import Writer
from propermodel.codegen.llvm_implicit import reserve_implicit
from propermodel.codegen.llvm_newton import LARGEST_STRAIGHT
from propermodel.codegen.llvm_run import write_entries, write_run
from propermodel.codegen.llvm_step import StepWriter, write_common
from propermodel.codegen.llvm_sums import METHODS, SHARE
from propermodel.codegen.llvm_tables import TABLE_FUNCTIONS
from propermodel.codegen.llvm_text import WIDE, Frame, Module, Shape
from propermodel.codegen.machine import Method
from propermodel.codegen.program import Array, Assign, Program, Solve
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.codegen.rosenbrock import with_step_of
from propermodel.codegen.schedule import Level, node_levels, nodes_of
from propermodel.codegen.tableaus import EXPLICIT_TABLEAUS


@dataclass(frozen=True)
class Source:
    """The printed program: its text, and where its numbers are."""

    text: str
    arrangement: Arrangement


def print_program(program: Program, method: Method, lanes: int = 1, printing: Printing = PRINTING) -> Source:
    """The LLVM IR of a program."""
    program = with_reciprocals(with_step_of(program, method))
    lengths = program.layout.lengths
    shape = Shape(lanes)
    momenta = list(program.layout.momenta)
    rest = sorted(set(range(lengths.get(Array.STATE, 0))) - set(momenta))
    # Momenta come first, padded so that the other states begin at a wide operation.
    momentum_rows = len(momenta)
    while momentum_rows * lanes % WIDE:
        momentum_rows += 1
    state_rows = {index: row for row, index in enumerate(momenta)}
    state_rows |= {index: momentum_rows + k for k, index in enumerate(rest)}
    count = momentum_rows + len(rest)

    power_rows = _power_rows(program, printing)
    frame = Frame(shape, program.layout, state_rows, power_rows)
    _reserve(frame, program, method, count)
    module = Module(frame)
    functions = Writer(module, program, printing)
    functions.write_program(may_add=method in METHODS)
    write_common(module, count)
    if method.is_adaptive:
        write_attempt(module, program, EXPLICIT_TABLEAUS.get(method), count)
    else:
        StepWriter(module, program, method, momentum_rows, count, adds_powers=functions.adds_powers).write()
    write_entries(module, program)
    if program.guards is not None:
        write_events(module, program, method, count)
    write_run(module, program, method, count)
    text = module.text() + "\n" + TABLE_FUNCTIONS
    rows = np.array([state_rows[i] for i in range(len(state_rows))], dtype=np.int64)
    powers = np.array(power_rows, dtype=np.int64)
    return Source(text, Arrangement(lanes, frame.rows, frame.regions, dict(lengths), rows, powers))


def _power_rows(program: Program, printing: Printing) -> list[int]:
    """The row of every POWER: in large programs those that are computed alike lie side by side."""
    assigns = [step for step in program.rates.steps if isinstance(step, Assign) and step.slot.array is Array.POWER]
    rows = list(range(program.layout.lengths.get(Array.POWER, 0)))
    if len(nodes_of([program.rates])) >= printing.loops_from:
        levels = node_levels([program.rates], program.layout)
        order = alike_together(
            [step.value for step in assigns], lambda node: levels[node] if levels[node] < Level.STEP else node.op
        )
        for row, place in enumerate(order):
            rows[assigns[place].slot.index] = row
    return rows


def _reserve(frame: Frame, program: Program, method: Method, state_rows: int) -> None:
    functions = program.functions
    sizes = [len(step.unknowns) for function in functions for step in function.steps if isinstance(step, Solve)]
    size = max(sizes, default=0)
    for region in (Array.STATE, Array.RATE, "lower", "upper"):
        frame.reserve(region, state_rows)
    if method is Method.RK4:
        frame.reserve("start", state_rows)
        frame.reserve("sum", state_rows)
    for array in (Array.DISCRETE, Array.PARAMETER, Array.UNKNOWN, Array.POWER, Array.SIGNAL):
        frame.reserve(array, program.layout.lengths.get(array, 0))
    frame.reserve("kept_unknown", program.layout.lengths.get(Array.UNKNOWN, 0))
    frame.reserve("integral", program.layout.lengths.get(Array.POWER, 0))
    frame.reserve("activity", program.layout.lengths.get(Array.POWER, 0))
    if method in METHODS:
        frame.reserve(SHARE, 1)
    if program.implicit_step is not None:
        reserve_implicit(frame, program)
    if method.is_adaptive:
        reserve_attempt(frame, program, EXPLICIT_TABLEAUS.get(method), state_rows)
    if is_watching(method, frame.shape.lanes):
        reserve_watch(frame, program, state_rows)
    if program.guards is not None:
        reserve_events(frame, program, state_rows)
    frame.reserve("trial", size)
    frame.reserve("residual", size)
    frame.reserve("jacobian", size * size)
    frame.reserve("elimination", size * (size + 1) if size > LARGEST_STRAIGHT else 0)
    for region in ("alive", "failed", "failed_time"):
        frame.reserve(region, 1)
