"""What native code works on: one block of numbers, descriptors of tables, and the control block of a call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from propermodel.codegen.arrangement import Arrangement
from propermodel.codegen.control_block import Word
from propermodel.codegen.fastest import NEVER
from propermodel.codegen.llvm_tables import AXIS_WORDS, DESCRIPTOR_WORDS
from propermodel.codegen.machine import (
    Failure,
    FloatArray,
    IntArray,
    Memory,
    Outcome,
    Request,
    Status,
    TableData,
    count_from,
)
from propermodel.codegen.program import Array, Program
from propermodel.codegen.tables import PreparedTable, prepare_tables

_SIZE = "size"  # a region of code that controls its steps, or watches them
_DIRECTION = "direction"  # of code that watches its steps
_LARGEST = float(np.finfo(np.float64).max)


class Work:
    """The block of numbers of one call, filled from a memory."""

    def __init__(self, arrangement: Arrangement, memory: Memory, tables: ReadyTables) -> None:
        self._arrangement = arrangement
        self._lanes = arrangement.lanes
        self._state_rows = arrangement.state_rows
        self._power_rows = arrangement.power_rows
        self._memory = memory
        storage = np.zeros(arrangement.rows * self._lanes + 16)
        skip = (-storage.ctypes.data % 64) // 8
        self._storage = storage  # keeps the block alive
        self._block = storage[skip : skip + arrangement.rows * self._lanes].reshape(arrangement.rows, self._lanes)
        self.address = self._block.ctypes.data
        self._tables = tables  # keeps what the code has pointers to
        self.tables_address = tables.descriptors.ctypes.data
        self._fill()

    def _fill(self) -> None:
        memory, block, regions = self._memory, self._block, self._arrangement.regions
        for region, values in (
            (Array.DISCRETE, memory.discrete),
            (Array.PARAMETER, memory.parameter),
            (Array.UNKNOWN, memory.unknown),
        ):
            rows = self._rows(values)
            block[regions[region] : regions[region] + len(rows)] = rows
        for region, values in (("integral", memory.integral), ("activity", memory.activity)):
            block[regions[region] + self._power_rows] = self._rows(values)
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
        if memory.guard.size:
            before = regions["guard.before"]
            block[before : before + memory.guard.size] = self._rows(memory.guard)
        if _SIZE in regions:
            block[regions[_SIZE] + self._state_rows] = self._rows(memory.size)
        if _DIRECTION in regions and memory.direction.size:
            block[regions[_DIRECTION] + self._state_rows] = self._rows(memory.direction)
        self.read_alive()

    def set_least_sizes(self, sizes: FloatArray) -> None:
        """Tell code that controls its steps the size that each state has at least."""
        self._block[self._arrangement.regions["least.size"] + self._state_rows] = self._rows(sizes)

    def worst_state(self) -> int:
        """The state with the largest error in the last step."""
        errors = self._block[self._arrangement.regions[Array.ERROR] + self._state_rows]
        return int(np.argmax(errors[:, 0]))

    def _rows(self, values: FloatArray) -> FloatArray:
        return values.reshape(-1, self._lanes)

    def read_alive(self) -> None:
        """Let the code know which lanes are alive; a single lane always is."""
        alive = self._memory.alive if self._lanes > 1 else True
        self._block[self._arrangement.regions["alive"]] = alive

    def get(self, array: Array) -> FloatArray:
        """A copy of an array as memories have it."""
        start = self._arrangement.regions[array]
        count = self._arrangement.lengths.get(array, 0)
        return self._shaped(self._block[start : start + count])

    def rate(self) -> FloatArray:
        """The rates in the order of the states."""
        return self._shaped(self._block[self._arrangement.regions[Array.RATE] + self._state_rows])

    def power(self) -> FloatArray:
        """The powers in their order in the program."""
        return self._shaped(self._block[self._arrangement.regions[Array.POWER] + self._power_rows])

    def _shaped(self, rows: FloatArray) -> FloatArray:
        return rows[:, 0].copy() if self._lanes == 1 else rows.copy()

    def write_back(self) -> None:
        """Bring what has changed into the memory."""
        memory, block, regions = self._memory, self._block, self._arrangement.regions
        for region, values in (
            (Array.DISCRETE, memory.discrete),
            (Array.UNKNOWN, memory.unknown),
        ):
            rows = self._rows(values)
            rows[...] = block[regions[region] : regions[region] + len(rows)]
        for region, values in (("integral", memory.integral), ("activity", memory.activity)):
            self._rows(values)[...] = block[regions[region] + self._power_rows]
        self._rows(memory.state)[...] = block[regions[Array.STATE] + self._state_rows]
        if _SIZE in regions:
            self._rows(memory.size)[...] = block[regions[_SIZE] + self._state_rows]
        if _DIRECTION in regions and memory.direction.size:
            self._rows(memory.direction)[...] = block[regions[_DIRECTION] + self._state_rows]
        if memory.guard.size:
            before = regions["guard.before"]
            self._rows(memory.guard)[...] = block[before : before + memory.guard.size]

    def event_step(self) -> float:
        """The length of the step in which an event lies."""
        return float(self._block[self._arrangement.regions["event.step"], 0])

    def solve_failures(self) -> list[Failure]:
        """The solves and implicit steps that have failed since the last call, at most one in each lane."""
        regions = self._arrangement.regions
        numbers = self._block[regions["failed"]]
        times = self._block[regions["failed_time"]]
        found: list[Failure] = []
        for lane in np.flatnonzero(numbers):
            number = int(numbers[lane])  # of a solve, or less than 0 of a state
            status = Status.NOT_CONVERGED if number > 0 else Status.SINGULAR_STEP
            found.append(Failure(int(lane), status, float(times[lane]), abs(number) - 1))
        numbers[:] = 0.0
        return found


@dataclass(frozen=True, eq=False)
class ReadyTables:
    """Tables ready for look-up, with the descriptors that native code reads."""

    tables: tuple[TableData, ...]
    prepared: list[PreparedTable]
    descriptors: IntArray


def ready_tables(program: Program, tables: tuple[TableData, ...]) -> ReadyTables:
    """The tables of a program for native code.

    Raises:
        ValueError: a table does not fit its slot.
    """
    prepared = prepare_tables(program, tables)
    return ReadyTables(tables, prepared, _descriptors(prepared))


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


class Control:
    """The control block of one call and the buffers for its rows."""

    def __init__(self, arrangement: Arrangement, memory: Memory, request: Request, periods: Sequence[float]) -> None:
        lanes = arrangement.lanes
        powers = arrangement.lengths.get(Array.POWER, 0)
        self._lanes = lanes
        self._power_rows = arrangement.power_rows
        self._selected = np.ascontiguousarray(request.selected, dtype=np.int64)
        most = request.most_rows
        self._row_times, self._integral_times = np.empty(most), np.empty(most)
        self._rows = np.empty((most, self._selected.size, lanes))
        self._integrals, self._activities = np.empty((most, powers, lanes)), np.empty((most, powers, lanes))
        extremes = (most if request.has_extremes else 0, self._selected.size, lanes)
        self._least, self._greatest = np.empty(extremes), np.empty(extremes)
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
        words[Word.JACOBIAN_EVERY] = request.jacobian_every
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
        numbers[Word.TOLERANCE] = request.tolerance
        numbers[Word.NEXT_STEP] = memory.next_step
        numbers[Word.LAST_ERROR] = memory.last_error
        words[Word.STEPS_REJECTED] = memory.steps_rejected
        numbers[Word.FASTEST] = memory.fastest
        words[Word.NEXT_LOOK] = memory.next_look if request.is_watched else NEVER
        self._is_watched = request.is_watched
        if request.has_extremes:
            words[Word.LEAST] = memory.least.ctypes.data
            words[Word.GREATEST] = memory.greatest.ctypes.data
            words[Word.LEAST_ROWS] = self._least.ctypes.data
            words[Word.GREATEST_ROWS] = self._greatest.ctypes.data
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
        memory.next_step = float(self._numbers[Word.NEXT_STEP])
        memory.last_error = float(self._numbers[Word.LAST_ERROR])
        memory.fastest = float(self._numbers[Word.FASTEST])
        if self._is_watched:
            memory.next_look = int(words[Word.NEXT_LOOK])
        memory.steps_rejected = int(words[Word.STEPS_REJECTED])
        memory.samples_taken[:] = words[Word.FIRST_RATE + 1 :: 2]

    def outcome(self, memory: Memory, status: Status | None, failures: list[Failure], step: float) -> Outcome:
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
            integrals=shaped(self._integrals, integrals)[:, self._power_rows],
            activities=shaped(self._activities, integrals)[:, self._power_rows],
            least=shaped(self._least, rows),
            greatest=shaped(self._greatest, rows),
            failures=tuple(failures),
            step=step,
        )
