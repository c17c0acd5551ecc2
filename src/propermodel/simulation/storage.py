"""Trajectories as files, written at once or while the run goes on; their rows are read when they are asked for."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.machine import FloatArray, Method
from propermodel.diagnostics import DocumentError, Path, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.files import FileName, partial_file
from propermodel.modelling.limits import LIMITS, Limits
from propermodel.modelling.model import Model, Scenario
from propermodel.simulation.export import frames, to_csv, to_pandas, to_xarray
from propermodel.simulation.observables import observable_path
from propermodel.simulation.overview import Overview, extremes_of, make_overview, overview_of_intervals
from propermodel.simulation.run_file import read_run
from propermodel.simulation.run_writer import RunWriter
from propermodel.simulation.series import ArraySeries, Series
from propermodel.simulation.trajectory import (
    Ending,
    EventRecord,
    Statistics,
    TableUse,
    Trajectory,
)
from propermodel.simulation.trajectory_format import Header, StoredProgress


@dataclass(frozen=True, eq=False, kw_only=True)
class StoredTrajectory:
    """A run in a file: `stored[observable]` is a column over `time`, as in the run that was saved or recorded.

    Columns are read from the file when they are asked for, one at a time, so the file must stay where it is.
    """

    model: Model
    scenario: Scenario
    method: Method
    step: float
    jacobian_every: int
    tolerance: float
    units: Mapping[Path, str]
    ending: Ending
    statistics: Statistics
    events: tuple[EventRecord, ...]
    notes: tuple[str, ...]
    outside_tables: tuple[TableUse, ...]
    signals: Series
    power_integrals: Series
    intervals: Series | None  # between rows, with the least and then the greatest values; none if not recorded
    _entries: Mapping[Path, int]
    _width: int
    _powers: Mapping[Path, int]
    _power_count: int

    @property
    def time(self) -> FloatArray:
        """The instants of the rows."""
        return self.signals.times()

    @property
    def integral_times(self) -> FloatArray:
        """The instants at which integrals of power were kept."""
        return self.power_integrals.times()

    @property
    def paths(self) -> tuple[Path, ...]:
        """Every stored observable."""
        return tuple(self._entries)

    @property
    def powers(self) -> Mapping[Path, int]:
        """The bonds and rows whose power was integrated, with their places among the integrals."""
        return self._powers

    def __contains__(self, observable: Expr | Path | str) -> bool:
        return observable_path(observable) in self._entries

    def __getitem__(self, observable: Expr | Path | str) -> FloatArray:
        """A stored column, by observable, path or text.

        Raises:
            DocumentError: the file holds no such column.
        """
        path = observable_path(observable)
        if path.name == "power" and path not in self._entries:
            return self[path.parent / "effort"] * self[path.parent / "flow"]
        return self.signals.column(self.column_of(path))

    def column_of(self, path: Path) -> int:
        """The column of `signals` that holds an observable.

        Raises:
            DocumentError: the file holds no such column.
        """
        return self._find(path, self._entries, "observable")

    def overview(
        self, observable: Expr | Path | str, start: float = -math.inf, stop: float = math.inf, points: int = 2000
    ) -> Overview:
        """The least and greatest values of a column in about so many intervals, to draw a long one by.

        Raises:
            DocumentError: the file holds no such column.
        """
        path = observable_path(observable)
        if path.name == "power" and path not in self._entries:
            return make_overview(ArraySeries(self.time, self[path][:, np.newaxis]), 0, 1, start, stop, points)
        if self.intervals is not None:
            return overview_of_intervals(self.intervals, self.column_of(path), self._width, start, stop, points)
        return make_overview(self.signals, self.column_of(path), self._width, start, stop, points)

    def extremes(self, observable: Expr | Path | str) -> Overview:
        """The least and greatest value of a column after any step between two rows, as in the run.

        Raises:
            DocumentError: the file holds no such column, or no extremes.
        """
        path = observable_path(observable)
        column = self.column_of(path)
        if self.intervals is None:
            raise DocumentError.of(
                "document/column",
                f"the file holds no extremes of '{path}' between rows",
                help="ask for them when the run is made: simulate(..., record_extremes=True)",
            )
        return extremes_of(self.intervals, column, self._width)

    def unit(self, observable: Expr | Path | str) -> str:
        """The unit of a stored observable."""
        path = observable_path(observable)
        return self.units.get(path, "W" if path.name == "power" else "")

    def work(self, entry: Path) -> FloatArray:
        """The integral of the power of a bond or row over `integral_times`, J."""
        return self.power_integrals.column(self._find(entry, self._powers, "bond or row"))

    def activity(self, entry: Path) -> FloatArray:
        """The activity of a bond or row over `integral_times`, J."""
        return self.power_integrals.column(self._power_count + self._find(entry, self._powers, "bond or row"))

    def to_pandas(self, only: Iterable[Expr | Path | str] | None = None) -> Any:
        """Columns, by default all, as a pandas DataFrame over time; needs the extra `data`."""
        return to_pandas(self, only)

    def frames(self, only: Iterable[Expr | Path | str] | None = None) -> Iterator[Any]:
        """The same, some rows at a time, for runs that are too long to be held as a whole."""
        return frames(self, only)

    def to_xarray(self, only: Iterable[Expr | Path | str] | None = None) -> Any:
        """Columns, by default all, as an xarray Dataset over time, with units; needs the extra `data`."""
        return to_xarray(self, only)

    def to_csv(self, file: FileName, only: Iterable[Expr | Path | str] | None = None) -> None:
        """Write columns, by default all, over time as CSV, in SI; some rows at a time, however many there are."""
        to_csv(self, file, only)

    def _find(self, path: Path, known: Mapping[Path, int], what: str) -> int:
        if path not in known:
            raise DocumentError.of(
                "document/column",
                f"the file holds no {what} '{path}'",
                help=one_of(str(path), map(str, known)),
            )
        return known[path]


def save_trajectory(
    trajectory: Trajectory,
    file: FileName,
    *,
    only: Iterable[Expr | Path | str] | None = None,
) -> None:
    """Write a run to a file.

    Args:
        trajectory: The run, complete or not.
        file: Where to; by convention ending in `.npz`.
        only: The observables to keep; by default all that were recorded.
    """
    known = trajectory.compiled.lowered.observables
    chosen = trajectory.paths if only is None else _columns_of(only, known)
    kept = list(dict.fromkeys(trajectory.column_of(path) for path in chosen))
    place = {column: position for position, column in enumerate(kept)}
    header = Header(
        method=trajectory.method,
        step=trajectory.step,
        jacobian_every=trajectory.jacobian_every,
        tolerance=trajectory.tolerance,
        notes=trajectory.notes,
        columns=tuple((path, trajectory.unit(path), place[trajectory.column_of(path)]) for path in chosen),
        powers=tuple((power.kind, power.path) for power in trajectory.compiled.lowered.powers),
        scenario=trajectory.scenario,
        model=trajectory.compiled.model,
    )
    progress = StoredProgress(
        time=trajectory.memory.time,
        statistics=trajectory.statistics,
        events=trajectory.events,
        outside_tables=trajectory.outside_tables,
        ending=trajectory.ending,
    )
    partial = partial_file(file)
    with partial.open("wb") as stream:
        intervals = trajectory.intervals
        store = RunWriter(stream, header, len(kept), has_extremes=intervals is not None, is_packed=True)
        for times, rows in trajectory.signals.pieces():
            store.signals.add(times, rows[:, kept])
        for times, rows in trajectory.power_integrals.pieces():
            store.integrals.add(times, rows)
        if intervals is not None and store.extremes is not None:
            pairs = [*kept, *(len(trajectory.recorded) + column for column in kept)]
            for times, rows in intervals.pieces():
                store.extremes.add(times, rows[:, pairs])
        store.finish(progress)
    partial.replace(file)


def _columns_of(observables: Iterable[Expr | Path | str], known: Container[Path]) -> tuple[Path, ...]:
    """The columns that observables need: a power is made of effort and flow."""
    found: dict[Path, None] = {}
    for path in map(observable_path, observables):
        if path.name == "power" and path not in known:
            found |= {path.parent / "effort": None, path.parent / "flow": None}
        else:
            found[path] = None
    return tuple(found)


def load_trajectory(file: FileName, *, limits: Limits = LIMITS) -> StoredTrajectory:
    """The run that a file holds, also one that is still being recorded, or whose process was killed.

    Raises:
        DocumentError: the file cannot be read, is no trajectory of this version, or goes beyond a limit.
    """
    run = read_run(file, limits)
    header, rows, progress = run.header, run.rows, run.rows.progress
    return StoredTrajectory(
        model=header.model,
        scenario=header.scenario,
        method=header.method,
        step=header.step,
        jacobian_every=header.jacobian_every,
        tolerance=header.tolerance,
        units={path: unit for path, unit, _ in header.columns},
        ending=run.ending,
        statistics=progress.statistics,
        events=progress.events,
        notes=(*header.notes, *progress.notes),
        outside_tables=progress.outside_tables,
        signals=rows.signals,
        power_integrals=rows.integrals,
        intervals=rows.extremes,
        _entries={path: column for path, _, column in header.columns},
        _width=rows.signals.width,
        _powers={path: index for index, (kind, path) in enumerate(header.powers) if kind != "outside"},
        _power_count=len(header.powers),
    )
