"""A run in a file made a trajectory again, so that it can be ranked and reduced without being repeated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from propermodel.codegen.machine import FloatArray, Memory
from propermodel.codegen.program import Array
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import DocumentError
from propermodel.simulation.series import Series
from propermodel.simulation.start import begin
from propermodel.simulation.storage import StoredTrajectory
from propermodel.simulation.trajectory import Ending, RunStatus, Trajectory


def reopened(stored: StoredTrajectory) -> Trajectory:
    """The trajectory of a run whose observables were all recorded, with its model compiled.

    A run that was stopped, or is still recorded, ends where integrals of power were kept last: its scenario then stops
    there. A file tells values at rows only, so those at the start are the ones after controllers have run first, those
    at the end the ones of the last row, and the run cannot be continued.

    Raises:
        DocumentError: the file holds a part of what the model gives, or no integrals of power yet.
        ProperModelError: the model or scenario in the file is wrong.
    """
    compiled = compile_quietly(stored.model)
    if not _is_whole(stored, compiled):
        raise _partial(stored, "a part of what its runs record")
    times = stored.integral_times
    if len(times) < 2 or not len(stored.signals):
        raise _partial(stored, "only the start of one of its runs")
    scenario, ending = stored.scenario, stored.ending
    end = float(times[-1])
    if not ending.is_complete:
        scenario, ending = replace(scenario, stop=end), Ending(RunStatus.COMPLETED, ending.message, end)
    entries = {compiled.lowered.observables[path].index: stored.column_of(path) for path in stored.paths}
    last = stored.signals.find(end, is_after=True) - 1
    final = _signals(compiled, stored.signals, entries, last)
    return Trajectory(
        compiled=compiled,
        scenario=scenario,
        method=stored.method,
        step=stored.step,
        jacobian_every=stored.jacobian_every,
        tolerance=stored.tolerance,
        signals=stored.signals,
        recorded=entries,
        power_integrals=stored.power_integrals,
        intervals=stored.intervals,
        start_signals=_signals(compiled, stored.signals, entries, 0),
        final_signals=final,
        memory=_memory(stored, compiled, final, end),
        ending=ending,
        statistics=stored.statistics,
        events=stored.events,
        notes=stored.notes,
    )


def _is_whole(stored: StoredTrajectory, compiled: CompiledModel) -> bool:
    """Whether a file has every observable and integral of a model, and no others."""
    powers = {power.path: index for index, power in enumerate(compiled.lowered.powers) if power.kind != "outside"}
    return set(stored.paths) == set(compiled.lowered.observables) and stored.powers == powers


def _partial(stored: StoredTrajectory, what: str) -> DocumentError:
    return DocumentError.of(
        "document/partial-run",
        f"the file of {stored.model.name} holds {what}",
        help="record a run to its end with all observables: simulate(..., record_to=...) without record=[...]",
    )


def _signals(compiled: CompiledModel, series: Series, entries: dict[int, int], row: int) -> FloatArray:
    """All signals at a row."""
    found = np.full(compiled.lowered.program.layout.lengths[Array.SIGNAL], np.nan)
    for entry, column in entries.items():
        found[entry] = series.column(column, row, row + 1).item()
    return found


def _memory(stored: StoredTrajectory, compiled: CompiledModel, final: FloatArray, end: float) -> Memory:
    """The memory of the run at its end, as far as a file tells it."""
    known = compiled.lowered.observables
    memory = begin(compiled, stored.scenario)
    memory.time = end
    memory.steps_taken, memory.steps_rejected = stored.statistics.steps, stored.statistics.rejected
    memory.state[:] = [final[known[state.path].index] for state in compiled.system.states]
    memory.discrete[:] = [final[known[held.data.path].index] for held in compiled.lowered.held]
    row, count = len(stored.power_integrals) - 1, len(compiled.lowered.powers)
    kept = [stored.power_integrals.column(column, row, row + 1).item() for column in range(2 * count)]
    memory.integral[:], memory.activity[:] = kept[:count], kept[count:]
    return memory
