"""A model as a solver of ordinary differential equations sees it: right-hand side, Jacobian, and samples in between.

Both are printed as C and compiled by GCC, for every peer alike. Controllers are sampled at instants at which a solver
has to stop and begin anew. Activities are trapezoids over the steps of the solver, as it gives no other instants.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.c_machine import EXACT, aligned, compile_shared, places_of
from benchmarks.c_printer import CPrinter
from propermodel.codegen.machine import FloatArray, IntArray, Memory, Method, instant, sample_periods
from propermodel.codegen.native_memory import ready_tables
from propermodel.codegen.program import Array, Assign, Function, Program, Slot, Solve
from propermodel.codegen.state_jacobian import state_jacobian
from propermodel.compiler import CompiledModel
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import start_of


@dataclass(frozen=True)
class Outcome:
    """What a peer's run gives."""

    memory: Memory
    steps: int
    evaluations: int  # of the right-hand side, those for trapezoids not counted


class Hybrid:
    """A model at the start of a scenario."""

    def __init__(self, compiled: CompiledModel, scenario: Scenario) -> None:
        self.program, self.pattern = with_jacobian(compiled.lowered.program)
        self.printer = printer = CPrinter(self.program, Method.EULER, 1, observes=True)
        self._library = compile_shared(printer.text, EXACT)
        self._start = start_of(compiled, scenario).memory
        self.periods = sample_periods(compiled.lowered.program, self._start)
        self.stop = scenario.stop
        self.tables = ready_tables(compiled.lowered.program, self._start.tables)
        self.size = len(self._start.state)
        # Rows and columns of the Jacobian, in the order of the rows of states.
        order = np.array(printer.states)
        self.rows: IntArray = order[self.pattern[0]]
        self.columns: IntArray = order[self.pattern[1]]
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self.memory = self._start.copy()
        self.block = aligned(self.printer.rows, 1)[:, 0]
        for rows, values in places_of(self.printer, self.memory):
            self.block[rows] = values
        regions = self.printer.regions
        self.state = self._part(regions[Array.STATE], self.size)
        self._rates = self._part(regions[Array.RATE], self.size)
        self._powers = self._part(regions[Array.POWER], len(self.memory.activity))
        self._entries = self._part(regions[Array.SIGNAL], len(self.rows))
        self._activity = self._part(regions["activity"], len(self.memory.activity))
        self._integral = self._part(regions["integral"], len(self.memory.activity))
        self._pointers = (ctypes.c_void_p(self.block.ctypes.data), ctypes.c_void_p(self.tables.descriptors.ctypes.data))
        self._call("begin", self.memory.time)
        self.evaluations = 0

    def _part(self, first: int, count: int) -> FloatArray:
        return self.block[first : first + count]

    def _call(self, name: str, time: float) -> None:
        getattr(self._library, f"call_{name}")(*self._pointers, ctypes.c_double(time))

    def f(self, time: float, state: FloatArray) -> FloatArray:
        """The rates; the answer is overwritten by the next call."""
        self.evaluations += 1
        self.state[:] = state
        self._call("f", time)
        return self._rates

    def jacobian(self, time: float, state: FloatArray) -> FloatArray:
        """The Jacobian as a full matrix."""
        self.state[:] = state
        self._call("g", time)
        matrix = np.zeros((self.size, self.size))
        matrix[self.rows, self.columns] = self._entries
        return matrix

    def powers(self, time: float, state: FloatArray) -> FloatArray:
        """All powers, evaluated for a trapezoid."""
        self.state[:] = state
        self._call("f", time)
        return self._powers.copy()

    def add_trapezoid(self, length: float, before: FloatArray, after: FloatArray) -> None:
        """Add a step to the integrals of power."""
        self._integral += 0.5 * length * (before + after)
        self._activity += 0.5 * length * (np.abs(before) + np.abs(after))

    def run(self, advance: Callable[[float, float, FloatArray], tuple[FloatArray, int]]) -> Outcome:
        """From the start to the end; `advance` goes from one sample to the next and gives the state and its steps."""
        self.reset()
        taken = np.zeros(len(self.periods), dtype=np.int64)
        time, steps = self.memory.time, 0
        origin, near = time, 1e-9 * min(self.periods, default=1.0)
        while True:
            for k, period in enumerate(self.periods):
                if instant(origin, int(taken[k]), period) <= time + near:
                    self._call(f"s{k}", time)
                    taken[k] += 1
            if time + near >= self.stop:
                break
            dues = (instant(origin, int(taken[k]), period) for k, period in enumerate(self.periods))
            end = min([self.stop, *dues])
            state, count = advance(time, end, self.state.copy())
            self.state[:] = state
            time, steps = end, steps + count
        for rows, values in places_of(self.printer, self.memory):
            values[...] = self.block[rows]
        self.memory.time = time
        return Outcome(self.memory, steps, self.evaluations)


def with_jacobian(program: Program) -> tuple[Program, tuple[list[int], list[int]]]:
    """The program with the entries of its Jacobian in place of its signals, and their rows and columns."""
    jacobian = state_jacobian(program.rates, program.layout)
    solves = [step for step in program.rates.steps if isinstance(step, Solve)]
    assigns = [Assign(Slot(Array.SIGNAL, k), entry) for k, entry in enumerate(jacobian.entries.values())]
    lengths = {**program.layout.lengths, Array.SIGNAL: len(assigns)}
    observing = replace(
        program,
        observe=Function("observe", (*solves, *assigns)),
        layout=replace(program.layout, lengths=lengths),
    )
    rows, columns = ([entry[axis] for entry in jacobian.entries] for axis in (0, 1))
    return observing, (rows, columns)


def scales(samples: FloatArray) -> FloatArray:
    """Typical magnitudes of states, from values along a run (instants x states)."""
    greatest = np.abs(samples).max(axis=0)
    return np.where(greatest > 0.0, greatest, 1.0) if math.isfinite(float(greatest.max())) else np.ones_like(greatest)
