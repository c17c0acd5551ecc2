"""Several runs in the lanes of one machine: their memories side by side, and how each of them ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.codegen.machine import FloatArray, Machine, Memory, Request, Status
from propermodel.compiler import CompiledModel
from propermodel.simulation.endings import failed_ending, overflow_ending
from propermodel.simulation.overflow import overflow_at_end
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.trajectory import Ending, RunStatus


@dataclass(frozen=True, eq=False)
class LaneResults:
    """What the runs of a group gave; the first axis counts them. A run that failed has rows up to then, and no end."""

    time: FloatArray
    rows: FloatArray  # runs x rows x selected
    begins: FloatArray  # of the intervals between rows, the last one to the end; none where extremes are not asked for
    least: FloatArray  # runs x intervals x selected
    greatest: FloatArray
    final: FloatArray  # runs x selected
    integrals: FloatArray  # runs x powers
    activities: FloatArray
    endings: tuple[Ending, ...]
    steps: int


def joined(memories: Sequence[Memory], lanes: int) -> Memory:
    """The memories of runs that start together as one of several lanes; lanes that are left over are not alive."""
    if lanes == 1:
        return memories[0].copy()
    filled = [*memories, *[memories[-1]] * (lanes - len(memories))]
    arrays = {name: np.stack([getattr(memory, name) for memory in filled], axis=1) for name in _OF_A_LANE}
    return replace(memories[0].copy(), **arrays, alive=np.arange(lanes) < len(memories))


def lane_of(memory: Memory, lane: int) -> Memory:
    """The memory of one of the runs in a memory of several lanes."""
    if memory.alive.size == 1:
        return memory
    arrays = {name: getattr(memory, name)[:, lane].copy() for name in _OF_A_LANE}
    return replace(memory.copy(), **arrays, alive=np.ones(1, dtype=np.bool_))


_OF_A_LANE = (
    "state",
    "discrete",
    "parameter",
    "unknown",
    "guard",
    "integral",
    "activity",
    "lower",
    "upper",
    "size",
    "least",
    "greatest",
    "direction",
)


def run_together(
    compiled: CompiledModel, machine: Machine, memories: Sequence[Memory], request: Request
) -> LaneResults:
    """Run a group to its end, in as many lanes as the machine has."""
    memory = joined(memories, machine.lanes)
    count = len(memories)
    endings: dict[int, Ending] = {}
    times: list[FloatArray] = []
    rows: list[FloatArray] = []
    extremes: list[tuple[FloatArray, FloatArray]] = []
    while True:
        before = memory.copy()
        outcome = machine.run(memory, request)
        rows.append(_lanes(outcome.rows, machine.lanes)[:, :, :count])
        times.append(outcome.row_times)
        extremes.append((outcome.least, outcome.greatest))
        for failure in outcome.failures:
            if failure.lane < count and failure.lane not in endings:
                here, there = lane_of(memory, failure.lane), lane_of(before, failure.lane)
                taken = Stepping(machine.method, request.step)
                endings[failure.lane] = failed_ending(compiled, failure, here, there, taken)
        if outcome.status is not Status.PAUSED:
            break
    final = np.full((count, request.selected.size), np.nan)
    if memory.alive.any():
        final[...] = _lanes(machine.observe(memory), machine.lanes)[request.selected, :count].T
    time = np.concatenate(times)
    recorded = np.concatenate(rows).transpose(2, 0, 1)
    if request.has_extremes and time.size and memory.time > time[-1]:
        extremes.append((memory.least[np.newaxis], memory.greatest[np.newaxis]))
    least, greatest = (_of_runs(parts, machine.lanes, count) for parts in zip(*extremes, strict=True))
    begins, ends = time[: least.shape[1]], np.append(time[1:], memory.time)[: least.shape[1]]
    integrals, activities = (
        _lanes(kept, machine.lanes)[:, :count].T.copy() for kept in (memory.integral, memory.activity)
    )
    for lane in range(count):
        overflow = None if lane in endings else overflow_at_end(lane_of(memory, lane))
        if overflow is not None:
            endings[lane] = overflow_ending(compiled, overflow, lane_of(memory, lane))
        if lane in endings:
            recorded[lane, time > endings[lane].time] = np.nan
            least[lane, ends > endings[lane].time] = np.nan
            greatest[lane, ends > endings[lane].time] = np.nan
            final[lane], integrals[lane], activities[lane] = np.nan, np.nan, np.nan
    done = Ending(RunStatus.COMPLETED, f"completed to {memory.time:.6g} s", memory.time)
    return LaneResults(
        time=time,
        rows=recorded,
        begins=begins,
        least=least,
        greatest=greatest,
        final=final,
        integrals=integrals,
        activities=activities,
        endings=tuple(endings.get(lane, done) for lane in range(count)),
        steps=memory.steps_taken,
    )


def _lanes(values: FloatArray, lanes: int) -> FloatArray:
    """With an axis of lanes, last, also where there is one."""
    return values[..., np.newaxis] if lanes == 1 else values


def _of_runs(parts: Sequence[FloatArray], lanes: int, count: int) -> FloatArray:
    """Extremes of some runs, runs first; those of the first row are that row, with which an interval begins."""
    rows = np.concatenate([_lanes(part, lanes)[:, :, :count] for part in parts]).transpose(2, 0, 1)[:, 1:].copy()
    rows[np.isinf(rows)] = np.nan
    return rows
