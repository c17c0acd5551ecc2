"""The control of the step: what both backends agree on, and its arithmetic for the interpreted one.

The error of a step is the largest of all states, each as a share of `tolerance * size`, where the size of a state is
the largest magnitude that it has had so far (states have units of their own). Up to 1 it is accepted. The next step
follows by a controller with proportional and integral part (Gustafsson 1991; Hairer and Wanner 1996, section IV.2),
with powers that square roots give, so that both backends have the same bits:

    h' = h 0.9 e_before^(1/16) / e^(3/16)      h' = h 0.9 / e^(1/4) after a step that is rejected

Steps end at due instants. What is left before one is taken in one step, or in two of equal length; a step that an
instant has cut says nothing against longer ones, so it does not make the next one shorter than was intended before it.
"""

from __future__ import annotations

import math

import numpy as np

from propermodel.codegen.machine import LEAST_SIZE, SAME_INSTANT, FloatArray, Machine, Memory, Request
from propermodel.diagnostics import ProperModelError

SAFETY = 0.9
LEAST_FACTOR = 0.2  # by which a step becomes shorter at once
MOST_FACTOR = 5.0  # by which it becomes longer
LEAST_ERROR = 1e-10  # smaller ones count as this
LEAST_ERROR_BEFORE = 1e-2  # and as this when the next step looks back
LEAST_SHARE = 1e-12  # the smallest step, as a share of the largest
LEAST_ULPS = 1e-14  # and as a share of the time
TINY = 1e-300  # a size that divides zero
ORDER_OF_FIRST_STEP = 5


def longest_in(left: float, wanted: float) -> tuple[float, bool]:
    """The step to take where an instant is `left` seconds away, and whether it gets there."""
    if wanted >= left * (1.0 - SAME_INSTANT):
        return left, True
    return min(wanted, left * 0.5), False


def root_16(value: float) -> float:
    """The sixteenth root."""
    return math.sqrt(math.sqrt(math.sqrt(math.sqrt(value))))


def factor_accepted(error: float, before: float, most: float) -> float:
    """What to multiply a step with that was accurate enough, at most so much."""
    root = root_16(max(error, LEAST_ERROR))
    factor = SAFETY * root_16(before) / (root * root * root)
    return min(max(factor, LEAST_FACTOR), most)


def factor_rejected(error: float) -> float:
    """What to multiply a step with that was not."""
    return max(SAFETY / math.sqrt(math.sqrt(error)), LEAST_FACTOR) if error < math.inf else LEAST_FACTOR


def smallest_step(time: float, largest: float) -> float:
    """The step below which a run gives up."""
    return max(abs(time) * LEAST_ULPS, largest * LEAST_SHARE)


def least_sizes(memory: Memory, request: Request) -> FloatArray:
    """The size that each state has at least."""
    return request.least_sizes if request.least_sizes.size else np.full(memory.state.shape, LEAST_SIZE)


def prepare_control(machine: Machine, memory: Memory, request: Request) -> None:
    """Before a call: sizes that hold the state as it is, and a first step, if there is none yet.

    The step is that of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (1993), section II.4.
    """
    np.maximum(memory.size, np.abs(memory.state), out=memory.size)
    if memory.next_step > 0.0:
        return
    memory.last_error = 1.0
    with np.errstate(all="ignore"):
        memory.next_step = _first_step(machine, memory, request)


def _first_step(machine: Machine, memory: Memory, request: Request) -> float:
    weights = request.tolerance * np.maximum(memory.size, least_sizes(memory, request))
    trial = memory.copy()
    try:
        rates, _ = machine.rates(trial)
        size, speed = _largest(memory.state / weights), _largest(rates / weights)
        short = 1e-6 if size < 1e-5 or not 1e-5 < speed < math.inf else 0.01 * size / speed
        short = min(short, request.step)
        trial.state += short * rates
        trial.time += short
        curvature = _largest((machine.rates(trial)[0] - rates) / weights) / short
    except ProperModelError:
        return request.step  # the run itself tells what has no solution here
    steep = max(speed, curvature)
    long = max(1e-6, short * 1e-3) if steep <= 1e-15 else (0.01 / steep) ** (1.0 / ORDER_OF_FIRST_STEP)
    chosen = min(100.0 * short, long, request.step)
    return max(chosen, smallest_step(memory.time, request.step)) if chosen > 0.0 else request.step


def _largest(values: FloatArray) -> float:
    return float(np.max(np.abs(values), initial=0.0))
