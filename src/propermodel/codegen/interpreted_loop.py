"""The loop over ticks of the interpreted machine, with steps of one length or such as control their length."""

from __future__ import annotations

import itertools
import math
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from propermodel.codegen.fastest import LONGEST, LOOK_EVERY, is_too_fast, look, prepare_watch
from propermodel.codegen.interpreted_code import AllFailed
from propermodel.codegen.machine import (
    SAME_INSTANT,
    STEPS_BETWEEN_CHECKS,
    STEPS_BETWEEN_PAUSES,
    Failure,
    FloatArray,
    Memory,
    Outcome,
    Request,
    Status,
    count_from,
    instant,
    open_extremes,
    sample_periods,
    state_failures,
)
from propermodel.codegen.program import Array
from propermodel.codegen.step_control import (
    LEAST_ERROR_BEFORE,
    MOST_FACTOR,
    factor_accepted,
    factor_rejected,
    longest_in,
    smallest_step,
)

if TYPE_CHECKING:
    from propermodel.codegen.interpreted import InterpretedMachine


class Loop:
    """One call of `run`."""

    def __init__(self, machine: InterpretedMachine, memory: Memory, request: Request) -> None:
        self._machine = machine
        self._memory = memory
        self._request = request
        self._periods = sample_periods(machine.program, memory)
        self._run = machine.begun(memory)
        self._row_times: list[float] = []
        self._rows: list[FloatArray] = []
        self._integral_times: list[float] = []
        self._integrals: list[FloatArray] = []
        self._activities: list[FloatArray] = []
        self._least: list[FloatArray] = []
        self._greatest: list[FloatArray] = []
        self._near = request.step * SAME_INSTANT
        self._event_step = 0.0
        open_extremes(memory, request)
        self._is_watching = request.is_watched and machine.lanes == 1 and machine.method in LONGEST
        if self._is_watching:
            prepare_watch(memory)
        memory.rows_taken = count_from(memory, request, memory.rows_taken, request.row_period)
        memory.integral_rows_taken = count_from(memory, request, memory.integral_rows_taken, request.integral_period)
        if machine.lanes == 1:
            memory.alive[:] = True

    def run(self) -> Outcome:
        memory, request = self._memory, self._request
        ticks = request.most_ticks
        try:
            while True:
                if not self._has_room():
                    return self._outcome(Status.PAUSED)
                self._do_instant()
                if memory.time + self._near >= request.until:
                    return self._outcome(Status.FINISHED)
                if ticks == 0:
                    return self._outcome(Status.PAUSED)
                ticks -= 1
                status = self.do_steps()
                if status is not None:
                    return self._outcome(status)
                self._check()
        except AllFailed:
            return self._outcome(None)

    def _row_due(self) -> float:
        return instant(self._memory.origin, self._memory.rows_taken, self._request.row_period)

    def _integral_due(self) -> float:
        return instant(self._memory.origin, self._memory.integral_rows_taken, self._request.integral_period)

    def _sample_due(self, k: int) -> float:
        return instant(self._memory.origin, int(self._memory.samples_taken[k]), self._periods[k])

    def _is_due(self, at: float) -> bool:
        return at <= self._memory.time + self._near

    def _has_room(self) -> bool:
        most = self._request.most_rows
        return not (
            (self._is_due(self._row_due()) and len(self._rows) >= most)
            or (self._is_due(self._integral_due()) and len(self._integrals) >= most)
        )

    def _do_instant(self) -> None:
        memory = self._memory
        for k in range(len(self._periods)):
            if self._is_due(self._sample_due(k)):
                self._machine.sample_one(self._run, k, memory.time)
                memory.samples_taken[k] += 1
        if self._is_due(self._row_due()):
            signals = self._machine.signals(self._run, memory.time)[self._request.selected].copy()
            self._row_times.append(memory.time)
            self._rows.append(signals)
            memory.rows_taken += 1
            if self._request.has_extremes:
                self._keep_extremes(signals)
        elif self._periods:
            self.watch(memory.time)
        if self._is_due(self._integral_due()):
            self._integral_times.append(memory.time)
            self._integrals.append(memory.integral.copy())
            self._activities.append(memory.activity.copy())
            memory.integral_rows_taken += 1

    def watch(self, time: float) -> None:
        """Look at the signals at a time, where extremes are asked for."""
        if self._request.has_extremes:
            self._merge(self._machine.signals(self._run, time)[self._request.selected])

    def _merge(self, signals: FloatArray) -> None:
        memory = self._memory
        np.copyto(memory.least, signals, where=signals < memory.least)
        np.copyto(memory.greatest, signals, where=signals > memory.greatest)

    def _keep_extremes(self, signals: FloatArray) -> None:
        memory = self._memory
        self._merge(signals)
        self._least.append(memory.least.copy())
        self._greatest.append(memory.greatest.copy())
        memory.least[...], memory.greatest[...] = math.inf, -math.inf
        self._merge(signals)

    def _next_instant(self) -> float:
        dues = [self._request.until, self._row_due(), self._integral_due()]
        return min(*dues, *(self._sample_due(k) for k in range(len(self._periods))))

    def do_steps(self) -> Status | None:
        """Steps to the next instant; a status where they end before."""
        memory, request = self._memory, self._request
        start = memory.time
        end = self._next_instant()
        count = max(1, math.ceil((end - start) / request.step - SAME_INSTANT))
        h = (end - start) / count
        for i in range(count):
            memory.time = start + i * h
            before = None if self._machine.program.guards is None else memory.copy()
            pending = self._run.pending
            self._machine.step(self._run, memory.time, h, is_fresh=i % request.jacobian_every == 0)
            if before is not None and self._machine.meets_event(self._run, memory.time + h):
                for kept, values in (
                    (before.state, memory.state),
                    (before.unknown, memory.unknown),
                    (before.integral, memory.integral),
                    (before.activity, memory.activity),
                ):
                    values[...] = kept
                self._run.pending = pending
                self._machine.close(self._run, memory.time)
                self._event_step = h
                return Status.EVENT
            memory.steps_taken += 1
            self.watch(end if i + 1 == count else start + (i + 1) * h)
            if (i + 1) % STEPS_BETWEEN_CHECKS == 0 and len(state_failures(memory)) == memory.alive.sum():
                memory.time = start + (i + 1) * h
                self._check()
            if (i + 1) % STEPS_BETWEEN_CHECKS == 0:
                self._look(start + (i + 1) * h, h)
        memory.time = end
        self._machine.close(self._run, end)
        self._check()
        if self._look(end, h) and is_too_fast(memory, self._machine.method, h):
            return Status.PAUSED
        return None

    def _look(self, time: float, h: float) -> bool:
        """Look at the fastest mode in the middle of the last step where that is due; nothing else is changed."""
        memory = self._memory
        if not self._is_watching or memory.steps_taken < memory.next_look:
            return False
        memory.next_look = memory.steps_taken + LOOK_EVERY
        state, unknown, failures = memory.state.copy(), memory.unknown.copy(), len(self._run.failures)
        memory.state -= self._run.arrays[Array.RATE] * (h * 0.5)
        with suppress(AllFailed):
            look(memory, lambda: self._machine.rates_at(self._run, time))
        memory.state[:], memory.unknown[:], memory.alive[:] = state, unknown, True
        del self._run.failures[failures:]
        return True

    def _check(self) -> None:
        for failure in state_failures(self._memory):
            self._run.failures.append(failure)
            self._memory.alive[failure.lane] = False
        if not self._memory.alive.any():
            raise AllFailed

    def _outcome(self, status: Status | None) -> Outcome:
        failures = self._run.failures
        shape = self._memory.integral.shape

        def stacked(rows: list[FloatArray], shape: tuple[int, ...]) -> FloatArray:
            return np.array(rows).reshape(len(rows), *shape)

        selected = (self._request.selected.size, *shape[1:])
        return Outcome(
            status=status or failures[0].status,
            time=self._memory.time,
            index=-1 if status else failures[0].index,
            row_times=np.array(self._row_times),
            rows=stacked(self._rows, selected),
            integral_times=np.array(self._integral_times),
            integrals=stacked(self._integrals, shape),
            activities=stacked(self._activities, shape),
            least=stacked(self._least, selected),
            greatest=stacked(self._greatest, selected),
            failures=tuple(failures),
            step=self._event_step if status is Status.EVENT else 0.0,
        )


