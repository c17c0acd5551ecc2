"""The largest step that a method can take, from the Jacobian at one instant.

An explicit method lets numbers grow that the model does not, when its step is too long for a fast mode; where friction
or limits bound them, they chatter. What is looked at is linear: elsewhere in a run the limit may be another.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray, Memory, Method
from propermodel.codegen.program import Layout
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError
from propermodel.modelling.model import Scenario
from propermodel.simulation.point import Point
from propermodel.simulation.start import begin

MOST_STATES = 300  # of a model whose spectrum is looked at
GROWTH = 1e3  # of numbers over a run, beyond what the model does: less is not noticed
_BISECTIONS = 40


@dataclass(frozen=True)
class StepLimit:
    """The largest step of a method that is stable at an instant, and the mode that limits it."""

    method: Method
    step: float  # s; infinite where nothing limits it
    rate: complex  # eigenvalue of the mode, 1/s; 0 where there is none
    state: Path  # that has the largest part in the mode; empty where there is none

    def __str__(self) -> str:
        if math.isinf(self.step):
            return f"{self.method} is stable with any step here"
        return (
            f"{self.method} is stable with steps up to {self.step:.2g} s here: {self.state} has the eigenvalue "
            f"{self.rate.real:.4g}{f' +- {abs(self.rate.imag):.4g}i' if self.rate.imag else ''} 1/s"
        )


def step_limit(
    compiled: CompiledModel, at: Scenario | Memory, method: Method, *, window: float | None = None
) -> StepLimit:
    """The largest stable step at the start of a scenario, or where a run is (`trajectory.memory`).

    Args:
        compiled: The model.
        at: The instant.
        method: How a step is taken.
        window: The duration over which numbers may grow a thousandfold, s; by default that of the scenario, or 1000 s.

    Raises:
        SimulationError: the scenario does not fit, or the derivatives do not exist there.
    """
    if window is None:
        window = at.stop - at.start if isinstance(at, Scenario) else 1000.0
    memory = begin(compiled, at) if isinstance(at, Scenario) else at
    return _limit(compiled, memory, method, window)


def note_on_step(compiled: CompiledModel, memory: Memory, method: Method, step: float, window: float) -> str | None:
    """What to say where a step is too long at the start of a run; nothing about large models."""
    limit = limit_below(compiled, memory, method, step, window)
    if limit is None:
        return None
    return f"a step of {step:g} s is too long at the start: {limit}; take a smaller step, or the method ros2 or rodas"


def reason_in_step(compiled: CompiledModel, before: Memory, method: Method, step: float) -> str | None:
    """What to say where numbers have grown without end shortly after an instant, if the step was too long there."""
    limit = limit_below(compiled, before, method, step, GROWTH * step)
    if limit is None:
        return None
    return (
        f"steps of {step:g} s are too long: at {before.time:.4g} s {limit}; take a smaller step, or the method ros2 "
        "or rodas"
    )


def limit_below(
    compiled: CompiledModel, memory: Memory, method: Method, step: float, window: float
) -> StepLimit | None:
    """The limit, if a step is beyond it; none for methods that look after it themselves, and for large models."""
    if method.is_implicit or method.is_adaptive or len(compiled.system.states) > MOST_STATES:
        return None
    try:
        limit = _limit(compiled, memory, method, window, longest=step)
    except SimulationError:
        return None  # the run itself tells what is wrong there
    return None if math.isinf(limit.step) else limit


def _limit(
    compiled: CompiledModel, memory: Memory, method: Method, window: float, longest: float | None = None
) -> StepLimit:
    """The limit below a longest step, or where that is None, of all."""
    states = compiled.system.states
    point = Point(compiled.system, compiled.lowered, memory)
    matrix = point.matrix([state.derivative for state in states], [state.symbol for state in states])
    free = StepLimit(method, math.inf, 0.0, Path())
    if method.is_implicit or not matrix.size or not np.isfinite(matrix).all():
        return free
    rates = np.linalg.eigvals(matrix)
    own = max(0.0, float(rates.real.max()))
    amplify = _amplification(matrix, method, compiled.lowered.program.layout)

    def is_stable(step: float) -> bool:
        size = float(np.abs(np.linalg.eigvals(amplify(step))).max())
        return size <= 1.0 or math.log(size) * window / step <= own * window + math.log(GROWTH)

    fastest = max((float(abs(rate)) for rate in rates if rate.real <= 0.0), default=0.0)
    if not fastest:
        return free
    # No explicit method here is stable with so much for a real or an imaginary eigenvalue.
    high = longest or 6.0 / fastest
    if is_stable(high):
        return free
    low = 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    values, vectors = np.linalg.eig(amplify(high))
    growing = int(np.argmax(np.abs(values)))
    state = int(np.argmax(np.abs(vectors[:, growing] * np.linalg.pinv(vectors)[growing])))
    return StepLimit(method, low, _rate_of(matrix, state), states[state].path)


def _rate_of(matrix: FloatArray, state: int) -> complex:
    """The eigenvalue of the fastest mode in which a state has a tenth or more."""
    values, vectors = np.linalg.eig(matrix)
    shares = np.abs(vectors[state] * np.linalg.pinv(vectors)[:, state])
    return complex(max(values[shares >= min(0.1, shares.max())], key=abs))


def _amplification(matrix: FloatArray, method: Method, layout: Layout) -> Callable[[float], FloatArray]:
    """What a step of some length multiplies small deviations with."""
    unit = np.eye(len(matrix))
    momenta, displacements = (np.isin(np.arange(len(matrix)), rows) for rows in (layout.momenta, layout.displacements))
    others = ~(momenta | displacements)

    def amplify(step: float) -> FloatArray:
        change = step * matrix
        match method:
            case Method.RK4:
                return unit + change @ (unit + change @ (unit + change @ (unit + change / 4.0) / 3.0) / 2.0)
            case Method.DOPRI5:
                return unit + _polynomial(change, _DOPRI5_GROWTH)
            case Method.SEMI_IMPLICIT:
                first = unit + momenta[:, np.newaxis] * change
                return first + displacements[:, np.newaxis] * (change @ first) + others[:, np.newaxis] * change
            case _:
                return unit + change

    return amplify


# The coefficients of R(z) - 1, lowest power first: those of the exponential up to order 5.
_DOPRI5_GROWTH = (1.0, 1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 600)


def _polynomial(matrix: FloatArray, coefficients: tuple[float, ...]) -> FloatArray:
    """The sum of coefficients times powers of a matrix, from the first power on."""
    total = np.zeros_like(matrix)
    for coefficient in reversed(coefficients):
        total = matrix @ (total + coefficient * np.eye(len(matrix)))
    return total
