"""The native machine: the whole loop of a program compiled in-process by LLVM."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

import numpy as np

from propermodel.codegen.arrangement import PRINTING, Printing
from propermodel.codegen.control_block import Code
from propermodel.codegen.fastest import prepare_watch
from propermodel.codegen.llvm_compiler import Effort, Library
from propermodel.codegen.machine import (
    Failure,
    FloatArray,
    Memory,
    Method,
    Outcome,
    Request,
    Status,
    check_memory,
    check_request,
    not_solved,
    open_extremes,
    sample_periods,
    state_failures,
)
from propermodel.codegen.native_code import NativeCode, Recipe
from propermodel.codegen.native_memory import Control, ReadyTables, Work, ready_tables
from propermodel.codegen.program import Array, Program
from propermodel.codegen.step_control import least_sizes, prepare_control

# Thorough code makes a step some 10 to 30 % shorter and takes as long to make as it saves in about a million steps.
LONG_RUN = 500_000  # steps of one lane

_STATUS = {Code.FINISHED: Status.FINISHED, Code.PAUSED: Status.PAUSED, Code.EVENT: Status.EVENT}


class NativeMachine:
    """Runs a program as native code; calls release the interpreter lock."""

    def __init__(
        self,
        program: Program,
        method: Method,
        lanes: int = 1,
        printing: Printing = PRINTING,
        long_run: float = LONG_RUN,
    ) -> None:
        self._program = program
        self._method = method
        self._lanes = lanes
        self._recipe = recipe = Recipe(program, method, lanes, printing)
        kept = recipe.cached(Effort.THOROUGH)
        self._steps_to_thorough = long_run if kept is None else math.inf
        self._load(kept or recipe.get(Effort.QUICK))
        self._improving = threading.Lock()
        self._tables: ReadyTables | None = None

    def _load(self, native: NativeCode) -> None:
        self._library = Library(native.code, self._program)
        self._arrangement = native.arrangement
        self._effort = native.effort

    @property
    def program(self) -> Program:
        """The program it executes."""
        return self._program

    @property
    def method(self) -> Method:
        """How it takes a step."""
        return self._method

    @property
    def lanes(self) -> int:
        """How many runs it does side by side."""
        return self._lanes

    @property
    def effort(self) -> Effort:
        """How thoroughly the code that it runs was compiled."""
        return self._effort

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        check_request(self._program, memory, request)
        if self._lanes == 1:
            memory.alive[:] = True
        if self._method.is_adaptive:
            prepare_control(self, memory, request)
        open_extremes(memory, request)
        if request.is_watched:
            prepare_watch(memory)
        work = self._work(memory)
        if self._method.is_adaptive:
            work.set_least_sizes(least_sizes(memory, request))
        control = Control(self._arrangement, memory, request, sample_periods(self._program, memory))
        failures: list[Failure] = []
        library = self._library_for(memory, request)
        steps_before = memory.steps_taken
        while True:
            code = Code(library.run(work.address, work.tables_address, control.address))
            control.update(memory)
            work.write_back()
            failures += work.solve_failures()
            if code is Code.STATE_FAILED:
                failures += state_failures(memory)
            if code is Code.STEP_TOO_SMALL:
                failures.append(Failure(0, Status.STEP_TOO_SMALL, memory.time, work.worst_state()))
            for failure in failures:
                memory.alive[failure.lane] = False
            work.read_alive()
            if code in _STATUS or not memory.alive.any():
                break
        self._steps_to_thorough -= self._lanes * (memory.steps_taken - steps_before)
        step = work.event_step() if code is Code.EVENT else 0.0
        return control.outcome(memory, _STATUS.get(code), failures, step)

    def _library_for(self, memory: Memory, request: Request) -> Library:
        """The code for a run: better code as soon as the steps taken and those still asked for are many."""
        with self._improving:
            taken = memory.time - memory.origin
            step = taken / memory.steps_taken if self._method.is_adaptive and taken > 0.0 else request.step
            ahead = self._lanes * (request.until - memory.time) / step
            if ahead >= self._steps_to_thorough:
                self._load(self._recipe.get(Effort.THOROUGH))
                self._steps_to_thorough = math.inf
            return self._library

    def rates(self, memory: Memory) -> tuple[FloatArray, FloatArray]:
        """The RATE and POWER arrays at the memory's time; the memory is not changed."""
        work = self._evaluated(memory, self._library.rates)
        return work.rate(), work.power()

    def observe(self, memory: Memory) -> FloatArray:
        """The SIGNAL array at the memory's time; the memory is not changed."""
        return self._evaluated(memory, self._library.observe).get(Array.SIGNAL)

    def sample(self, memory: Memory) -> None:
        """Apply all controllers once, by rate, without counting a sample."""
        self._evaluated(memory, self._library.sample).write_back()

    def guards(self, memory: Memory) -> FloatArray:
        """The GUARD array at the memory's time; the memory is not changed."""
        if self._program.guards is None:
            return np.zeros(0)
        return self._evaluated(memory, self._library.guards).get(Array.GUARD)

    def jumps(self, memory: Memory) -> FloatArray:
        """The JUMP array at the memory's time; the memory is not changed."""
        if self._program.jumps is None:
            return np.zeros(0)
        return self._evaluated(memory, self._library.jumps).get(Array.JUMP)

    def switching(self, memory: Memory) -> FloatArray:
        """The SWITCHING array at the memory's time; the memory is not changed."""
        if self._program.switching is None:
            return np.zeros(0)
        return self._evaluated(memory, self._library.switching).get(Array.SWITCHING)

    def advance(self, memory: Memory, step: float) -> None:
        """Take one step of this length whatever the guards say."""
        if self._program.guards is None:
            raise ValueError("only a program with events is advanced by single steps")
        work = self._work(memory)
        memory.alive[:] = True
        self._library.advance(work.address, work.tables_address, memory.time, step)
        work.write_back()
        failures = work.solve_failures()
        if failures:
            raise not_solved(self._program, failures[0])
        memory.time += step

    def _work(self, memory: Memory) -> Work:
        check_memory(self._program, self._lanes, memory)
        ready = self._tables
        if ready is None or ready.tables is not memory.tables:
            ready = self._tables = ready_tables(self._program, memory.tables)
        return Work(self._arrangement, memory, ready)

    def _evaluated(self, memory: Memory, function: Callable[..., int]) -> Work:
        work = self._work(memory)
        function(work.address, work.tables_address, memory.time)
        failures = [failure for failure in work.solve_failures() if memory.alive[failure.lane]]
        if failures:
            raise not_solved(self._program, failures[0])
        return work
