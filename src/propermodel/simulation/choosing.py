"""The method of a run, chosen by a short trial: which steps its accuracy asks for, and which ones stability.

The trial goes through the first part of the scenario with the implicit method that controls its steps, and looks at the
eigenvalues of the Jacobian along it. Where the error allows steps that are much longer than an explicit method could
take, the model is stiff there.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import Literal

from propermodel.codegen.machine import Machine, Memory, Method, Request, Status
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import SimulationError
from propermodel.simulation.stability import MOST_STATES, StepLimit, step_limit
from propermodel.simulation.stepping import Stepping

AUTO = "auto"
Choice = Method | Literal["auto"]

LOOKS = 5  # instants at which eigenvalues are looked at
SHARE = 0.02  # of the window that is tried
MOST_TRIAL_STEPS = 20_000
# A linearly implicit step costs about as much as so many explicit ones, and more with every entry of its factors.
COST_OF_IMPLICIT = 3.0


def choose(
    compiled: CompiledModel, memory: Memory, wanted: Stepping, longest: float, stop: float
) -> tuple[Stepping, str]:
    """The method for a run from here, and in words what was chosen and why.

    Args:
        compiled: The model.
        memory: The run at its start; it is not changed.
        wanted: The step and tolerance that were asked for; its method does not count.
        longest: The longest step that instants allow, s.
        stop: The end of the run, s.
    """
    stiff = replace(wanted, method=Method.RODAS)
    loose = replace(wanted, method=Method.DOPRI5)
    states = len(compiled.system.states)
    if not states:
        return loose, f"method auto chose {loose.method}: nothing is stored in the model, so no step can be unstable"
    try:
        machine = compiled.machine(Method.RODAS)
    except SimulationError as error:
        return loose, f"method auto chose {loose.method}: {error.diagnostics[0].message}"
    trial = memory.copy()
    begin = trial.time
    limits = _limits(compiled, machine, trial, stiff, longest, stop)
    span, taken = trial.time - begin, trial.steps_taken - memory.steps_taken
    if not taken or not span > 0.0:
        return stiff, f"method auto chose {stiff}: the trial did not get beyond its first step"
    mean = span / taken
    tried = f"in the first {span:.3g} s the error allows steps of {mean:.2g} s on average"
    if not limits:
        return stiff, f"method auto chose {stiff}: {tried}; {states} states are too many to look at their eigenvalues"
    tightest = min(limits, key=lambda limit: limit.step)
    if math.isinf(tightest.step):
        return loose, f"method auto chose {loose}: {tried}, and no mode limits an explicit method"
    mode = (
        f"{tightest.state} has the eigenvalue {tightest.rate.real:.4g}"
        f"{f' +- {abs(tightest.rate.imag):.4g}i' if tightest.rate.imag else ''} 1/s"
    )
    stability = f"stability an explicit method {tightest.step:.2g} s ({mode})"
    if mean > COST_OF_IMPLICIT * tightest.step:
        return stiff, f"method auto chose {stiff}: {tried}, {stability}: the model is stiff"
    return loose, f"method auto chose {loose}: {tried}, {stability}: the model is not stiff"


def _limits(
    compiled: CompiledModel, machine: Machine, trial: Memory, stepping: Stepping, longest: float, stop: float
) -> list[StepLimit]:
    """Go along the run; the limits of an explicit method on the way, none for a model with too many states."""
    is_small = len(compiled.system.states) <= MOST_STATES
    begin, before = trial.time, trial.steps_taken
    until = begin + SHARE * (stop - begin)
    found: list[StepLimit] = []
    for look in range(LOOKS):
        if is_small:
            with suppress(SimulationError):  # where derivatives do not exist
                found.append(step_limit(compiled, trial, Method.DOPRI5, window=stop - begin))
        end = begin + (look + 1) / LOOKS * (until - begin)
        request = Request(until=end, step=longest, tolerance=stepping.tolerance, most_ticks=MOST_TRIAL_STEPS)
        outcome = machine.run(trial, request)
        if outcome.status is not Status.FINISHED or trial.steps_taken - before > MOST_TRIAL_STEPS:
            break
    return found
