"""What every backend shares at run time: the working memory of a run, what is asked of it, what it answers.

Time is divided into ticks. A tick ends at the next due instant among: the next sample of each rate, the next signal
row, the next integral row, and the end of the request. Instants are `origin + k * period` with whole k, so no error
accumulates; instants closer than a billionth of a step are one. At an instant, in this order: the controllers that are
due, by rate; the rows that are due; then equal steps to the next instant, or such as the control of the step chooses
(`step_control.py`); then the check of every state.

A program with events is run in one lane. After every step its guards are compared with those before; where one has
become positive, the step is taken back and the run returns, so that the caller finds the instant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propermodel.codegen.program import Array, Program, Slot
from propermodel.codegen.schedule import number_solves
from propermodel.diagnostics import ProperModelError, SimulationError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

# Instants this close, in steps, are one instant; a remainder this small needs no step of its own.
SAME_INSTANT = 1e-9
# States smaller than this, in SI units, count as being of this size.
LEAST_SIZE = 1e-9
# Inside a long tick, a run that has failed in every lane is noticed after so many steps.
STEPS_BETWEEN_CHECKS = 256
# Inside a long tick, a run that controls its steps pauses after so many.
STEPS_BETWEEN_PAUSES = 4096


class Method(StrEnum):
    """How a step is taken. All copy before they write, as a derivative may itself be a state."""

    EULER = "euler"
    SEMI_IMPLICIT = "semi-implicit-euler"  # momenta first, displacements with the new momenta at the new time
    RK4 = "rk4"
    ROS2 = "ros2"  # linearly implicit, L-stable
    RODAS = "rodas"  # linearly implicit, L-stable, of order 4, controls its step
    DOPRI5 = "dopri5"  # explicit, of order 5, controls its step
    CVODE = "cvode"  # implicit, of varying order, by SUNDIALS and slow: for comparison

    @property
    def is_adaptive(self) -> bool:
        """Whether it chooses its steps by an estimate of their error."""
        return self in (Method.RODAS, Method.DOPRI5, Method.CVODE)

    @property
    def is_generated(self) -> bool:
        """Whether its steps are generated code."""
        return self is not Method.CVODE

    @property
    def is_implicit(self) -> bool:
        """Whether stiff parts do not limit its step."""
        return self in (Method.ROS2, Method.RODAS, Method.CVODE)


# The seam for quadratures: the share of the step that each evaluation of POWER stands for. Those of an implicit step
# are at its beginning and at its end, where one serves the next step, too. Methods that control their step go by the
# parabola through the powers at its beginning, middle and end.
QUADRATURE: Mapping[Method, tuple[float, ...]] = {
    Method.EULER: (1.0,),
    Method.SEMI_IMPLICIT: (1.0,),
    Method.RK4: (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0),
    Method.ROS2: (0.5, 0.5),
}


class Status(StrEnum):
    """How a call of `run` ended."""

    FINISHED = "finished"
    PAUSED = "paused"  # a buffer is full or enough ticks were done; call again
    NOT_FINITE = "not-finite"
    OUT_OF_RANGE = "out-of-range"
    NOT_CONVERGED = "not-converged"
    SINGULAR_STEP = "singular-step"  # the equations of an implicit step have no solution
    STEP_TOO_SMALL = "step-too-small"  # no step is short enough for the tolerance
    EVENT = "event"  # the next step, of the length that is told, would make a guard positive; it has not been taken


@dataclass(frozen=True, eq=False)
class TableData:
    """The numbers of one table: one or two strictly growing grids, and values (two-dimensional: first grid slowest)."""

    grids: tuple[FloatArray, ...]
    values: FloatArray

    def __post_init__(self) -> None:
        grids = tuple(_frozen(grid) for grid in self.grids)
        object.__setattr__(self, "grids", grids)
        object.__setattr__(self, "values", _frozen(self.values))


def _frozen(values: ArrayLike) -> FloatArray:
    result = np.array(values, dtype=np.float64, order="C")
    result.flags.writeable = False
    return result


@dataclass(kw_only=True)
class Memory:
    """The working memory of one run: everything needed to continue it from its last state.

    Arrays have shape (n,) for one lane and (n, lanes) for several. `alive` has one entry per lane: a lane whose run has
    failed goes on computing, but its numbers mean nothing and are no longer checked.
    """

    time: float
    origin: float
    state: FloatArray
    discrete: FloatArray
    parameter: FloatArray
    unknown: FloatArray
    guard: FloatArray  # of each event when it was last looked at; negative at the origin, as if nothing held before
    integral: FloatArray  # of each POWER entry, since the origin
    activity: FloatArray  # of its absolute value
    lower: FloatArray  # limits of every state
    upper: FloatArray
    size: FloatArray  # the largest magnitude of every state so far, where steps are controlled or watched
    least: FloatArray  # of every selected signal since the last row, where a request asks for extremes
    greatest: FloatArray
    direction: FloatArray  # of the fastest mode, each state in its size, where it is watched
    tables: tuple[TableData, ...]
    samples_taken: IntArray  # for each rate
    alive: BoolArray
    rows_taken: int = 0
    integral_rows_taken: int = 0
    steps_taken: int = 0
    steps_rejected: int = 0  # too inaccurate, and taken again shorter
    next_step: float = 0.0  # of a method that controls it, s; 0: not yet chosen
    fastest: float = 0.0  # estimate of the fastest eigenvalue, 1/s, where it is watched (`fastest.py`)
    next_look: int = 0  # number of steps after which it is looked for again
    last_error: float = 1.0  # of the last step that was not cut by an instant, as a share of what is tolerated

    def copy(self) -> Memory:
        """An independent memory with the same content; tables are shared, as they are never written."""
        values: dict[str, Any] = {item.name: getattr(self, item.name) for item in fields(self)}
        return Memory(**{k: cast(Any, v).copy() if isinstance(v, np.ndarray) else v for k, v in values.items()})


def start_memory(
    program: Program,
    values: Mapping[Array, ArrayLike] | None = None,
    *,
    tables: Sequence[TableData] = (),
    origin: float = 0.0,
    lanes: int = 1,
) -> Memory:
    """A memory at its origin; arrays not given are zero, one-lane values are spread over all lanes."""
    given = values or {}

    def filled(array: Array) -> FloatArray:
        count = program.layout.lengths.get(array, 0)
        shape = (count,) if lanes == 1 else (count, lanes)
        result = np.zeros(shape)
        if array in given:
            value = np.asarray(given[array], dtype=np.float64)
            result[...] = value[:, np.newaxis] if lanes > 1 and value.ndim == 1 else value
        return result

    state = filled(Array.STATE)
    power = filled(Array.POWER)
    return Memory(
        time=origin,
        origin=origin,
        state=state,
        discrete=filled(Array.DISCRETE),
        parameter=filled(Array.PARAMETER),
        unknown=filled(Array.UNKNOWN),
        guard=filled(Array.GUARD) - 1.0,
        integral=power,
        activity=power.copy(),
        lower=np.full_like(state, -math.inf),
        upper=np.full_like(state, math.inf),
        size=np.zeros_like(state),
        least=np.zeros(0),
        greatest=np.zeros(0),
        direction=np.zeros(0),
        tables=tuple(tables),
        samples_taken=np.zeros(len(program.samples), dtype=np.int64),
        alive=np.ones(lanes, dtype=np.bool_),
    )


def _no_selection() -> IntArray:
    return np.zeros(0, dtype=np.int64)


def _no_numbers() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Request:
    """What one call of `run` shall do. An infinite period has its only instant at the origin.

    Keep both periods, and what is selected, for the whole run: the memory counts the rows already taken, and holds the
    extremes since the last of them. These are looked for after every step and on either side of every instant.
    """

    until: float
    step: float
    row_period: float = math.inf
    integral_period: float = math.inf
    selected: IntArray = field(default_factory=_no_selection)  # indices of SIGNAL to record
    has_extremes: bool = False  # whether the least and greatest values since the row before come with every row
    most_rows: int = 4096  # room for rows of each kind; when it is used up, the run pauses
    most_ticks: int = 1_000_000
    jacobian_every: int = 1  # steps that an implicit method takes with one Jacobian, within a tick
    is_watched: bool = False  # whether one lane with steps of one length also pauses where these seem to be unstable
    tolerance: float = 1e-4  # error of a state in one step, as a share of its size, where steps are controlled
    least_sizes: FloatArray = field(default_factory=_no_numbers)  # that states count as having; none: LEAST_SIZE


@dataclass(frozen=True)
class Failure:
    """Why the run of one lane ended early: `index` is a state, or for NOT_CONVERGED the number of a Solve."""

    lane: int
    status: Status
    time: float
    index: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """How a call of `run` ended and the rows it recorded.

    With several lanes `failures` lists those that failed during this call; the status is a failure (the first of them)
    only when no lane is left. Rows have the shape (rows, selected) or (rows, selected, lanes).
    """

    status: Status
    time: float
    index: int  # of the state or the Solve that failed, otherwise -1
    row_times: FloatArray
    rows: FloatArray
    integral_times: FloatArray
    integrals: FloatArray
    activities: FloatArray
    least: FloatArray  # of the signals between the row before and this one, both included; no rows if not asked for
    greatest: FloatArray
    failures: tuple[Failure, ...] = ()
    step: float = 0.0  # the length of the step in which an event lies, s


class Machine(Protocol):
    """A program made executable; it holds no state of a run, so threads may share it."""

    @property
    def program(self) -> Program:
        """The program it executes."""
        ...

    @property
    def method(self) -> Method:
        """How it takes a step."""
        ...

    @property
    def lanes(self) -> int:
        """How many runs it does side by side."""
        ...

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        ...

    def rates(self, memory: Memory) -> tuple[FloatArray, FloatArray]:
        """The RATE and POWER arrays at the memory's time; the memory is not changed."""
        ...

    def observe(self, memory: Memory) -> FloatArray:
        """The SIGNAL array at the memory's time; the memory is not changed."""
        ...

    def sample(self, memory: Memory) -> None:
        """Apply all controllers once, by rate, without counting a sample."""
        ...

    def guards(self, memory: Memory) -> FloatArray:
        """The GUARD array at the memory's time; the memory is not changed."""
        ...

    def jumps(self, memory: Memory) -> FloatArray:
        """The JUMP array at the memory's time; the memory is not changed."""
        ...

    def switching(self, memory: Memory) -> FloatArray:
        """The SWITCHING array at the memory's time; the memory is not changed."""
        ...

    def advance(self, memory: Memory, step: float) -> None:
        """Take one step of this length whatever the guards say.

        Raises:
            SimulationError: an implicit block has no solution.
        """
        ...


