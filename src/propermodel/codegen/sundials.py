"""The machine that takes its steps with CVODE of SUNDIALS (extra `sundials`): an independent reference.

Samples, rows and events are those of the interpreted machine; right-hand sides are evaluated by another, faster one.
Integrals of POWER and of its absolute value are states beside those of the model, under the same control of the error.
Implicit blocks and constraints are solved within the right-hand side, as by every method, so there is no need of IDA.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from propermodel.codegen.interpreted import InterpretedMachine
from propermodel.codegen.interpreted_code import AllFailed
from propermodel.codegen.interpreted_loop import Loop
from propermodel.codegen.machine import (
    STEPS_BETWEEN_PAUSES,
    Failure,
    FloatArray,
    Machine,
    Memory,
    Method,
    Outcome,
    Request,
    Status,
    check_memory,
    check_request,
    not_solved,
)
from propermodel.codegen.program import Program
from propermodel.codegen.step_control import TINY, least_sizes, smallest_step
from propermodel.diagnostics import ProperModelError, SimulationError

MOST_STEPS = 10_000_000  # CVODE's own limit on the way to one instant
MOST_SMALL_STEPS = 100  # in a row; the first ones of a run are small, as their order is 1
SAME_TIME_ULPS = 4.0  # CVODE refuses to go on by less than some units in the last place of the time
DIFFERENCE = 1.5e-8  # of a state, as a share of its size, for the columns of the Jacobian


def cvode() -> Any:
    """The class of scikit-sundae.

    Raises:
        SimulationError: it is not installed.
    """
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        raise SimulationError.of(
            "simulation/sundials",
            "the method cvode needs SUNDIALS, which is not installed",
            help="install it: pip install 'propermodel[sundials]'; or take the method rodas",
        ) from None
    return CVODE


class SundialsMachine(InterpretedMachine):
    """Runs a program with CVODE (variable order, backward differentiation)."""

    def __init__(self, program: Program, evaluator: Machine) -> None:
        self._solver = cvode()
        super().__init__(program, Method.CVODE)
        self._evaluator = evaluator

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        check_memory(self.program, 1, memory)
        check_request(self.program, memory, request)
        with np.errstate(all="ignore"):
            return _CvodeLoop(self, memory, request).run()

    def advance(self, memory: Memory, step: float) -> None:
        """Go on by this length whatever the guards say."""
        check_memory(self.program, 1, memory)
        memory.alive[:] = True
        run = self.begun(memory)
        with np.errstate(all="ignore"):
            solution = self.solution(memory, Request(until=memory.time + step, step=step, tolerance=1e-8))
            end = memory.time + step
            while memory.time < end:
                solution.step(end)
            try:
                self.correct(run, end)
            except AllFailed:
                raise not_solved(self.program, run.failures[0]) from None

    def solution(self, memory: Memory, request: Request) -> Solution:
        """What CVODE computes from here on."""
        return Solution(self._solver, self._evaluator, memory, request)


class Solution:
    """CVODE at work on the states and the two integrals of every power, between two instants."""

    def __init__(self, solver: Any, evaluator: Machine, memory: Memory, request: Request) -> None:
        self._evaluator = evaluator
        self._memory = memory
        self._trial = memory.copy()
        self._states = memory.state.size
        self._longest = request.step
        self._small_steps = 0  # in a row
        sizes = np.maximum(np.maximum(memory.size, np.abs(memory.state)), least_sizes(memory, request))
        powers = np.maximum(np.maximum(np.abs(memory.integral), memory.activity), 1e-6 * (1.0 + memory.activity.sum()))
        self._sizes = sizes
        self._cvode = solver(
            self._rates,
            rtol=request.tolerance,
            atol=request.tolerance * np.concatenate((sizes, powers, powers)),
            max_step=request.step,
            max_num_steps=MOST_STEPS,
            jacfn=self._jacobian,
        )
        self._values = np.concatenate((memory.state, memory.integral, memory.activity))
        self._cvode.init_step(memory.time, self._values)

    def step(self, until: float) -> None:
        """Take one step into the memory, not beyond a time.

        Raises:
            SimulationError: CVODE does not get any further, or an implicit block has no solution.
        """
        if until - self._memory.time <= SAME_TIME_ULPS * math.ulp(until):
            self._go_straight(until)
            return
        found = self._cvode.step(until, method="onestep", tstop=until)
        is_small = found.t < until and found.t - self._memory.time < smallest_step(found.t, self._longest)
        self._small_steps = self._small_steps + 1 if is_small else 0
        if not found.success or self._small_steps > MOST_SMALL_STEPS or not np.isfinite(found.y).all():
            self._evaluator.rates(self._memory)  # tells what has no solution
            raise SimulationError.of(
                "simulation/sundials",
                f"CVODE does not get beyond {self._memory.time:.6g} s: {found.message}",
                help="is there a jump that should be an event, or a solution that has no end?",
            )
        self._move(float(found.t), found.y)

    def _go_straight(self, until: float) -> None:
        """Go to a time that CVODE takes for the present one, as when the instant of an event is bracketed."""
        memory = self._memory
        rates = self._evaluated(memory.time, memory.state)
        values = np.concatenate((memory.state, memory.integral, memory.activity))
        self._move(until, values + (until - memory.time) * rates)

    def _move(self, time: float, values: FloatArray) -> None:
        memory = self._memory
        memory.time = time
        parts = np.split(values, (self._states, self._states + memory.integral.size))
        memory.state[...], memory.integral[...], memory.activity[...] = parts
        np.maximum(memory.size, np.abs(memory.state), out=memory.size)

    def _evaluated(self, time: float, state: FloatArray) -> FloatArray:
        trial = self._trial
        trial.time = time
        trial.state[:] = state
        try:
            rates, powers = self._evaluator.rates(trial)
        except ProperModelError:
            # CVODE tries a shorter step where numbers are none.
            return np.full(self._values.size, np.nan)
        return np.concatenate((rates, powers, np.abs(powers)))

    def _rates(self, time: float, values: FloatArray, rates: FloatArray) -> None:
        rates[:] = self._evaluated(time, values[: self._states])

    def _jacobian(self, time: float, values: FloatArray, rates: FloatArray, matrix: FloatArray) -> None:
        """Forward differences by the states; on integrals nothing depends."""
        state = values[: self._states].copy()
        matrix[:, :] = 0.0
        for column in range(self._states):
            kept = state[column]
            state[column] = kept + DIFFERENCE * max(abs(kept), float(self._sizes[column]))
            change = state[column] - kept
            matrix[:, column] = (self._evaluated(time, state) - rates) / change
            state[column] = kept


class _CvodeLoop(Loop):
    """One call of `run`."""

    def __init__(self, machine: SundialsMachine, memory: Memory, request: Request) -> None:
        super().__init__(machine, memory, request)
        self._sundials = machine

    def do_steps(self) -> Status | None:
        """Steps to the next instant; a status where they end before."""
        machine, memory = self._machine, self._memory
        end = self._next_instant()
        solution = self._sundials.solution(memory, self._request)
        taken = 0
        while memory.time < end:
            before = memory.copy()
            try:
                solution.step(end)
            except SimulationError:
                self._fail()
            if machine.meets_event(self._run, memory.time):
                self._event_step = memory.time - before.time
                for name in ("state", "unknown", "integral", "activity"):
                    getattr(memory, name)[...] = getattr(before, name)
                memory.time = before.time
                return Status.EVENT
            memory.steps_taken += 1
            taken += 1
            self.watch(memory.time)
            if taken >= STEPS_BETWEEN_PAUSES and memory.time < end:
                return Status.PAUSED
        memory.time = end
        machine.correct(self._run, end)
        return None

    def _fail(self) -> None:
        """End the run, with the state that changes fastest for its size."""
        memory = self._memory
        rates = self._machine.rates_at(self._run, memory.time)
        speeds = np.abs(rates) / np.maximum(memory.size, TINY)
        index = int(np.argmax(np.nan_to_num(speeds, nan=np.inf)))
        self._run.failures.append(Failure(0, Status.STEP_TOO_SMALL, memory.time, index))
        memory.alive[:] = False
        raise AllFailed
