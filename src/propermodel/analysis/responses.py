"""Answers of a linear model to harmonic inputs, steps and impulses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm, schur, solve_triangular

from propermodel.analysis.spectrum import ROUNDING, ComplexArray, balanced, roots_of
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, SimulationError
from propermodel.expressions.core import Expr

if TYPE_CHECKING:
    from propermodel.analysis.linear_model import LinearModel

DECAYED = 7.0  # time constants after which nothing is seen any more
GROWN = 3.0  # time constants of growth that are shown
CYCLES = 5.0  # cycles of an oscillation that does not decay


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyResponse:
    """The steady answer of every output to every input exp(j omega t), as complex factors in SI."""

    model: LinearModel
    omega: FloatArray  # rad/s
    values: ComplexArray  # frequencies x outputs x inputs

    @property
    def frequency(self) -> FloatArray:
        """The frequencies, Hz."""
        return self.omega / (2.0 * math.pi)

    def of(self, input: Expr | Path | str | None = None, output: Expr | Path | str | None = None) -> ComplexArray:
        """The factors of one output and one input; names may be left out where there is only one.

        Raises:
            SimulationError: there is no such input or output.
        """
        return self.values[:, self.model.output_index(output), self.model.input_index(input)]

    def magnitude(self, input: Expr | Path | str | None = None, output: Expr | Path | str | None = None) -> FloatArray:
        """The ratio of the amplitudes, in SI."""
        return np.abs(self.of(input, output))

    def phase(self, input: Expr | Path | str | None = None, output: Expr | Path | str | None = None) -> FloatArray:
        """By how much the output leads the input, rad, without jumps of a turn."""
        return np.unwrap(np.angle(self.of(input, output)))


@dataclass(frozen=True, eq=False, kw_only=True)
class TimeResponse:
    """Deviations of the outputs from the operating point after an input has changed at time 0, in SI."""

    model: LinearModel
    input: Path
    time: FloatArray  # s, equidistant
    values: FloatArray  # instants x outputs
    impulse: FloatArray  # outputs; the part of the input's impulse that passes straight through at time 0

    def __getitem__(self, output: Expr | Path | str) -> FloatArray:
        """The course of one output.

        Raises:
            SimulationError: there is no such output.
        """
        return self.values[:, self.model.output_index(output)]


def frequency_response(model: LinearModel, omega: Iterable[float] | FloatArray) -> FrequencyResponse:
    """C (j omega - A)^-1 (B + j omega B_rate) + D + j omega D_rate at every omega.

    Args:
        model: The linear model.
        omega: Angular frequencies, rad/s.

    Raises:
        SimulationError: the model answers with a growing amplitude to one of the frequencies.
    """
    at = np.atleast_1d(np.asarray(omega if isinstance(omega, np.ndarray) else list(omega), dtype=np.float64))
    s = 1j * at
    used = connected_states(model)
    A, B, C = model.A[np.ix_(used, used)], model.B[used], model.C[:, used]
    values = model.D + s[:, np.newaxis, np.newaxis] * model.D_rate
    if used.size:
        evened, scale = balanced(A)
        form: Any = schur(evened, output="complex")
        triangle, basis = form
        left = C * scale @ basis
        right, right_rate = (basis.conj().T @ (part / scale[:, np.newaxis]) for part in (B, model.B_rate[used]))
        least = ROUNDING * float(np.linalg.norm(triangle))
        for index, value in enumerate(s):
            shifted = value * np.eye(used.size) - triangle
            if np.min(np.abs(np.diag(shifted))) <= least:
                raise SimulationError.of(
                    "linear/resonance",
                    f"{model.name} has an undamped mode at {at[index]:g} rad/s: no steady answer exists there",
                    help="leave this frequency out (modes() lists them); 0 is one where an output is an integral",
                )
            values[index] += left @ solve_triangular(shifted, right + value * right_rate)
    return FrequencyResponse(model=model, omega=at, values=values)


def step_response(
    model: LinearModel, input: Expr | Path | str | None, duration: float | None, points: int
) -> TimeResponse:
    """The answer to an input that grows by 1 (in SI) at time 0 and stays."""
    column = model.input_index(input)
    B, D = model.input_matrices()
    count = len(model.states)
    time = _instants(model, duration, points)
    system = np.zeros((count + 1, count + 1))
    system[:count, :count], system[:count, count] = model.A, B[:, column]
    start = np.zeros(count + 1)
    start[count] = 1.0
    states = _course(model, system, start, time)
    return TimeResponse(
        model=model,
        input=model.inputs[column],
        time=time,
        values=states @ np.column_stack((model.C, D[:, column])).T,
        impulse=np.zeros(len(model.outputs)),
    )


def impulse_response(
    model: LinearModel, input: Expr | Path | str | None, duration: float | None, points: int
) -> TimeResponse:
    """The answer to an input that is an impulse of area 1 (in SI) at time 0."""
    column = model.input_index(input)
    B, D = model.input_matrices()
    time = _instants(model, duration, points)
    states = _course(model, model.A, B[:, column], time)
    return TimeResponse(
        model=model, input=model.inputs[column], time=time, values=states @ model.C.T, impulse=D[:, column].copy()
    )


def _course(model: LinearModel, system: FloatArray, start: FloatArray, time: FloatArray) -> FloatArray:
    """The solution of x' = system x at equidistant instants, exact to rounding."""
    evened, scale = balanced(system)
    step = scale[:, np.newaxis] * expm(evened * (time[1] - time[0])) / scale
    states = np.empty((len(time), len(system)))
    states[0] = start
    with np.errstate(all="ignore"):
        for index in range(1, len(time)):
            states[index] = step @ states[index - 1]
    if not np.isfinite(states).all():
        raise SimulationError.of(
            "linear/not-finite",
            f"the response of {model.name} grows beyond all numbers within {time[-1]:g} s: it is unstable",
            help="choose a shorter duration",
        )
    return states


