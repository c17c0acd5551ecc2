"""The functions of a program as lists of steps on tables of values, for the interpreted machine.

A value is a float64, or an array of one per lane; the order of operations is that of the native code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from propermodel.codegen.machine import Failure, FloatArray, IntArray, Memory, Status
from propermodel.codegen.numeric import Number, choose, interpolate, newton, operation_of
from propermodel.codegen.program import Array, Extrapolation, Function, ImplicitStep, Program, Solve
from propermodel.codegen.schedule import Call, Item, Store, leaf_slot, sequence
from propermodel.codegen.tables import prepare_tables
from propermodel.expressions.core import Expr, Op


class Working:
    """What functions read and write during one call."""

    def __init__(self, program: Program, lanes: int, memory: Memory) -> None:
        def zeros(array: Array) -> FloatArray:
            count = program.layout.lengths.get(array, 0)
            return np.zeros((count,) if lanes == 1 else (count, lanes))

        self.memory = memory
        self.lanes = lanes
        self.time = memory.time
        self.tables = prepare_tables(program, memory.tables)
        self.failures: list[Failure] = []
        self.arrays: dict[Array, FloatArray] = {
            Array.STATE: memory.state,
            Array.DISCRETE: memory.discrete,
            Array.PARAMETER: memory.parameter,
            Array.UNKNOWN: memory.unknown,
            Array.RATE: zeros(Array.RATE),
            Array.POWER: zeros(Array.POWER),
            Array.SIGNAL: zeros(Array.SIGNAL),
            Array.GUARD: zeros(Array.GUARD),
            Array.JUMP: zeros(Array.JUMP),
            Array.SWITCHING: zeros(Array.SWITCHING),
            Array.STEP: zeros(Array.STEP),
            Array.FACTOR: zeros(Array.FACTOR),
            Array.STAGE: zeros(Array.STAGE),
            Array.WEAK: zeros(Array.WEAK),
            Array.ERROR: zeros(Array.STATE),
        }
        self.pending = 0.0  # the length of an implicit step whose end is not yet in the integrals

    def fail(self, lanes: Sequence[int], number: int) -> None:
        """Record that an implicit block has no solution in some lanes."""
        for lane in lanes:
            self.failures.append(Failure(lane, Status.NOT_CONVERGED, self.time, number))
            self.memory.alive[lane] = False

    def fail_weak(self, start: IntArray) -> None:
        """Record that an implicit step has singular equations in some lanes, and give these their state back."""
        weak = self.arrays[Array.WEAK].reshape(-1)
        for lane in np.flatnonzero(self.memory.alive & (weak != 0.0)):
            self.failures.append(Failure(int(lane), Status.SINGULAR_STEP, self.time, int(weak[lane]) - 1))
            self.memory.alive[lane] = False
            self.memory.state.reshape(-1, self.lanes)[:, lane] = self.arrays[Array.STAGE].reshape(-1, self.lanes)[
                start, lane
            ]


class AllFailed(Exception):
    """No lane is alive."""


class Code:
    """A function as a list of steps on a table of values."""

    def __init__(self, program: Program, function: Function, numbers: dict[Solve, int]) -> None:
        self._layout = program.layout
        self._items: list[Item] = sequence(function, numbers, lambda _: False)
        self._operations: dict[Expr, Callable[[Working, dict[Expr, Number]], Number]] = {}
        for item in self._items:
            if isinstance(item, Expr):
                self._prepare(item)
            elif isinstance(item, Call):
                for node in item.inner:
                    self._prepare(node)

    def __call__(self, run: Working) -> None:
        """Execute the function."""
        values: dict[Expr, Number] = {}
        stores: list[tuple[FloatArray, int, Number]] = []
        for item in self._items:
            if isinstance(item, Expr):
                values[item] = self._operations[item](run, values)
            elif isinstance(item, Store):
                value = self._number(run, values, item.value)
                stores.append((run.arrays[item.slot.array], item.slot.index, value))
            else:
                self._solve(run, values, item)
        for array, index, value in stores:
            array[index] = value

    def _value(self, run: Working, values: dict[Expr, Number], node: Expr) -> Number:
        if node in values:
            return values[node]
        if node.op is Op.CONSTANT:
            return np.float64(node.data[0])
        slot = leaf_slot(self._layout, node)
        if slot.array is Array.TIME:
            return np.float64(run.time)
        entry = run.arrays[slot.array][slot.index]
        value = values[node] = entry.copy() if run.lanes > 1 else entry
        return value

    def _number(self, run: Working, values: dict[Expr, Number], node: Expr) -> Number:
        value = self._value(run, values, node)
        return value * 1.0 if node.is_condition else value

    def _truth(self, run: Working, values: dict[Expr, Number], node: Expr) -> Number:
        value = self._value(run, values, node)
        return value if node.is_condition else value != 0.0

    def _prepare(self, node: Expr) -> None:
        if node.op in (Op.LOOKUP, Op.SLOPE):
            self._operations[node] = self._lookup(node)
            return
        function, truths = operation_of(node)
        readers = [(self._truth if i < truths else self._number, arg) for i, arg in enumerate(node.args)]

        def operation(run: Working, values: dict[Expr, Number]) -> Number:
            return function(*(read(run, values, arg) for read, arg in readers))

        self._operations[node] = operation

    def _lookup(self, node: Expr) -> Callable[[Working, dict[Expr, Number]], Number]:
        index = self._layout.table_index[node.args[0]]
        holds = self._layout.tables[index].extrapolation is Extrapolation.HOLD
        coordinates = node.args[1:]
        axis = None if node.op is Op.LOOKUP else int(node.data)

        def operation(run: Working, values: dict[Expr, Number]) -> Number:
            given = [self._number(run, values, item) for item in coordinates]
            return interpolate(run.tables[index], given, holds, axis)

        return operation

    def _solve(self, run: Working, values: dict[Expr, Number], call: Call) -> None:
        solve = call.solve
        slots = [leaf_slot(self._layout, unknown).index for unknown in solve.unknowns]
        unknown = run.arrays[Array.UNKNOWN]
        start = [unknown[index].copy() if run.lanes > 1 else unknown[index] for index in slots]

        def evaluate(at: list[Number]) -> tuple[list[Number], list[list[Number]]]:
            local = dict(values)
            local.update(zip(solve.unknowns, at, strict=True))
            for node in call.inner:
                local[node] = self._operations[node](run, local)
            residuals = [self._number(run, local, item) for item in solve.residuals]
            return residuals, [[self._number(run, local, item) for item in row] for row in solve.jacobian]

        active = np.array(run.memory.alive) if run.lanes > 1 else np.True_
        solution, failed = newton(call, start, active, evaluate)
        for index, node, first, last in zip(slots, solve.unknowns, start, solution, strict=True):
            unknown[index] = choose(failed, first, last)
            values[node] = unknown[index].copy() if run.lanes > 1 else unknown[index]
        if np.any(failed):
            run.fail([int(lane) for lane in np.flatnonzero(failed)], call.number)


class ImplicitCode:
    """The functions of an implicit step."""

    def __init__(self, program: Program, step: ImplicitStep, numbers: dict[Solve, int]) -> None:
        self.first = Code(program, step.first, numbers)
        self.first_again = None if step.first_again is None else Code(program, step.first_again, numbers)
        self.later = [Code(program, function, numbers) for function in step.later]
        self.middle = None if step.middle is None else Code(program, step.middle, numbers)
        self.shares = step.shares
        self.start: IntArray = np.array([slot.index for slot in step.start], dtype=np.int64)