class AdaptiveLoop(Loop):
    """One call of `run` with steps that control their length."""

    def __init__(self, machine: InterpretedMachine, memory: Memory, request: Request) -> None:
        super().__init__(machine, memory, request)
        self._attempt = machine.attempt(self._run, request)

    def do_steps(self) -> Status | None:
        """Steps to the next instant; a status where they end before."""
        machine, memory, run, attempt = self._machine, self._memory, self._run, self._attempt
        largest, end = self._request.step, self._next_instant()
        is_fresh, most_growth = True, MOST_FACTOR
        for count in itertools.count(1):
            time, wanted = memory.time, memory.next_step
            h, is_last = longest_in(end - time, wanted)
            failures = len(run.failures)
            error = machine.take(attempt, time, h, is_fresh=is_fresh)
            if not error <= 1.0:
                memory.steps_rejected += 1
                attempt.restore()
                if math.isnan(error):
                    self._give_up()
                memory.next_step = h * factor_rejected(error)
                if memory.next_step < smallest_step(time, largest):
                    self._give_up()
                attempt.revive(failures)
                most_growth = 1.0
                continue
            machine.correct(run, time + h)
            if machine.meets_event(run, time + h):
                attempt.restore()
                self._event_step = h
                return Status.EVENT
            machine.commit(attempt, time, h)
            memory.steps_taken += 1
            self._plan(error, h, wanted, most_growth)
            memory.time = end if is_last else time + h
            self.watch(memory.time)
            if is_last:
                machine.finish(attempt, end)
                return None
            if count >= STEPS_BETWEEN_PAUSES:
                machine.finish(attempt, memory.time)
                self._check()
                return Status.PAUSED
            is_fresh, most_growth = machine.has_corrections, MOST_FACTOR
        raise AssertionError("steps have no end")

    def _plan(self, error: float, h: float, wanted: float, most_growth: float) -> None:
        """Choose the next step after one that was accepted."""
        memory = self._memory
        chosen = h * factor_accepted(error, memory.last_error, most_growth)
        is_cut = h < wanted
        memory.next_step = min(max(chosen, wanted) if is_cut else chosen, self._request.step)
        if not is_cut:
            memory.last_error = max(error, LEAST_ERROR_BEFORE)

    def _give_up(self) -> None:
        memory = self._memory
        if memory.alive.all():
            worst = int(np.argmax(self._attempt.errors))
            self._run.failures.append(Failure(0, Status.STEP_TOO_SMALL, memory.time, worst))
            memory.alive[:] = False
        raise AllFailed