def _instants(model: LinearModel, duration: float | None, points: int) -> FloatArray:
    end = _natural_duration(model) if duration is None else duration
    if points < 2 or not (math.isfinite(end) and end > 0.0):
        raise SimulationError.of(
            "linear/duration",
            f"a response of {points} points within {end:g} s cannot be computed",
            help="give a positive duration and at least 2 points",
        )
    return np.linspace(0.0, end, points)


def _natural_duration(model: LinearModel) -> float:
    """A time in which every mode is seen, s."""
    longest = 0.0
    growing: list[float] = []
    used = connected_states(model)
    for root in roots_of(model.A[np.ix_(used, used)]):
        rate = root.value.real
        if rate > 0.0:
            growing.append(GROWN / rate)
        elif rate < 0.0:
            longest = max(longest, DECAYED / -rate)
        elif root.is_pair:
            longest = max(longest, CYCLES * 2.0 * math.pi / root.value.imag)
    return min(growing) if growing else longest or 1.0


def connected_states(
    model: LinearModel, inputs: Iterable[int] | None = None, outputs: Iterable[int] | None = None
) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """The states that inputs reach and that reach outputs, by the entries that are not zero; of all by default."""
    columns = slice(None) if inputs is None else list(inputs)
    rows = slice(None) if outputs is None else list(outputs)
    moved = (model.B[:, columns] != 0.0).any(axis=1) | (model.B_rate[:, columns] != 0.0).any(axis=1)
    seen = (model.C[rows] != 0.0).any(axis=0)
    acts_on = model.A != 0.0
    return np.flatnonzero(_closure(acts_on, moved) & _closure(acts_on.T, seen))


def _closure(
    acts_on: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], start: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """All that is reached from a start, where entry (i, k) says that k acts on i."""
    reached = start.copy()
    fresh = np.flatnonzero(reached)
    while fresh.size:
        fresh = np.flatnonzero(acts_on[:, fresh].any(axis=1) & ~reached)
        reached[fresh] = True
    return reached
