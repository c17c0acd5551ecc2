"""The native machine: the whole loop of a program compiled in-process by LLVM.

Code is compiled quickly at first, and thoroughly once a run is long enough to win back the time. Both give the same
numbers to the last bit, as no instruction may be replaced by one of another value.
"""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.llvm_functions import MOST_INSTRUCTIONS
from propermodel.codegen.llvm_run import Code
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
    not_converged,
    sample_periods,
    state_failures,
)
from propermodel.codegen.native_memory import Control, ReadyTables, Work, ready_tables
from propermodel.codegen.print_program import print_program
from propermodel.codegen.program import Array, Program

LARGE_MODULE = 1_000_000  # characters
# Thorough code makes a step some 10 to 30 % shorter and takes as long to make as it saves in about a million steps.
LONG_RUN = 500_000  # steps of one lane
_compile_lock = threading.Lock()


@dataclass(frozen=True)
class Levels:
    """How hard LLVM tries: the level of its passes over instructions, and of the choice of machine code."""

    passes: int
    code: int


QUICK = Levels(passes=0, code=0)


def thorough(text: str) -> Levels:
    """The levels that make steps short.

    Higher levels of code schedule instructions anew, which takes half of the time and makes no step shorter; what
    further passes add finds nothing in straight-line code that is printed without repetition. In a large module the
    first passes take as long as all the rest, and steps no longer become shorter.
    """
    return Levels(passes=1 if len(text) < LARGE_MODULE else 0, code=1)


class _Library:
    """Compiled code and its entry points; the code lives as long as this object."""

    def __init__(self, text: str, has_events: bool, levels: Levels) -> None:
        self.levels = levels
        # llvmlite is slow to import and not needed by those who only interpret.
        import llvmlite.binding as llvm

        binding: Any = llvm
        with _compile_lock:
            binding.initialize_native_target()
            binding.initialize_native_asmprinter()
            target = binding.Target.from_default_triple()
            machine = target.create_target_machine(
                cpu=binding.get_host_cpu_name(), features=binding.get_host_cpu_features().flatten(), opt=levels.code
            )
            module = binding.parse_assembly(text)
            module.triple = binding.get_default_triple()
            module.data_layout = str(machine.target_data)
            module.verify()
            options = binding.create_pipeline_tuning_options(speed_level=levels.passes)
            builder = binding.create_pass_builder(machine, options)
            builder.getModulePassManager().run(module, builder)
            self._engine = binding.create_mcjit_compiler(module, machine)
            self._engine.finalize_object()
        self.run = self._function("run", ctypes.c_void_p)
        self.rates = self._function("evaluate.rates", ctypes.c_double)
        self.observe = self._function("evaluate.observe", ctypes.c_double)
        self.sample = self._function("evaluate.sample", ctypes.c_double)
        if has_events:
            self.guards = self._function("evaluate.guards", ctypes.c_double)
            self.jumps = self._function("evaluate.jumps", ctypes.c_double)
            self.advance = self._function("advance", ctypes.c_double, ctypes.c_double)

    def _function(self, name: str, *last: Any) -> Callable[..., int]:
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *last)
        return prototype(self._engine.get_function_address(name))


_STATUS = {Code.FINISHED: Status.FINISHED, Code.PAUSED: Status.PAUSED, Code.EVENT: Status.EVENT}


class NativeMachine:
    """Runs a program as native code; calls release the interpreter lock."""

    def __init__(
        self,
        program: Program,
        method: Method,
        lanes: int = 1,
        most_instructions: int = MOST_INSTRUCTIONS,
        long_run: float = LONG_RUN,
    ) -> None:
        self._program = program
        self._method = method
        self._lanes = lanes
        self._source = print_program(program, method, lanes, most_instructions)
        self._library = self._compiled(QUICK)
        self._steps_to_thorough = long_run
        self._improving = threading.Lock()
        self._tables: ReadyTables | None = None

    def _compiled(self, levels: Levels) -> _Library:
        return _Library(self._source.text, self._program.guards is not None, levels)

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
    def levels(self) -> Levels:
        """How hard its code was compiled so far."""
        return self._library.levels

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        check_request(self._program, memory, request)
        if self._lanes == 1:
            memory.alive[:] = True
        work = self._work(memory)
        control = Control(self._source, memory, request, sample_periods(self._program, memory))
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
            for failure in failures:
                memory.alive[failure.lane] = False
            work.read_alive()
            if code in _STATUS or not memory.alive.any():
                break
        self._steps_to_thorough -= self._lanes * (memory.steps_taken - steps_before)
        step = work.event_step() if code is Code.EVENT else 0.0
        return control.outcome(memory, _STATUS.get(code), failures, step)

    def _library_for(self, memory: Memory, request: Request) -> _Library:
        """The code for a run: better code as soon as the steps taken and those still asked for are many."""
        with self._improving:
            ahead = self._lanes * (request.until - memory.time) / request.step
            if ahead >= self._steps_to_thorough:
                self._library = self._compiled(thorough(self._source.text))
                self._steps_to_thorough = math.inf
            return self._library

    def rates(self, memory: Memory) -> tuple[FloatArray, FloatArray]:
        """The RATE and POWER arrays at the memory's time; the memory is not changed."""
        work = self._evaluated(memory, self._library.rates)
        return work.rate(), work.get(Array.POWER)

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
            raise not_converged(self._program, failures[0])
        memory.time += step

    def _work(self, memory: Memory) -> Work:
        check_memory(self._program, self._lanes, memory)
        ready = self._tables
        if ready is None or ready.tables is not memory.tables:
            ready = self._tables = ready_tables(self._program, memory.tables)
        return Work(self._source, memory, ready)

    def _evaluated(self, memory: Memory, function: Callable[..., int]) -> Work:
        work = self._work(memory)
        function(work.address, work.tables_address, memory.time)
        failures = [failure for failure in work.solve_failures() if memory.alive[failure.lane]]
        if failures:
            raise not_converged(self._program, failures[0])
        return work


def vector_lanes() -> int:
    """How many numbers a vector register of this machine holds."""
    import llvmlite.binding as llvm

    binding: Any = llvm
    features = binding.get_host_cpu_features()
    return 8 if features.get("avx512f") else 4 if features.get("avx") else 2
