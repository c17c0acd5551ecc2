"""A run that carries the derivatives of everything with respect to parameters along.

Every parameter has a lane of its own, where the model has no events: the run is the same in all lanes, and costs little
more than in one. With events, the parameters are directions of one lane.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from propermodel.codegen.build import best_lanes
from propermodel.codegen.machine import BoolArray, FloatArray, Machine, Memory, Request, Status, start_memory
from propermodel.codegen.program import Array
from propermodel.codegen.tangents import TangentProgram
from propermodel.compiler import Backend, CompiledModel, CompiledTangents
from propermodel.diagnostics import Path
from propermodel.simulation.events import Events
from propermodel.simulation.side_by_side import joined, lane_of
from propermodel.simulation.start_tangents import StartTangents
from propermodel.simulation.tangent_endings import ending_at_stop, ending_of_failure
from propermodel.simulation.tangent_events import TangentEvents
from propermodel.simulation.trajectory import Ending


@dataclass(frozen=True, eq=False)
class Along:
    """Quantities along a run: their values, and in the last axis their derivatives along each direction."""

    values: FloatArray  # rows x quantities; or quantities
    slopes: FloatArray  # rows x quantities x directions; or quantities x directions

    def of(self, places: Sequence[int]) -> Along:
        """Some of the quantities."""
        chosen = list(places)
        return Along(self.values[..., chosen], self.slopes[..., chosen, :])

    def plus(self, number: float) -> Along:
        """Values and derivatives plus a number: zero, or no number where nothing is known."""
        return Along(self.values + number, self.slopes + number)

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


def lanes_for(count: int, backend: Backend) -> int:
    """How many lanes serve so many parameters: the smallest power of two that holds them, or a whole vector."""
    return min(best_lanes(backend), 1 << (count - 1).bit_length())


def tangent_memory(tangents: TangentProgram, begun: Memory, rates: StartTangents, numbers: Sequence[int]) -> Memory:
    """The memory at the start of a run with tangents, whose directions are these of the parameters."""
    moving = [rates.parameters[numbers[seed.direction]].get(seed.parameter, 0.0) for seed in tangents.seeds]
    memory = start_memory(
        tangents.program,
        {
            Array.STATE: np.concatenate([begun.state, rates.state[numbers].ravel()]),
            Array.DISCRETE: np.concatenate([begun.discrete, rates.discrete[numbers].ravel()]),
            Array.PARAMETER: np.concatenate([begun.parameter, moving]),
            Array.UNKNOWN: begun.unknown,
        },
        tables=begun.tables,
        origin=begun.time,
    )
    memory.lower[: tangents.states] = begun.lower
    memory.upper[: tangents.states] = begun.upper
    return memory


@dataclass(frozen=True, eq=False, kw_only=True)
class TangentJob:
    """What the runs of all parameters have in common.

    `signals` and `powers` are the entries of SIGNAL and POWER that the program has; of the `kept` places among these
    powers integrals have rows.
    """

    compiled: CompiledModel
    prepared: CompiledTangents
    names: tuple[Path, ...]  # of the parameters
    request: Request
    signals: tuple[int, ...]
    powers: tuple[int, ...]
    kept: tuple[int, ...]

    @property
    def _tangents(self) -> TangentProgram:
        return self.prepared.tangents

    @property
    def lanes(self) -> int:
        """How many lanes the machine has."""
        if self.compiled.system.events:
            return 1
        return lanes_for(len(self.names), self.prepared.backend)

    def run(self, begun: Memory, rates: StartTangents) -> TangentRun:
        """Run to the end, or to where a number ceases to be finite; the machine should have been made before.

        Args:
            begun: The start.
            rates: How it changes with the parameters.
        """
        width = len(self._tangents.directions)
        numbers = range(len(self.names))
        memories = [tangent_memory(self._tangents, begun, rates, numbers[i : i + width]) for i in numbers[::width]]
        lanes = self.lanes
        groups = [(i, memories[i : i + lanes]) for i in range(0, len(memories), lanes)]

        def run_group(group: tuple[int, list[Memory]]) -> TangentRun:
            first, members = group
            return self._group(members, lanes, self.names[first * width : (first + len(members)) * width])

        if len(groups) == 1:
            return run_group(groups[0])
        with ThreadPoolExecutor() as pool:
            return _side_by_side(list(pool.map(run_group, groups)))

    def _group(self, members: Sequence[Memory], lanes: int, names: Sequence[Path]) -> TangentRun:
        """The run of as many parameters as a machine takes."""
        machine, memory, count = self.prepared.machine(lanes), joined(members, lanes), len(members)
        request = replace(
            self.request,
            selected=np.arange(machine.program.layout.lengths[Array.SIGNAL], dtype=np.int64),
            integral_period=self.request.row_period if self.kept else np.inf,
        )

        def each(values: FloatArray) -> FloatArray:
            """With an axis of the members, last."""
            return values[..., np.newaxis] if lanes == 1 else values[..., :count]

        times: list[FloatArray] = [np.zeros(0)]
        rows: list[FloatArray] = [np.zeros((0, request.selected.size, count))]
        work: list[Along] = []
        activity: list[Along] = []
        events = self._events(machine) if self.compiled.system.events else None
        ending = None if events is None else events.begin(memory)
        while ending is None:
            before = memory.copy()
            outcome = machine.run(memory, request)
            times.append(outcome.row_times)
            rows.append(each(outcome.rows))
            if self.kept:
                integrals, activities = each(outcome.integrals), each(outcome.activities)
                work.append(self._work(integrals).of(self.kept))
                activity.append(self._activity(integrals, activities).of(self.kept))
            failure = next((failure for failure in outcome.failures if failure.lane < count), None)
            if failure is not None:
                here, there = lane_of(memory, failure.lane), lane_of(before, failure.lane)
                own = self._names_of(names, failure.lane)
                ending = ending_of_failure(self.compiled, self._tangents, replace(failure, lane=0), here, there, own)
            elif outcome.status is Status.EVENT and events is not None:
                ending = events.happen(memory, outcome.step)
            elif outcome.status is Status.FINISHED:
                ending = self._stopped(memory, count, names)
        unknown = 0.0 if ending.is_complete else np.nan
        last = each(machine.observe(memory)) if ending.is_complete else np.full(rows[0].shape[1:], np.nan)
        time = np.concatenate(times)
        is_reached = time <= ending.time + 1e-9 * request.step
        integral, size = each(memory.integral) + unknown, each(memory.activity) + unknown
        return TangentRun(
            time=time[is_reached],
            signals=self._signals(np.concatenate(rows)[is_reached]),
            work=_joined(work, is_reached),
            activity=_joined(activity, is_reached),
            final_signals=self._signals(last),
            final_work=self._work(integral),
            final_activity=self._activity(integral, size),
            ending=ending,
            steps=memory.steps_taken,
        )

    def _stopped(self, memory: Memory, count: int, names: Sequence[Path]) -> Ending:
        endings = [
            ending_at_stop(
                self.compiled, self._tangents, lane_of(memory, lane), self.powers, self._names_of(names, lane)
            )
            for lane in range(count)
        ]
        return next((ending for ending in endings if not ending.is_complete), endings[0])

    def _names_of(self, names: Sequence[Path], member: int) -> Sequence[Path]:
        width = len(self._tangents.directions)
        return names[member * width : (member + 1) * width]

    def _events(self, machine: Machine) -> Events:
        """The events of a run, as they happen to a program that has some of the signals only."""
        lowered = self.compiled.lowered
        place = {entry: number for number, entry in enumerate(self.signals)}
        observables = {
            path: replace(observable, index=place[observable.index])
            for path, observable in lowered.observables.items()
            if observable.index in place
        }
        program = self._tangents.program
        seen = replace(self.compiled, lowered=replace(lowered, program=program, observables=observables))

        def keep_nothing(time: float, signals: FloatArray) -> None:
            """Rows stand at the recording instants only."""

        elements = [event.element for event in self.compiled.system.events]
        follower = TangentEvents(self._tangents, elements, self.names, machine)
        return Events(seen, machine, self.request.step, keep_nothing, follower=follower)

    def _signals(self, rows: FloatArray) -> Along:
        return self._along(rows[..., : self._tangents.signals, 0], rows, self._tangents.signal)

    def _work(self, integrals: FloatArray) -> Along:
        return self._along(integrals[..., : self._tangents.powers, 0], integrals, self._tangents.power)

    def _activity(self, integrals: FloatArray, activities: FloatArray) -> Along:
        own = activities[..., : self._tangents.powers, 0]
        return self._along(own, integrals, self._tangents.absolute_power)

    def _along(self, own: FloatArray, numbers: FloatArray, place: Callable[[int], slice]) -> Along:
        """Values with their tangents, which stand among numbers that have an axis of the members, last."""
        directions = range(len(self._tangents.directions))
        slopes = [numbers[..., place(k), member] for member in range(numbers.shape[-1]) for k in directions]
        return Along(own, np.stack(slopes, axis=-1))


def _joined(parts: Sequence[Along], is_reached: BoolArray) -> Along:
    """What several calls gave, one after the other."""
    if not parts:
        return Along(np.zeros((0, 0)), np.zeros((0, 0, 0)))
    values, slopes = np.concatenate([p.values for p in parts]), np.concatenate([p.slopes for p in parts])
    return Along(values[is_reached], slopes[is_reached])


def _side_by_side(runs: Sequence[TangentRun]) -> TangentRun:
    """The runs of several groups as one, to where the first of them ended."""
    first = min(runs, key=lambda run: (run.ending.is_complete, run.ending.time))
    count = len(first.time)

    def all_of(quantities: Sequence[Along], rows: slice) -> Along:
        slopes = np.concatenate([quantity.slopes[rows] for quantity in quantities], axis=-1)
        return Along(quantities[0].values[rows], slopes)

    reached, every = slice(count), slice(None)
    unknown = 0.0 if first.ending.is_complete else np.nan
    return TangentRun(
        time=first.time,
        signals=all_of([run.signals for run in runs], reached),
        work=all_of([run.work for run in runs], reached),
        activity=all_of([run.activity for run in runs], reached),
        final_signals=all_of([run.final_signals for run in runs], every).plus(unknown),
        final_work=all_of([run.final_work for run in runs], every).plus(unknown),
        final_activity=all_of([run.final_activity for run in runs], every).plus(unknown),
        ending=first.ending,
        steps=first.steps,
    )