def sample_periods(program: Program, memory: Memory) -> list[float]:
    """The period of each rate, from the parameters.

    Raises:
        ValueError: a period is not positive, or differs between lanes.
    """
    result: list[float] = []
    for index in program.periods:
        values = np.atleast_1d(memory.parameter[index])
        if not np.all(values > 0.0):
            raise ValueError(f"the sample period in parameter {index} is {values.min()}; it must be positive")
        if np.any(values != values[0]):
            raise ValueError(f"the sample period in parameter {index} differs between lanes, which sample together")
        result.append(float(values[0]))
    return result


def check_memory(program: Program, lanes: int, memory: Memory) -> None:
    """Check that a memory fits a program.

    Raises:
        ValueError: an array has another shape.
    """
    lengths = program.layout.lengths
    wanted = {
        "state": Array.STATE,
        "lower": Array.STATE,
        "upper": Array.STATE,
        "size": Array.STATE,
        "discrete": Array.DISCRETE,
        "parameter": Array.PARAMETER,
        "unknown": Array.UNKNOWN,
        "guard": Array.GUARD,
        "integral": Array.POWER,
        "activity": Array.POWER,
    }
    for name, array in wanted.items():
        count = lengths.get(array, 0)
        shape = (count,) if lanes == 1 else (count, lanes)
        given: FloatArray = getattr(memory, name)
        if given.shape != shape or given.dtype != np.float64:
            raise ValueError(f"memory.{name} is {given.dtype} of shape {given.shape}, expected float64 {shape}")
    if memory.samples_taken.shape != (len(program.samples),):
        raise ValueError(f"memory.samples_taken has {memory.samples_taken.size} rates, expected {len(program.samples)}")
    if memory.alive.shape != (lanes,):
        raise ValueError(f"memory.alive has shape {memory.alive.shape}, expected ({lanes},)")
    if len(memory.tables) != len(program.layout.tables):
        raise ValueError(f"the program has {len(program.layout.tables)} tables, the memory {len(memory.tables)}")


