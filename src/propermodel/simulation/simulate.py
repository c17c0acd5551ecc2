"""Runs a compiled model through a scenario; the whole loop is native and returns about ten times a second."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from propermodel.codegen.machine import FloatArray, Machine, Memory, Method, Outcome, Request, Status
from propermodel.codegen.program import Array
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Faults, Path, SimulationError
from propermodel.expressions.core import Expr
from propermodel.modelling.files import FileName
from propermodel.modelling.model import Scenario
from propermodel.simulation.choosing import AUTO, Choice, choose
from propermodel.simulation.conditions import parse_condition
from propermodel.simulation.endings import ending_of
from propermodel.simulation.equilibrium import equilibrium_start
from propermodel.simulation.events import Events
from propermodel.simulation.finite import faults_of_settings
from propermodel.simulation.observables import observable_path
from propermodel.simulation.recording import FileStore, MemoryStore, Recording, RecordingStopped, stopped_ending
from propermodel.simulation.recovery import entries_for
from propermodel.simulation.stability import note_on_step
from propermodel.simulation.start import Start, begin, start_of
from propermodel.simulation.step_watch import StepWatch
from propermodel.simulation.stepping import DEFAULT_TOLERANCE, Stepping
from propermodel.simulation.stopping import add_guard, drop_guard, stopping
from propermodel.simulation.trajectory import Ending, RunStatus, Statistics, Trajectory, outside_tables
from propermodel.simulation.trajectory_format import StoredProgress, header_of

RETURN_EVERY_S = 0.1


@dataclass(frozen=True)
class Progress:
    """How far a run has come."""

    time: float  # simulated, s
    start: float
    stop: float
    wall_s: float
    steps: int
    rejected: int

    @property
    def fraction(self) -> float:
        """The share of the window that is done."""
        return (self.time - self.start) / (self.stop - self.start)

    @property
    def times_real_time(self) -> float:
        """Simulated seconds per second."""
        return (self.time - self.start) / max(self.wall_s, 1e-9)

    @property
    def seconds_left(self) -> float:
        """Estimated time to the end, s."""
        return (self.stop - self.time) / max(self.times_real_time, 1e-9)


def simulate(
    compiled: CompiledModel,
    scenario: Scenario,
    *,
    method: Choice = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    tolerance: float = DEFAULT_TOLERANCE,
    record: Iterable[Expr | Path | str] | None = None,
    record_every: float = 0.1,
    record_to: FileName | None = None,
    record_extremes: bool = False,
    integrals_every: float = 1.0,
    progress: Callable[[Progress], None] | None = None,
    continued_from: Trajectory | None = None,
    start: Literal["declared", "equilibrium"] | Start = "declared",
    until: Expr | str | None = None,
) -> Trajectory:
    """Run a scenario.

    Args:
        compiled: The model.
        scenario: Inputs, initial values, parameter values and window.
        method: How a step is taken; with "auto" a short trial decides, and the notes of the run tell what and why.
        step: Largest step, s, by default 0.2 ms; it is shortened to meet samples of controllers and recording instants.
            A method that controls its steps needs none.
        jacobian_every: How many steps of the method ros2 may share one Jacobian. More are faster; the order stays,
            but stiff parts that change quickly may no longer be damped. After the instants above there is a new one.
        tolerance: The error in one step, as a share of the largest magnitude of each state so far, for a method that
            controls its steps.
        record: Observables to record; by default all.
        record_every: Period of recording, s.
        record_to: A file, by convention ending in `.npz`, to which rows go as they are made, so that memory stays
            bounded however long the run is; it can be opened with `load_trajectory` also while the run goes on, and
            after its process was killed. A file that is there is replaced. Without it rows are kept in memory.
        record_extremes: Whether the least and greatest values of every recorded observable between two rows are kept,
            too, so that no peak is lost at a coarse rate: `run.extremes(observable)`. They are looked for after every
            step, which evaluates all observables there, and take twice the room of the rows.
        integrals_every: Period at which the integrals of power are kept, s; they are made at every step.
        progress: Called about ten times a second.
        continued_from: A run of the same model to go on from; `scenario.stop` is the new end.
        start: Whether the run begins with the declared initial values or at the equilibrium near them, which the
            notes of the run then tell; or a start made elsewhere. A run that is continued has its start already.
        until: A condition of observables that ends the run at the instant at which it becomes true, as an expression or
            as text (`"body.flange.flow > 20 km/h"`); a run that is continued waits until it does so anew.

    Returns:
        What was computed, also when the run was interrupted (Ctrl-C) or failed; `ending` says how it ended.
        Rows stand at the recording instants, and on either side of every event.

    Raises:
        SimulationError: the scenario or an observable does not fit the model.
    """
    stepping = Stepping(Method.RODAS if method == AUTO else Method(method), step, jacobian_every, tolerance)
    faults = Faults(SimulationError)
    faults.found.extend(faults_of_settings(scenario, stepping, record_every, integrals_every))
    selected = np.zeros(0, dtype=np.int64)
    with faults.collecting():
        selected = selected_entries(compiled, record)
    before = time.perf_counter()
    run_model = compiled
    with faults.collecting():
        condition = parse_condition(compiled, until) if isinstance(until, str) else until
        run_model = compiled if condition is None else stopping(compiled, condition)
    if faults.found and continued_from is None:
        # What else is wrong with the scenario belongs to the same answer.
        with faults.collecting():
            begin(compiled, scenario)
    faults.raise_if_any()
    longest = stepping.longest(record_every, integrals_every, scenario.stop - scenario.start)
    note = None
    if continued_from is None:
        begun = _begun(compiled, scenario, start)
        memory, notes = begun.memory, begun.notes
        if method == AUTO:
            stepping, note = choose(compiled, memory, stepping, longest, scenario.stop)
        else:
            note = note_on_step(compiled, memory, stepping.method, longest, scenario.stop - scenario.start)
        notes = notes if note is None else (*notes, note)
    else:
        memory, notes = _continue(compiled, scenario, continued_from), continued_from.notes
        stepping = continued_from.stepping if method == AUTO else stepping
    machine = run_model.machine(stepping.method)
    build_s = time.perf_counter() - before
    if until is not None:
        memory = add_guard(machine, memory, is_continued=continued_from is not None)
    # Integrals count from the origin of a run, also of one that is continued, and so does its start.
    start_signals = machine.observe(memory) if continued_from is None else continued_from.start_signals
    request = Request(
        until=scenario.stop,
        step=longest,
        row_period=record_every,
        integral_period=integrals_every,
        selected=selected,
        has_extremes=record_extremes,
        is_watched=note is None,
        most_rows=2000,
        most_ticks=200,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
    )
    before = time.perf_counter()
    earlier = () if continued_from is None else continued_from.events
    powers = len(compiled.lowered.powers)
    taken = replace(stepping, step=longest)
    with ExitStack() as files:
        store = (
            MemoryStore(
                scenario.stop - memory.time,
                record_every,
                len(selected),
                integrals_every,
                powers,
                has_extremes=record_extremes,
            )
            if record_to is None
            else FileStore(
                record_to,
                header_of(compiled, scenario, selected, notes, taken),
                len(selected),
                files,
                has_extremes=record_extremes,
            )
        )
        recording = Recording(store, selected, memory)
        watch = StepWatch(compiled, machine, longest, scenario.stop - scenario.start)
        events = Events(run_model, machine, longest, recording.keep_signals, earlier, is_stopping=until is not None)

        def stand() -> StoredProgress:
            wall_s = time.perf_counter() - before
            return StoredProgress(
                time=memory.time,
                statistics=Statistics(memory.steps_taken, wall_s, build_s, memory.steps_rejected),
                events=events.records,
                outside_tables=outside_tables(compiled, memory),
                notes=() if watch.note is None else (watch.note,),
            )

        outcome = _run(machine, memory, request, recording, progress, scenario, events, stand, watch)
        stood = stand()
        ending = ending_of(run_model, outcome, memory, recording.before, recording.overflow, taken)
        recorded = recording.finish(stood, ending, memory if isinstance(outcome, Ending) else None)
    return Trajectory(
        compiled=compiled,
        scenario=scenario,
        method=stepping.method,
        step=longest,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        signals=recorded.signals,
        recorded={int(entry): column for column, entry in enumerate(selected)},
        power_integrals=recorded.integrals,
        intervals=recorded.extremes,
        start_signals=start_signals,
        final_signals=machine.observe(memory) if recording.is_stopped else _final_signals(machine, memory, outcome),
        memory=memory if until is None else drop_guard(memory),
        ending=recorded.ending,
        statistics=stood.statistics,
        events=events.records,
        notes=(*notes, *stood.notes),
    )


def _begun(compiled: CompiledModel, scenario: Scenario, start: Literal["declared", "equilibrium"] | Start) -> Start:
    match start:
        case "declared":
            return start_of(compiled, scenario)
        case "equilibrium":
            return equilibrium_start(compiled, scenario)
        case Start():
            return start


def _run(
    machine: Machine,
    memory: Memory,
    request: Request,
    recording: Recording,
    progress: Callable[[Progress], None] | None,
    scenario: Scenario,
    events: Events,
    stand: Callable[[], StoredProgress],
    watch: StepWatch,
) -> Outcome | Ending | None:
    """Run to the end, returning often.

    None when the user interrupts; an ending where events have no end, or no more can be recorded.
    """
    begin_wall = time.perf_counter()
    try:
        ending = events.begin(memory)
        if ending is not None:
            return ending
        while True:
            recording.before = memory.copy()
            before = time.perf_counter()
            outcome = machine.run(memory, request)
            taken = time.perf_counter() - before
            watch.heed(memory)
            recording.keep(outcome, stand)
            if progress is not None:
                wall_s = time.perf_counter() - begin_wall
                span = scenario.start, scenario.stop
                progress(Progress(memory.time, *span, wall_s, memory.steps_taken, memory.steps_rejected))
            if outcome.status is Status.EVENT and recording.overflow is None:
                ending = events.happen(memory, outcome.step)
                if ending is not None:
                    return ending
                continue
            if outcome.status is not Status.PAUSED or recording.overflow is not None:
                return outcome
            factor = min(max(RETURN_EVERY_S / max(taken, 1e-6), 0.25), 4.0)
            request = replace(request, most_ticks=max(1, min(int(request.most_ticks * factor), 1_000_000)))
    except RecordingStopped as error:
        return stopped_ending(error, memory.time)
    except KeyboardInterrupt:
        return None


def _final_signals(machine: Machine, memory: Memory, outcome: Outcome | Ending | None) -> FloatArray:
    """All observables at the end; not a number where a failed run's last state has no solution."""
    is_unsolved = (
        outcome.status is RunStatus.FAILED
        if isinstance(outcome, Ending)
        else outcome is not None and outcome.status is Status.NOT_CONVERGED
    )
    if not is_unsolved:
        return machine.observe(memory)
    return np.full(machine.program.layout.lengths[Array.SIGNAL], np.nan)


