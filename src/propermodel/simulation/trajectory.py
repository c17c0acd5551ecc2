"""The answer of a simulation: recorded columns by path, integrals of power, status and statistics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from propermodel.bondgraph.pseudo import is_pseudo_port
from propermodel.codegen.lower import Observable
from propermodel.codegen.machine import FloatArray, Memory, Method
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.files import FileName
from propermodel.modelling.model import Scenario
from propermodel.presentation import notebook_html
from propermodel.simulation.export import to_csv, to_pandas, to_xarray
from propermodel.simulation.observables import observable_path
from propermodel.simulation.overview import Overview, extremes_of, make_overview, overview_of_intervals
from propermodel.simulation.plotting import plot
from propermodel.simulation.recovery import integral_of, start_of, unknown_observable
from propermodel.simulation.series import ArraySeries, Series
from propermodel.simulation.stepping import Stepping

NOWHERE = Path()


class RunStatus(StrEnum):
    """How a run ended."""

    COMPLETED = "completed"
    INTERRUPTED = "interrupted"
    FAILED = "failed"
    STOPPED = "stopped"  # the condition it was to go on until has become true
    CHATTERING = "chattering"  # the events of an element follow each other without end


@dataclass(frozen=True)
class Ending:
    """How a run ended, in a sentence."""

    status: RunStatus
    message: str
    time: float
    path: Path = NOWHERE

    @property
    def is_complete(self) -> bool:
        """Whether the run reached its stop time, or the condition it was to go on until."""
        return self.status in (RunStatus.COMPLETED, RunStatus.STOPPED)


@dataclass(frozen=True, slots=True)
class EventRecord:
    """An event that has happened: when, of which element, and the energy of all storage before and after it, J."""

    time: float
    element: Path
    energy_before: float
    energy_after: float

    @property
    def lost(self) -> float:
        """The energy that left all storage, J."""
        return self.energy_before - self.energy_after


@dataclass(frozen=True)
class Statistics:
    """What a run cost."""

    steps: int
    wall_s: float
    build_s: float
    rejected: int = 0  # steps that were too inaccurate, and taken again shorter


@dataclass(frozen=True)
class TableUse:
    """How long a run was outside the grid of a table."""

    path: Path
    seconds: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory:
    """A run: `trajectory[observable]` is a recorded column over `time`.

    Integrals of power and of its absolute value were made inside the integration loop, at every step, for every bond;
    `integral_times` are the instants at which they were kept.
    """

    compiled: CompiledModel
    scenario: Scenario
    method: Method
    step: float
    jacobian_every: int  # steps that an implicit method takes with one Jacobian
    tolerance: float  # of a method that controls its steps
    signals: Series  # recorded entries over time
    recorded: Mapping[int, int]  # entry of the program's signals: column
    power_integrals: Series  # of power and then of its absolute value, over `integral_times`
    intervals: Series | None  # between rows, with the least and then the greatest values; none if not asked for
    start_signals: FloatArray
    final_signals: FloatArray
    memory: Memory
    ending: Ending
    statistics: Statistics
    events: tuple[EventRecord, ...] = ()  # since the origin of the run, in order
    notes: tuple[str, ...] = ()  # what must be said about the start

    @property
    def time(self) -> FloatArray:
        """The instants of the recorded rows."""
        return self.signals.times()

    @property
    def columns(self) -> FloatArray:
        """All recorded rows; those of a run that was recorded to a file are all read."""
        return self.signals.values()

    @property
    def integral_times(self) -> FloatArray:
        """The instants at which integrals of power were kept."""
        return self.power_integrals.times()

    @property
    def integrals(self) -> FloatArray:
        """The integrals of power at these instants, one column for each power of the program, J."""
        return self.power_integrals.values()[:, : len(self.compiled.lowered.powers)]

    @property
    def activities(self) -> FloatArray:
        """The integrals of the absolute value of power, likewise."""
        return self.power_integrals.values()[:, len(self.compiled.lowered.powers) :]

    def __getitem__(self, observable: Expr | Path | str) -> FloatArray:
        """A recorded column, by observable (`truck.body.flange.flow`), path or text.

        Raises:
            SimulationError: the model has no such observable, or it was not recorded.
        """
        path = observable_path(observable)
        if path.name == "power" and path not in self.compiled.lowered.observables:
            return self[path.parent / "effort"] * self[path.parent / "flow"]
        if path.name in ("activity", "work") and path not in self.compiled.lowered.observables:
            return self._cumulative(path)
        integral = integral_of(self.compiled, path)
        if integral is not None:
            begin = start_of(self.compiled, self.scenario, path, integral)
            return integral.values(self.time, self[integral.rate], begin)
        return self.signals.column(self.column_of(path))

    def _cumulative(self, path: Path) -> FloatArray:
        """The integral of power (`work`) or of its absolute value (`activity`) of a bond or row since the start, J.

        Integrated at every step, kept at `integral_times`, linear in between.
        """
        index = self.power_index(path.parent)
        kept = self.kept_activity(path.parent) if path.name == "activity" else self.power_integrals.column(index)
        return np.interp(self.time, self.integral_times, kept)

    def kept_activity(self, entry: Path) -> FloatArray:
        """The activity of a bond or row since the start, at `integral_times`, J."""
        return self.power_integrals.column(len(self.compiled.lowered.powers) + self.power_index(entry))

    def overview(
        self, observable: Expr | Path | str, start: float = -math.inf, stop: float = math.inf, points: int = 2000
    ) -> Overview:
        """The least and greatest values of a recorded column in about so many intervals, to draw a long one by.

        Raises:
            SimulationError: the model has no such observable, or it was not recorded.
        """
        path = observable_path(observable)
        if path.name in ("power", "activity", "work") and path not in self.compiled.lowered.observables:
            made = ArraySeries(self.time, self[path][:, np.newaxis])
            return make_overview(made, 0, 1, start, stop, points)
        width = len(self.recorded)
        if self.intervals is not None:
            return overview_of_intervals(self.intervals, self.column_of(path), width, start, stop, points)
        return make_overview(self.signals, self.column_of(path), width, start, stop, points)

    def extremes(self, observable: Expr | Path | str) -> Overview:
        """The least and greatest value of a recorded column after any step between two rows, these included.

        The last interval ends with the run. Integrated and multiplied columns (`activity`, `work`, `power`) have none.

        Raises:
            SimulationError: the model has no such observable, or its extremes were not recorded.
        """
        path = observable_path(observable)
        column = self.column_of(path)
        if self.intervals is None:
            raise SimulationError.of(
                "simulation/not-recorded",
                f"the extremes of '{path}' between rows were not recorded in this run",
                help="ask for them: simulate(..., record_extremes=True)",
            )
        return extremes_of(self.intervals, column, len(self.recorded))

    def column_of(self, path: Path) -> int:
        """The column of `signals` that holds an observable.

        Raises:
            SimulationError: the model has no such observable, or it was not recorded.
        """
        column = self.recorded.get(self._observable(path).index)
        if column is None:
            raise SimulationError.of(
                "simulation/not-recorded",
                f"'{path}' was not recorded in this run",
                help="name it in simulate(..., record=[...])",
            )
        return column

    def _observable(self, path: Path) -> Observable:
        known = self.compiled.lowered.observables
        if path not in known:
            raise SimulationError([unknown_observable(self.compiled, path)])
        return known[path]

    def __contains__(self, observable: Expr | Path | str) -> bool:
        path = observable_path(observable)
        known = self.compiled.lowered.observables
        try:
            integral = integral_of(self.compiled, path)
        except SimulationError:
            return False
        asked = path if integral is None else integral.rate
        return asked in known and known[asked].index in self.recorded

    def unit(self, observable: Expr | Path | str) -> str:
        """The unit of an observable."""
        path = observable_path(observable)
        if path.name == "power":
            return "" if is_pseudo_port(self.compiled.graph, path.parent) else "W"
        if path.name in ("activity", "work") and path not in self.compiled.lowered.observables:
            return "" if is_pseudo_port(self.compiled.graph, path.parent) else "J"
        return self._observable(path).unit

    def at_start(self, observable: Expr | Path | str) -> float:
        """The value of any observable at the start, recorded or not."""
        path = observable_path(observable)
        integral = integral_of(self.compiled, path)
        if integral is not None:
            return start_of(self.compiled, self.scenario, path, integral)
        return self._value(self.start_signals, path)

    def at_end(self, observable: Expr | Path | str) -> float:
        """The value of any observable at the end; recorded or not, unless it is an integral of one that is recorded."""
        path = observable_path(observable)
        if integral_of(self.compiled, path) is not None:
            return float(self[path][-1])
        return self._value(self.final_signals, path)

    def _value(self, signals: FloatArray, path: Path) -> float:
        if path.name == "power" and path not in self.compiled.lowered.observables:
            return self._value(signals, path.parent / "effort") * self._value(signals, path.parent / "flow")
        return float(signals[self._observable(path).index])

    def activity(self, entry: Path | str) -> float:
        """The integral of |power| of a bond or row over the whole run, J."""
        return float(self.memory.activity[self.power_index(entry)])

    def work(self, entry: Path | str) -> float:
        """The integral of power of a bond (along its half arrow) or row (into it) over the whole run, J."""
        return float(self.memory.integral[self.power_index(entry)])

    def power_index(self, entry: Path | str) -> int:
        """The entry of the power array that belongs to a bond or row."""
        path = observable_path(entry)
        places = self.compiled.lowered.power_places
        if path not in places:
            raise SimulationError.of(
                "simulation/unknown-bond",
                f"the model has no bond or row '{path}'",
                help=one_of(str(path), map(str, places)),
            )
        return places[path]

    @property
    def outside_tables(self) -> tuple[TableUse, ...]:
        """The tables whose grid the run left, and for how long."""
        return outside_tables(self.compiled, self.memory)

    def to_pandas(self, only: Iterable[Expr | Path | str] | None = None) -> Any:
        """Recorded columns, by default all, as a pandas DataFrame over time; needs the extra `data`."""
        return to_pandas(self, only)

    def to_xarray(self, only: Iterable[Expr | Path | str] | None = None) -> Any:
        """Recorded columns, by default all, as an xarray Dataset over time, with units; needs the extra `data`."""
        return to_xarray(self, only)

    def to_csv(self, file: FileName, only: Iterable[Expr | Path | str] | None = None) -> None:
        """Write recorded columns, by default all, over time as CSV, in SI."""
        to_csv(self, file, only)

    def plot(self, observables: Iterable[Expr | Path | str], axes: Sequence[Any] | None = None) -> list[Any]:
        """Draw observables over time with Matplotlib, one above the other, in usual units; see `plotting.plot`."""
        return plot(self, observables, axes)

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def paths(self) -> tuple[Path, ...]:
        """Every recorded observable."""
        known = self.compiled.lowered.observables
        return tuple(path for path, observable in known.items() if observable.index in self.recorded)

    def __str__(self) -> str:
        speed = (self.ending.time - self.scenario.start) / max(self.statistics.wall_s, 1e-9)
        head = (
            f"{self.compiled.model.name}, scenario {self.scenario.name}: {self.ending.message}; "
            f"{self._steps()} in {self.statistics.wall_s:.2f} s, "
            f"{speed:.0f} times real time"
        )
        return "\n".join([head, *(f"  note: {note}" for note in self.notes)])

    def _steps(self) -> str:
        if not self.method.is_adaptive:
            return f"{self.statistics.steps} steps of {self.step:g} s ({self.method})"
        rejected = f", {self.statistics.rejected} more rejected" if self.statistics.rejected else ""
        return f"{self.statistics.steps} steps ({self.method}, tolerance {self.tolerance:g}{rejected})"

    @property
    def stepping(self) -> Stepping:
        """How it took its steps."""
        return Stepping(self.method, self.step, self.jacobian_every, self.tolerance)


def outside_tables(compiled: CompiledModel, memory: Memory) -> tuple[TableUse, ...]:
    """The tables whose grid a run has left until now, and for how long."""
    return tuple(
        TableUse(power.path, float(memory.activity[i]))
        for i, power in enumerate(compiled.lowered.powers)
        if power.kind == "outside" and memory.activity[i] > 0.0
    )


def interpolated(trajectory: Trajectory, path: Path, times: FloatArray) -> FloatArray:
    """A column at other instants, linear in between."""
    return np.interp(times, trajectory.time, trajectory[path])
