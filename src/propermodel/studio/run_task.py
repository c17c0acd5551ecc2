"""A run in a worker: what was ordered, recorded to the job's folder as it goes on."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.analysis.balance import energy_balance
from propermodel.catalogue.faults import CatalogueError
from propermodel.catalogue.finding import load_subject
from propermodel.catalogue.settings import read_settings
from propermodel.catalogue.subject import Subject, changed
from propermodel.compiler import CompiledModel, Method, compile_quietly
from propermodel.diagnostics import Faults, Path
from propermodel.report.buckets import extremes
from propermodel.report.options import StudyOptions, check_outputs
from propermodel.simulation.choosing import AUTO
from propermodel.simulation.display_units import display_for
from propermodel.simulation.simulate import Progress, simulate
from propermodel.simulation.trajectory import RunStatus, Trajectory
from propermodel.studio.faults import StudioError
from propermodel.studio.job import JobState
from propermodel.studio.model_sheet import owner_of
from propermodel.studio.orders import RUN_ORDER, RunOrder, method_of, read_order_data
from propermodel.studio.store import RUN_FILE
from propermodel.studio.worker import Control

Json = Any

SPARK_INTERVALS = 30
_EXACTLY = 1.0 - 1e-9  # a quotient that is whole to rounding is that number

STATES = {
    RunStatus.COMPLETED: JobState.COMPLETE,
    RunStatus.STOPPED: JobState.COMPLETE,
    RunStatus.INTERRUPTED: JobState.CANCELLED,
    RunStatus.FAILED: JobState.FAILED,
    RunStatus.CHATTERING: JobState.FAILED,
}


@dataclass(frozen=True, slots=True)
class Periods:
    """At which rows are recorded and integrals of power kept, s."""

    rows: float
    integrals: float


def run(arguments: Json, control: Control) -> Json:
    """Make the run that was ordered.

    Raises:
        ProperModelError: the order does not fit the model.
    """
    order = read_order_data(RUN_ORDER, arguments["order"])
    subject = ordered_subject(order)
    scenario = subject.scenario
    control.say({"scenario": scenario.name, "window": [scenario.start, scenario.stop]})
    control.say({"stage": "compiling"})
    compiled = compile_quietly(subject.model)
    check_outputs(compiled, subject.outputs)
    periods = periods_of(subject)
    trajectory = simulate(
        compiled,
        scenario,
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        tolerance=subject.tolerance,
        record_every=periods.rows,
        integrals_every=periods.integrals,
        record_to=FilePath(arguments["folder"]) / RUN_FILE,
        progress=teller(control),
    )
    return result_of(trajectory, subject.outputs)


def ordered_subject(order: RunOrder) -> Subject:
    """The model and scenario of an order, with its settings.

    Raises:
        ProperModelError: the order does not fit the model.
    """
    subject = load_subject(order.model, order.scenario or None)
    if order.method and order.method not in (*Method, AUTO):
        raise StudioError.with_status(
            422, "studio/method", f"there is no method '{order.method}'", help=f"one of {', '.join((*Method, AUTO))}"
        )
    faults = Faults(CatalogueError)
    parameters = read_settings(subject.model, {str(path): text for path, text in order.settings.items()}, faults)
    faults.raise_if_any()
    return changed(
        subject,
        until=order.until,
        method=method_of(order.method),
        step=order.step,
        tolerance=order.tolerance,
        parameters=parameters,
        outputs=order.outputs,
    )


def periods_of(subject: Subject) -> Periods:
    """The periods of a study, a little shorter where they would not divide the scenario or each other.

    So a row and the integrals of power stand at the end of a run, and a row wherever integrals do.
    """
    options = StudyOptions(method=subject.method, step=subject.step)
    scenario = subject.scenario
    rows, integrals = options.record_every(scenario), options.integrals_every(scenario)
    length = scenario.stop - scenario.start
    if not (math.isfinite(length) and length > 0.0 and rows > 0.0 and integrals > 0.0):
        return Periods(rows, integrals)  # what is wrong with them is told by the simulation
    count = max(1, math.ceil(length / integrals * _EXACTLY))
    each = max(1, math.ceil(length / count / rows * _EXACTLY))
    return Periods(length / (count * each), length / count)


def teller(control: Control, stage: str = "running") -> Callable[[Progress], None]:
    """What tells the server how far a run is, and stops the run when the server asks for it."""
    control.say({"stage": stage})

    def tell(progress: Progress) -> None:
        if control.is_cancelled:
            raise KeyboardInterrupt  # as Ctrl-C does: the run ends with what it has
        control.say(
            {
                "progress": {
                    "time": progress.time,
                    "end": progress.stop,
                    "steps": progress.steps,
                    "rejected": progress.rejected,
                    "rate": progress.times_real_time,
                    "left": progress.seconds_left if progress.time > progress.start else None,
                }
            }
        )

    return tell


def result_of(run: Trajectory, outputs: tuple[Path, ...]) -> Json:
    """What the server keeps of a run."""
    ending = run.ending
    owner = owner_of(run.compiled.graph, ending.path) if ending.path else None
    shown = outputs or main_signals(run.compiled)
    return {
        "state": STATES[ending.status].value,
        "message": ending.message,
        "elements": [str(owner)] if owner is not None else [],
        "spark": _spark(run, shown[0]) if shown else None,
        "outputs": [str(path) for path in outputs],
        "summary": [{"name": name, "value": value, "note": note} for name, value, note in _summary(run, shown)],
    }


def main_signals(compiled: CompiledModel) -> tuple[Path, ...]:
    """What is looked at first where nobody says: the states of the model, a few."""
    return tuple(state.path for state in compiled.system.states)[:8]


def _summary(run: Trajectory, outputs: tuple[Path, ...]) -> list[tuple[str, str, str]]:
    statistics = run.statistics
    rejected = f", {statistics.rejected} more rejected" if statistics.rejected else ""
    found = [
        ("steps", str(statistics.steps), f"{run.method.value}, at most {run.step:.3g} s{rejected}"),
        ("wall time", f"{statistics.wall_s:.2f} s", "with the start and the recording of the run"),
    ]
    if run.ending.is_complete:
        residual = energy_balance(run).relative_residual
        found.append(("energy unaccounted", f"{residual:.0e}", "of the work of sources"))
    found += [(f"{use.path}", f"{use.seconds:.3g} s", "outside the table") for use in run.outside_tables]
    found += [("note", note, "") for note in run.notes]
    for path in outputs[:6]:
        if path in run:
            start, end = run.at_start(path), run.at_end(path)
            seen = run.overview(path, points=1)
            size = float(np.nanmax(np.abs([*seen.least, *seen.greatest, start, end])))
            if math.isfinite(start) and math.isfinite(end):
                display = display_for(run.unit(path), size)
                value = f"{start * display.factor:.4g} → {end * display.factor:.4g} {display.unit}".rstrip()
                found.append((str(path), value, "from start to end"))
    return found


def _spark(run: Trajectory, path: Path) -> list[float] | None:
    """A small line: extremes of a signal in a few intervals; none where there is nothing to draw."""
    if path not in run or not len(run.signals):
        return None
    time, values = run.time, run[path]
    end = min(run.scenario.stop, float(time[-1]))
    if not end > time[0]:
        return None
    line = extremes(time, values, np.linspace(float(time[0]), end, SPARK_INTERVALS + 1))
    return line.tolist() if np.isfinite(line).all() else None