def selected_entries(
    compiled: CompiledModel, record: Iterable[Expr | Path | str] | None
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """The entries of the program's signals that hold these observables; by default all of them.

    Raises:
        SimulationError: the model has no such observable.
    """
    known = compiled.lowered.observables
    if record is None:
        return np.arange(compiled.lowered.signal_count, dtype=np.int64)
    faults = Faults(SimulationError)
    chosen: dict[int, None] = {}
    for item in record:
        with faults.collecting():
            for name in entries_for(compiled, observable_path(item)):
                chosen[known[name].index] = None
    faults.raise_if_any()
    return np.array(list(chosen), dtype=np.int64)


def _continue(compiled: CompiledModel, scenario: Scenario, earlier: Trajectory) -> Memory:
    if earlier.compiled is not compiled:
        raise SimulationError.of(
            "simulation/continue",
            "a run can only be continued with the compiled model that began it",
            help="pass the compiled model of the earlier run: simulate(earlier.compiled, ...)",
        )
    # Extremes between rows begin anew, as what is recorded may be another.
    memory = replace(earlier.memory.copy(), least=np.zeros(0), greatest=np.zeros(0))
    memory.fastest, memory.next_look = 0.0, memory.steps_taken
    if not scenario.stop > memory.time:
        raise SimulationError.of(
            "simulation/window",
            f"the run to continue is already at {memory.time} s, past the stop {scenario.stop} s",
            help="give the scenario a later stop: it is the end of the whole run, not of the part that is added",
        )
    return memory