def check_request(program: Program, memory: Memory, request: Request) -> None:
    """Check that a request can be run.

    Raises:
        ValueError: a number is out of its range.
    """
    if not (request.step > 0.0 and math.isfinite(request.step)):
        raise ValueError(f"the step is {request.step} s; it must be positive")
    if not math.isfinite(request.until) or (request.until - memory.time) / request.step > 2**52:
        raise ValueError(f"the end is {request.until} s; it cannot be reached in steps of {request.step} s")
    if not (request.row_period > 0.0 and request.integral_period > 0.0):
        raise ValueError("the periods of rows must be positive; infinity records the origin only")
    if request.most_rows < 1 or request.most_ticks < 1:
        raise ValueError("most_rows and most_ticks must be at least 1")
    if request.jacobian_every < 1:
        raise ValueError(f"a Jacobian serves at least 1 step, not {request.jacobian_every}")
    if not 0.0 < request.tolerance < 1.0:
        raise ValueError(f"the tolerance is {request.tolerance}; it must be between 0 and 1")
    count = program.layout.lengths.get(Array.STATE, 0)
    if request.least_sizes.size and (request.least_sizes.shape != (count,) or not np.all(request.least_sizes > 0.0)):
        raise ValueError(f"least sizes must be {count} positive numbers, one for each state")
    count = program.layout.lengths.get(Array.SIGNAL, 0)
    selected = request.selected
    if selected.size and not (int(selected.min()) >= 0 and int(selected.max()) < count):
        raise ValueError(f"selected signals must be between 0 and {count - 1}")
    if not memory.alive.any() and memory.alive.size > 1:
        raise ValueError("every lane of this memory has failed")


