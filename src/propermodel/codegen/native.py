"""The native machine: the whole loop of a program compiled in-process by LLVM."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.llvm_functions import MOST_INSTRUCTIONS, Writer
from propermodel.codegen.llvm_loop import Code, StepWriter, Word, write_common, write_entries, write_run
from propermodel.codegen.llvm_newton import LARGEST_STRAIGHT
from propermodel.codegen.llvm_tables import AXIS_WORDS, DESCRIPTOR_WORDS, TABLE_FUNCTIONS
from propermodel.codegen.llvm_text import WIDE, Frame, Module, Shape
from propermodel.codegen.machine import (
    Failure,
    FloatArray,
    IntArray,
    Memory,
    Method,
    Outcome,
    Request,
    Status,
    check_memory,
    check_request,
    count_from,
    not_converged,
    sample_periods,
    state_failures,
)
from propermodel.codegen.program import Array, Program, Solve
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.codegen.tables import PreparedTable, prepare_tables

_LARGEST = float(np.finfo(np.float64).max)


@dataclass(frozen=True)
class Source:
    """The printed program: its text, where its numbers are, and the row of every state in the state regions."""

    text: str
    frame: Frame
    state_rows: IntArray


def print_program(
    program: Program, method: Method, lanes: int = 1, most_instructions: int = MOST_INSTRUCTIONS
) -> Source:
    """The LLVM IR of a program; functions are cut into pieces of about `most_instructions`."""
    program = with_reciprocals(program)
    lengths = program.layout.lengths
    shape = Shape(lanes)
    momenta = list(program.layout.momenta)
    rest = [i for i in range(lengths.get(Array.STATE, 0)) if i not in set(momenta)]
    # Momenta come first, padded so that the other states begin at a wide operation.
    momentum_rows = len(momenta)
    while momentum_rows * lanes % WIDE:
        momentum_rows += 1
    state_rows = {index: row for row, index in enumerate(momenta)}
    state_rows |= {index: momentum_rows + k for k, index in enumerate(rest)}
    count = momentum_rows + len(rest)

    frame = Frame(shape, program.layout, state_rows)
    _reserve(frame, program, method, count)
    module = Module(frame)
    Writer(module, program, most_instructions).write_program()
    write_common(module, count)
    StepWriter(module, program, method, momentum_rows, count).write()
    write_entries(module, program)
    write_run(module, program)
    text = module.text() + "\n" + TABLE_FUNCTIONS
    return Source(text, frame, np.array([state_rows[i] for i in range(len(state_rows))], dtype=np.int64))


def _reserve(frame: Frame, program: Program, method: Method, state_rows: int) -> None:
    functions = (program.rates, program.displacement_rates, program.observe, *program.samples)
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
    frame.reserve("trial", size)
    frame.reserve("residual", size)
    frame.reserve("jacobian", size * size)
    frame.reserve("elimination", size * (size + 1) if size > LARGEST_STRAIGHT else 0)
    for region in ("alive", "failed", "failed_time"):
        frame.reserve(region, 1)


_compile_lock = threading.Lock()


class _Library:
    """Compiled code and its entry points; the code lives as long as this object."""

    def __init__(self, text: str) -> None:
        # llvmlite is slow to import and not needed by those who only interpret.
        import llvmlite.binding as llvm

        binding: Any = llvm
        with _compile_lock:
            binding.initialize_native_target()
            binding.initialize_native_asmprinter()
            target = binding.Target.from_default_triple()
            machine = target.create_target_machine(
                cpu=binding.get_host_cpu_name(), features=binding.get_host_cpu_features().flatten(), opt=3
            )
            module = binding.parse_assembly(text)
            module.triple = binding.get_default_triple()
            module.data_layout = str(machine.target_data)
            module.verify()
            options = binding.create_pipeline_tuning_options(speed_level=3)
            builder = binding.create_pass_builder(machine, options)
            builder.getModulePassManager().run(module, builder)
            self._engine = binding.create_mcjit_compiler(module, machine)
            self._engine.finalize_object()
        self.run = self._function("run", ctypes.c_void_p)
        self.rates = self._function("evaluate.rates", ctypes.c_double)
        self.observe = self._function("evaluate.observe", ctypes.c_double)
        self.sample = self._function("evaluate.sample", ctypes.c_double)

    def _function(self, name: str, last: Any) -> Callable[..., int]:
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, last)
        return prototype(self._engine.get_function_address(name))


class NativeMachine:
    """Runs a program as native code; calls release the interpreter lock."""

    def __init__(
        self, program: Program, method: Method, lanes: int = 1, most_instructions: int = MOST_INSTRUCTIONS
    ) -> None:
        self._program = program
        self._method = method
        self._lanes = lanes
        source = print_program(program, method, lanes, most_instructions)
        self._frame = source.frame
        self._state_rows = source.state_rows
        self._library = _Library(source.text)

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

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        check_memory(self._program, self._lanes, memory)
        check_request(self._program, memory, request)
        if self._lanes == 1:
            memory.alive[:] = True
        work = _Work(self, memory)
        control = _Control(self, memory, request)
        failures: list[Failure] = []
        while True:
            code = Code(self._library.run(work.address, work.tables_address, control.address))
            control.update(memory)
            work.write_back()
            failures += work.solve_failures()
            if code is Code.STATE_FAILED:
                failures += state_failures(memory)
            for failure in failures:
                memory.alive[failure.lane] = False
            work.read_alive()
            if code in (Code.FINISHED, Code.PAUSED) or not memory.alive.any():
                break
        status = {Code.FINISHED: Status.FINISHED, Code.PAUSED: Status.PAUSED}.get(code)
        return control.outcome(memory, status, failures)

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

    def _evaluated(self, memory: Memory, function: Callable[..., int]) -> _Work:
        check_memory(self._program, self._lanes, memory)
        work = _Work(self, memory)
        function(work.address, work.tables_address, memory.time)
        failures = work.solve_failures()
        if failures:
            raise not_converged(self._program, failures[0])
        return work


class _Work:
    """The block of numbers of one call, filled from a memory."""

    def __init__(self, machine: NativeMachine, memory: Memory) -> None:
        self._frame = frame = machine._frame
        self._lanes = machine.lanes
        self._state_rows = machine._state_rows
        self._memory = memory
        storage = np.zeros(frame.rows * self._lanes + 16)
        skip = (-storage.ctypes.data % 64) // 8
        self._storage = storage  # keeps the block alive
        self._block = storage[skip : skip + frame.rows * self._lanes].reshape(frame.rows, self._lanes)
        self.address = self._block.ctypes.data
        tables = prepare_tables(machine.program, memory.tables)
        self._descriptors = _descriptors(tables)
        self._tables = tables
        self.tables_address = self._descriptors.ctypes.data
        self._fill(machine.program)

    def _fill(self, program: Program) -> None:
        memory, block, regions = self._memory, self._block, self._frame.regions
        for region, values in (
            (Array.DISCRETE, memory.discrete),
            (Array.PARAMETER, memory.parameter),
            (Array.UNKNOWN, memory.unknown),
            ("integral", memory.integral),
            ("activity", memory.activity),
        ):
            rows = self._rows(values)
            block[regions[region] : regions[region] + len(rows)] = rows
        for region, values, missing in (
            (Array.STATE, memory.state, 0.0),
            ("lower", memory.lower, -_LARGEST),
            ("upper", memory.upper, _LARGEST),
        ):
            count = int(self._state_rows.max(initial=-1)) + 1
            block[regions[region] : regions[region] + count] = missing
            # Limits that are finite refuse an infinite state.
            rows = self._rows(values)
            limited = rows if region is Array.STATE else np.clip(rows, -_LARGEST, _LARGEST)
            block[regions[region] + self._state_rows] = limited
        self.read_alive()

    def _rows(self, values: FloatArray) -> FloatArray:
        return values.reshape(-1, self._lanes)

    def read_alive(self) -> None:
        """Let the code know which lanes are alive; a single lane always is."""
        alive = self._memory.alive if self._lanes > 1 else True
        self._block[self._frame.regions["alive"]] = alive

    def get(self, array: Array) -> FloatArray:
        """A copy of an array as memories have it."""
        start = self._frame.regions[array]
        count = self._frame.layout.lengths.get(array, 0)
        return self._shaped(self._block[start : start + count])

    def rate(self) -> FloatArray:
        """The rates in the order of the states."""
        return self._shaped(self._block[self._frame.regions[Array.RATE] + self._state_rows])

    def _shaped(self, rows: FloatArray) -> FloatArray:
        return rows[:, 0].copy() if self._lanes == 1 else rows.copy()

    def write_back(self) -> None:
        """Bring what has changed into the memory."""
        memory, block, regions = self._memory, self._block, self._frame.regions
        for region, values in (
            (Array.DISCRETE, memory.discrete),
            (Array.UNKNOWN, memory.unknown),
            ("integral", memory.integral),
            ("activity", memory.activity),
        ):
            rows = self._rows(values)
            rows[...] = block[regions[region] : regions[region] + len(rows)]
        self._rows(memory.state)[...] = block[regions[Array.STATE] + self._state_rows]

    def solve_failures(self) -> list[Failure]:
        """The solves that have failed since the last call, at most one in each lane."""
        regions = self._frame.regions
        numbers = self._block[regions["failed"]]
        times = self._block[regions["failed_time"]]
        found = [
            Failure(int(lane), Status.NOT_CONVERGED, float(times[lane]), int(numbers[lane]) - 1)
            for lane in np.flatnonzero(numbers)
        ]
        numbers[:] = 0.0
        return found


def _descriptors(tables: list[PreparedTable]) -> IntArray:
    words = np.zeros((max(len(tables), 1), DESCRIPTOR_WORDS), dtype=np.int64)
    numbers = words.view(np.float64)
    for k, table in enumerate(tables):
        for i, axis in enumerate(table.axes):
            first = AXIS_WORDS * i
            words[k, first] = axis.pairs.ctypes.data
            words[k, first + 1] = axis.grid.size
            numbers[k, first + 2 : first + 6] = axis.grid[0], axis.cells_per_unit, axis.grid[0], axis.grid[-1]
        words[k, 2 * AXIS_WORDS] = table.cells.ctypes.data
    return words


class _Control:
    """The control block of one call and the buffers for its rows."""

    def __init__(self, machine: NativeMachine, memory: Memory, request: Request) -> None:
        lanes = machine.lanes
        powers = machine.program.layout.lengths.get(Array.POWER, 0)
        self._lanes = lanes
        self._selected = np.ascontiguousarray(request.selected, dtype=np.int64)
        most = request.most_rows
        self._row_times, self._integral_times = np.empty(most), np.empty(most)
        self._rows = np.empty((most, self._selected.size, lanes))
        self._integrals, self._activities = np.empty((most, powers, lanes)), np.empty((most, powers, lanes))
        periods = sample_periods(machine.program, memory)
        self._words = words = np.zeros(Word.FIRST_RATE + 2 * len(periods), dtype=np.int64)
        self._numbers = numbers = words.view(np.float64)
        numbers[Word.TIME] = memory.time
        numbers[Word.UNTIL] = request.until
        numbers[Word.STEP] = request.step
        numbers[Word.ORIGIN] = memory.origin
        numbers[Word.ROW_PERIOD] = request.row_period
        numbers[Word.INTEGRAL_PERIOD] = request.integral_period
        words[Word.MOST_ROWS] = most
        words[Word.TICKS_LEFT] = request.most_ticks
        words[Word.SELECTED] = self._selected.ctypes.data
        words[Word.SELECTED_COUNT] = self._selected.size
        words[Word.ROWS] = self._rows.ctypes.data
        words[Word.ROW_TIMES] = self._row_times.ctypes.data
        words[Word.INTEGRALS] = self._integrals.ctypes.data
        words[Word.ACTIVITIES] = self._activities.ctypes.data
        words[Word.INTEGRAL_TIMES] = self._integral_times.ctypes.data
        words[Word.ROWS_TAKEN] = count_from(memory, request, memory.rows_taken, request.row_period)
        words[Word.INTEGRAL_ROWS_TAKEN] = count_from(
            memory, request, memory.integral_rows_taken, request.integral_period
        )
        words[Word.STEPS_TAKEN] = memory.steps_taken
        numbers[Word.FIRST_RATE :: 2] = periods
        words[Word.FIRST_RATE + 1 :: 2] = memory.samples_taken
        self.address = words.ctypes.data

    def update(self, memory: Memory) -> None:
        """Bring time and counts into the memory."""
        words = self._words
        memory.time = float(self._numbers[Word.TIME])
        memory.rows_taken = int(words[Word.ROWS_TAKEN])
        memory.integral_rows_taken = int(words[Word.INTEGRAL_ROWS_TAKEN])
        memory.steps_taken = int(words[Word.STEPS_TAKEN])
        memory.samples_taken[:] = words[Word.FIRST_RATE + 1 :: 2]

    def outcome(self, memory: Memory, status: Status | None, failures: list[Failure]) -> Outcome:
        """The answer, with the rows recorded; without a status the first failure gives it."""
        rows, integrals = int(self._words[Word.ROWS_WRITTEN]), int(self._words[Word.INTEGRAL_ROWS_WRITTEN])

        def shaped(values: FloatArray, count: int) -> FloatArray:
            part = values[:count]
            return (part[:, :, 0] if self._lanes == 1 else part).copy()

        return Outcome(
            status=status or failures[0].status,
            time=memory.time,
            index=-1 if status else failures[0].index,
            row_times=self._row_times[:rows].copy(),
            rows=shaped(self._rows, rows),
            integral_times=self._integral_times[:integrals].copy(),
            integrals=shaped(self._integrals, integrals),
            activities=shaped(self._activities, integrals),
            failures=tuple(failures),
        )
