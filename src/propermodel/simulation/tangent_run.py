"""A run that carries the derivatives of everything with respect to parameters along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.codegen.machine import (
    Failure,
    FloatArray,
    Machine,
    Memory,
    Outcome,
    Request,
    Status,
    start_memory,
)
from propermodel.codegen.program import Array
from propermodel.codegen.schedule import number_solves
from propermodel.codegen.tangents import TangentProgram
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.simulation.endings import failed_ending, overflow_ending
from propermodel.simulation.events import Events
from propermodel.simulation.overflow import Overflow
from propermodel.simulation.start_tangents import StartTangents
from propermodel.simulation.tangent_events import TangentEvents
from propermodel.simulation.trajectory import Ending, RunStatus


@dataclass(frozen=True, eq=False)
class Along:
    """Quantities along a run: their values, and in the last axis their derivatives along each direction."""

    values: FloatArray  # rows x quantities; or quantities
    slopes: FloatArray  # rows x quantities x directions; or quantities x directions

    def of(self, places: Sequence[int]) -> Along:
        """Some of the quantities."""
        chosen = list(places)
        return Along(self.values[..., chosen], self.slopes[..., chosen, :])

    def times(self, other: Along) -> Along:
        """The products with other quantities, as many."""
        slopes = self.slopes * other.values[..., np.newaxis] + self.values[..., np.newaxis] * other.slopes
        return Along(self.values * other.values, slopes)


@dataclass(frozen=True, eq=False, kw_only=True)
class TangentRun:
    """What a run with tangents gave: rows of the chosen signals, and of the integrals of kept powers.

    Numbers at the end are no numbers where the run did not reach it.
    """

    time: FloatArray
    signals: Along
    work: Along
    activity: Along
    final_signals: Along
    final_work: Along
    final_activity: Along
    ending: Ending
    steps: int


def tangent_memory(tangents: TangentProgram, begun: Memory, rates: StartTangents) -> Memory:
    """The memory at the start of a run with tangents."""
    moving = [rates.parameters[seed.direction].get(seed.parameter, 0.0) for seed in tangents.seeds]
    memory = start_memory(
        tangents.program,
        {
            Array.STATE: np.concatenate([begun.state, rates.state.ravel()]),
            Array.DISCRETE: np.concatenate([begun.discrete, rates.discrete.ravel()]),
            Array.PARAMETER: np.concatenate([begun.parameter, moving]),
            Array.UNKNOWN: begun.unknown,
        },
        tables=begun.tables,
        origin=begun.time,
    )
    memory.lower[: tangents.states] = begun.lower
    memory.upper[: tangents.states] = begun.upper
    return memory


def run_tangents(
    compiled: CompiledModel,
    tangents: TangentProgram,
    machine: Machine,
    memory: Memory,
    request: Request,
    powers: Sequence[int],
    signals: Sequence[int],
    kept: Sequence[int] = (),
) -> TangentRun:
    """Run to the end, or to where a number ceases to be finite.

    Args:
        compiled: The model.
        tangents: Its program with tangents.
        machine: What executes that.
        memory: The start; it moves to the end.
        request: The window, step and rows; signals are chosen already.
        powers: The entries of POWER that the program has.
        signals: The entries of SIGNAL that the program has.
        kept: Which of these have rows, too.
    """
    request = replace(
        request,
        selected=np.arange(machine.program.layout.lengths[Array.SIGNAL], dtype=np.int64),
        integral_period=request.row_period if kept else np.inf,
    )
    times: list[FloatArray] = [np.zeros(0)]
    rows: list[FloatArray] = [np.zeros((0, request.selected.size))]
    work: list[Along] = []
    activity: list[Along] = []
    events = _events(compiled, tangents, machine, request.step, signals) if compiled.system.events else None
    ending = None if events is None else events.begin(memory)
    while ending is None:
        before = memory.copy()
        outcome = machine.run(memory, request)
        times.append(outcome.row_times)
        rows.append(outcome.rows)
        if kept:
            work.append(_work(tangents, outcome.integrals).of(kept))
            activity.append(_activity(tangents, outcome.integrals, outcome.activities).of(kept))
        if outcome.status is Status.EVENT and events is not None:
            ending = events.happen(memory, outcome.step)
        elif outcome.status is not Status.PAUSED:
            ending = _ending(compiled, tangents, outcome, memory, before, powers)
    unknown = 0.0 if ending.is_complete else np.nan
    last = machine.observe(memory) if ending.is_complete else np.full(request.selected.size, np.nan)
    return TangentRun(
        time=np.concatenate(times),
        signals=_signals(tangents, np.concatenate(rows)),
        work=_joined(work),
        activity=_joined(activity),
        final_signals=_signals(tangents, last),
        final_work=_work(tangents, memory.integral + unknown),
        final_activity=_activity(tangents, memory.integral + unknown, memory.activity + unknown),
        ending=ending,
        steps=memory.steps_taken,
    )


def _events(
    compiled: CompiledModel, tangents: TangentProgram, machine: Machine, step: float, signals: Sequence[int]
) -> Events:
    """The events of a run, as they happen to a program that has some of the signals only."""
    lowered = compiled.lowered
    place = {entry: number for number, entry in enumerate(signals)}
    observables = {
        path: replace(observable, index=place[observable.index])
        for path, observable in lowered.observables.items()
        if observable.index in place
    }
    seen = replace(compiled, lowered=replace(lowered, program=tangents.program, observables=observables))

    def keep_nothing(time: float, signals: FloatArray) -> None:
        """Rows stand at the recording instants only."""

    elements = [event.element for event in compiled.system.events]
    return Events(seen, machine, step, keep_nothing, follower=TangentEvents(tangents, elements, machine))


def _joined(parts: Sequence[Along]) -> Along:
    if not parts:
        return Along(np.zeros((0, 0)), np.zeros((0, 0, 0)))
    return Along(np.concatenate([part.values for part in parts]), np.concatenate([part.slopes for part in parts]))


def _signals(tangents: TangentProgram, rows: FloatArray) -> Along:
    directions = range(len(tangents.directions))
    return Along(rows[..., : tangents.signals], np.stack([rows[..., tangents.signal(k)] for k in directions], axis=-1))


def _work(tangents: TangentProgram, integrals: FloatArray) -> Along:
    directions = range(len(tangents.directions))
    return Along(
        integrals[..., : tangents.powers], np.stack([integrals[..., tangents.power(k)] for k in directions], axis=-1)
    )


def _activity(tangents: TangentProgram, integrals: FloatArray, activities: FloatArray) -> Along:
    directions = range(len(tangents.directions))
    return Along(
        activities[..., : tangents.powers],
        np.stack([integrals[..., tangents.absolute_power(k)] for k in directions], axis=-1),
    )


def _ending(
    compiled: CompiledModel,
    tangents: TangentProgram,
    outcome: Outcome,
    memory: Memory,
    before: Memory,
    powers: Sequence[int],
) -> Ending:
    at = memory.time
    if outcome.status is Status.FINISHED:
        bad = ~(np.isfinite(memory.integral) & np.isfinite(memory.activity))
        if not bad.any():
            return Ending(RunStatus.COMPLETED, f"completed to {at:.6g} s", at)
        own = np.flatnonzero(bad[: tangents.powers])
        if own.size:
            return overflow_ending(compiled, Overflow(at, tuple(powers[int(i)] for i in own)), memory)
        entry = int(np.flatnonzero(bad)[0]) - tangents.powers
        direction, place = divmod(entry, 2 * tangents.powers)
        what = compiled.lowered.powers[powers[place % tangents.powers]].path
        return _not_finite(at, f"energy exchanged at {what}", what, tangents, direction)
    if outcome.status is Status.NOT_CONVERGED:
        # The blocks of the program with tangents are some of those of the model, in another order.
        solve = list(number_solves(tangents.program))[outcome.index]
        number = number_solves(compiled.lowered.program)[solve]
        return failed_ending(compiled, Failure(0, outcome.status, outcome.time, number), memory, before)
    if outcome.index >= tangents.states:
        direction, place = divmod(outcome.index - tangents.states, tangents.states)
        what = compiled.system.states[place].path
        return _not_finite(at, f"state {what}", what, tangents, direction)
    return failed_ending(compiled, Failure(0, outcome.status, outcome.time, outcome.index), memory, before)


def _not_finite(at: float, what: str, path: Path, tangents: TangentProgram, direction: int) -> Ending:
    return Ending(
        RunStatus.FAILED,
        f"stopped at {at:.6g} s: the derivative of the {what} with respect to {tangents.directions[direction].name} "
        "is no longer a finite number: a law has a vertical tangent there, or deviations grow without bound",
        at,
        path,
    )
