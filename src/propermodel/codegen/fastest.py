"""How fast the fastest mode of a run is, watched while it goes on: what both backends agree on, and its arithmetic.

A step of an explicit method must not be longer than a small number over the magnitude of the fastest eigenvalue of the
rates, which changes along a run: friction at standstill is some ten times faster than a vehicle that rolls. Every 256
steps a direction in the space of states, each in its own size, is multiplied with the Jacobian by a difference of two
evaluations of the rates, and scaled back: a power iteration that goes on with the run. The factors are averaged, as
those of an oscillation change: what counts is their geometric mean, half of which is the last one. It is a suspicion,
to be looked at more closely: a wrong one costs time, a late one an answer.

What is looked at is the middle of the last step. Where friction bounds what grows, states jump to and fro between two
sides on which nothing is fast any more; what their steps are too long for lies between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from propermodel.codegen.machine import LEAST_SIZE, FloatArray, Machine, Memory, Method
from propermodel.diagnostics import ProperModelError

LOOK_EVERY = 256  # steps
NEVER = 2**62  # steps after which there is no look
NUDGE = 2.0**-20  # of a state, as a share of its size
MOST_ITERATIONS = 60  # at one instant

# The largest product of step and eigenvalue, on the negative axis, with which a method is stable.
LONGEST: Mapping[Method, float] = {Method.EULER: 2.0, Method.SEMI_IMPLICIT: 2.0, Method.RK4: 2.785293563405282}


def first_direction(count: int) -> FloatArray:
    """A direction to which no mode is likely to be orthogonal: multiples of the golden ratio, without whole parts."""
    return np.mod(np.arange(1, count + 1) * (0.5 * (math.sqrt(5.0) - 1.0)), 1.0) - 0.5


def prepare_watch(memory: Memory) -> None:
    """Begin to watch a run that has not been watched yet."""
    if memory.direction.shape != memory.state.shape:
        memory.direction = first_direction(memory.state.size)


def look(memory: Memory, rates: Callable[[], FloatArray]) -> None:
    """Multiply the direction with the Jacobian where the memory is; `rates` evaluates them for the state in it."""
    np.maximum(memory.size, np.abs(memory.state), out=memory.size)
    scale = NUDGE * np.maximum(memory.size, LEAST_SIZE)
    before = rates().copy()
    memory.state += scale * memory.direction
    change = (rates() - before) / scale
    factor = float(np.sqrt(np.sum(change * change)))
    if 0.0 < factor < math.inf:
        memory.direction = change / factor
        memory.fastest = averaged(memory.fastest, factor)


def averaged(fastest: float, factor: float) -> float:
    """The mean of the factors until now, of which this one is half."""
    return math.sqrt(fastest * factor) if fastest else factor


def is_too_fast(memory: Memory, method: Method, step: float) -> bool:
    """Whether a step seems to be longer than is stable."""
    return method in LONGEST and memory.fastest * step > LONGEST[method]


def fastest_at(machine: Machine, memory: Memory) -> tuple[float, int] | None:
    """The magnitude of the fastest eigenvalue where a run is, 1/s, and the state with the largest part in its mode.

    None where the iteration meets equations without a solution, or nothing changes.
    """
    trial = memory.copy()
    trial.fastest = 0.0
    prepare_watch(trial)
    factors: list[float] = []
    try:
        for _ in range(MOST_ITERATIONS):
            trial.state[:], trial.unknown[:] = memory.state, memory.unknown
            trial.fastest = 0.0
            look(trial, lambda: machine.rates(trial)[0])
            factors.append(trial.fastest)
    except ProperModelError:
        return None
    last = factors[len(factors) // 2 :]
    if not all(last):
        return None
    return math.exp(sum(map(math.log, last)) / len(last)), int(np.argmax(np.abs(trial.direction)))
