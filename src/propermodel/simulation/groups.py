"""Designs of an ensemble in groups that run side by side, wherever that may be.

A group is sent to a thread or to another process: it holds plain data, and the compiled model goes as its document.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.machine import (
    SAME_INSTANT,
    FloatArray,
    IntArray,
    Memory,
    Request,
    TableData,
    instant,
    sample_periods,
)
from propermodel.compiler import CompiledModel
from propermodel.modelling.model import Scenario
from propermodel.simulation.side_by_side import LaneResults, run_together
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import Start, start_of
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.table_store import TableStore
from propermodel.simulation.trajectory import Trajectory

NO_ROWS = float("inf")
MOST_ROWS_AT_ONCE = 1024


@dataclass(frozen=True, eq=False)
class Group:
    """Designs that start and stop together and share their tables."""

    numbers: tuple[int, ...]
    scenarios: tuple[Scenario, ...]
    starts: tuple[Start, ...]

    def job(self, settings: Settings) -> LaneJob | EventJob:
        """What is to be run."""
        if settings.compiled.system.events:
            return EventJob(settings, self.scenarios[0], self.starts[0])
        # The scenario itself stays here: its tables, which may be large, are in the memories.
        return LaneJob(
            settings, self.scenarios[0].start, self.scenarios[0].stop, tuple(start.memory for start in self.starts)
        )


@dataclass(frozen=True, eq=False)
class Settings:
    """What all groups have in common."""

    compiled: CompiledModel
    stepping: Stepping
    record_every: float
    selected: IntArray
    lanes: int
    has_extremes: bool = False


@dataclass(frozen=True, eq=False)
class LaneJob:
    """Runs in the lanes of one machine."""

    settings: Settings
    begin: float
    stop: float
    memories: tuple[Memory, ...]

    def __call__(self) -> LaneResults:
        """Run them."""
        settings = self.settings
        machine = settings.compiled.machine(settings.stepping.method, settings.lanes if len(self.memories) > 1 else 1)
        request = Request(
            until=self.stop,
            step=settings.stepping.longest(settings.record_every, self.stop - self.begin),
            row_period=settings.record_every,
            selected=settings.selected,
            has_extremes=settings.has_extremes,
            most_rows=MOST_ROWS_AT_ONCE,
            jacobian_every=settings.stepping.jacobian_every,
            tolerance=settings.stepping.tolerance,
        )
        return run_together(settings.compiled, machine, self.memories, request)


@dataclass(frozen=True, eq=False)
class EventJob:
    """One design whose events happen at instants of its own; only its regular rows are kept."""

    settings: Settings
    scenario: Scenario
    start: Start

    def __call__(self) -> LaneResults:
        """Run it."""
        settings, scenario = self.settings, self.scenario
        known = settings.compiled.lowered.observables
        entries = set(settings.selected.tolist())
        run = simulate(
            settings.compiled,
            scenario,
            method=settings.stepping.method,
            step=settings.stepping.step,
            jacobian_every=settings.stepping.jacobian_every,
            tolerance=settings.stepping.tolerance,
            record=[path for path, observable in known.items() if observable.index in entries],
            record_every=min(settings.record_every, scenario.stop - scenario.start),
            integrals_every=scenario.stop - scenario.start,
            start=self.start,
            record_extremes=settings.has_extremes,
        )
        time: FloatArray = np.zeros(0)
        rows: FloatArray = np.zeros((0, settings.selected.size))
        if settings.record_every < NO_ROWS:
            count = int((scenario.stop - scenario.start) / settings.record_every + SAME_INSTANT) + 1
            time = np.array([instant(scenario.start, k, settings.record_every) for k in range(count)])
            # The row after an event stands last among those of one instant.
            last = np.searchsorted(run.time, time + SAME_INSTANT * run.step, side="right") - 1
            order = [run.recorded[int(entry)] for entry in settings.selected]
            rows = np.where((time <= run.ending.time)[:, np.newaxis], run.columns[last][:, order], np.nan)
        begins, least, greatest = self._extremes(run, time)
        end = np.nan if not run.ending.is_complete else 0.0
        return LaneResults(
            time=time,
            rows=rows[np.newaxis],
            begins=begins,
            least=least[np.newaxis],
            greatest=greatest[np.newaxis],
            final=run.final_signals[np.newaxis, settings.selected] + end,
            integrals=run.memory.integral[np.newaxis] + end,
            activities=run.memory.activity[np.newaxis] + end,
            endings=(run.ending,),
            steps=run.statistics.steps,
        )

    def _extremes(self, run: Trajectory, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The extremes between regular rows, those around events in them; of all of the run where there are no rows."""
        count = self.settings.selected.size
        if run.intervals is None:
            return np.zeros(0), np.zeros((0, count)), np.zeros((0, count))
        near = SAME_INSTANT * run.step
        rows = time if time.size else np.array([self.scenario.start])
        begins = rows[rows < self.scenario.stop - near]
        places = np.searchsorted(run.intervals.times(), begins - near)
        order = np.array([run.recorded[int(entry)] for entry in self.settings.selected], dtype=np.int64)
        values = run.intervals.values()
        is_over = np.append(begins[1:], self.scenario.stop) > run.ending.time + near
        found: list[FloatArray] = []
        for reduce, columns in ((np.fmin, order), (np.fmax, order + len(run.recorded))):
            side = np.full((len(begins), count), np.nan)
            inside = places < len(values)
            side[inside] = reduce.reduceat(values[:, columns], places[inside], axis=0)
            side[is_over] = np.nan
            found.append(side)
        return begins, found[0], found[1]


def groups(compiled: CompiledModel, scenarios: Sequence[Scenario], lanes: int) -> Iterator[Group]:
    """Designs that can run side by side, with their starts; as few at a time as fill the lanes."""
    store = TableStore()
    waiting: dict[tuple[Any, ...], list[tuple[int, Scenario, Start]]] = {}
    shared: dict[tuple[Any, ...], tuple[TableData, ...]] = {}
    for number, scenario in enumerate(scenarios):
        start = start_of(compiled, scenario, store)
        tables = tuple(map(id, start.memory.tables))
        periods = tuple(sample_periods(compiled.lowered.program, start.memory))
        # Machines prepare tables once for every tuple of them.
        start.memory.tables = shared.setdefault(tables, start.memory.tables)
        key = (scenario.start, scenario.stop, tables, periods)
        members = waiting.setdefault(key, [])
        members.append((number, scenario, start))
        if len(members) == lanes:
            del waiting[key]
            yield Group(*zip(*members, strict=True))
    for members in waiting.values():
        yield Group(*zip(*members, strict=True))