def open_extremes(memory: Memory, request: Request) -> None:
    """Make room for the extremes since the last row, where a request asks for them and there is none."""
    shape = (request.selected.size, *memory.state.shape[1:])
    if request.has_extremes and memory.least.shape != shape:
        memory.least, memory.greatest = np.full(shape, math.inf), np.full(shape, -math.inf)


def instant(origin: float, count: int, period: float) -> float:
    """The instant number `count` of a period."""
    return origin + count * period if count else origin


def count_from(memory: Memory, request: Request, count: int, period: float) -> int:
    """The number of the next instant of a row, instants before the memory's time skipped."""
    if math.isinf(period):
        return max(count, 1 if memory.time > memory.origin + SAME_INSTANT * request.step else 0)
    passed = (memory.time - SAME_INSTANT * request.step - memory.origin) / period
    return max(count, math.ceil(passed)) if passed > 0.0 else count


def has_risen(before: FloatArray, after: FloatArray) -> BoolArray:
    """The guards that have become positive."""
    return (after > 0.0) & ~(before > 0.0)


def state_failures(memory: Memory) -> list[Failure]:
    """The lanes that are alive and have a state that is not finite or outside its limits, with the first such state."""
    lanes = memory.alive.size
    state, lower, upper = (array.reshape(-1, lanes) for array in (memory.state, memory.lower, memory.upper))
    finite = np.isfinite(state)
    bad = ~(finite & (state >= lower) & (state <= upper))
    found: list[Failure] = []
    for lane in np.flatnonzero(memory.alive & bad.any(axis=0)):
        # A state that is no number explains more than one that is only large.
        wrong = ~finite[:, lane] if not finite[:, lane].all() else bad[:, lane]
        index = int(np.argmax(wrong))
        status = Status.OUT_OF_RANGE if finite[index, lane] else Status.NOT_FINITE
        found.append(Failure(int(lane), status, memory.time, index))
    return found


def not_solved(program: Program, failure: Failure) -> ProperModelError:
    """The error of an evaluation or a single step whose equations have no solution."""
    if failure.status is Status.SINGULAR_STEP:
        leaf = next(leaf for leaf, slot in program.layout.slots.items() if slot == Slot(Array.STATE, failure.index))
        return SimulationError.of(
            "simulation/step",
            f"the equations of an implicit step are singular at {failure.time:g} s, first that of {leaf.data.path}",
            help="try a smaller step, or rk4",
        )
    solve = list(number_solves(program))[failure.index]
    return SimulationError.of(
        "simulation/not-converged",
        f"the implicit block of {', '.join(str(path) for path in solve.paths)} has no solution at {failure.time:g} s",
        help="check the initial values and the laws around this loop",
    )
