"""What a run records as it goes on: rows of signals and integrals of power, kept in memory or written to a file."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from propermodel.codegen.machine import FloatArray, IntArray, Memory, Outcome
from propermodel.diagnostics import SimulationError
from propermodel.modelling.files import FileName
from propermodel.modelling.limits import Limits
from propermodel.simulation.intervals import Intervals
from propermodel.simulation.overflow import Overflow, first_overflow
from propermodel.simulation.overview import Sink
from propermodel.simulation.run_file import read_run
from propermodel.simulation.run_writer import RunWriter
from propermodel.simulation.series import ArraySeries, Series
from propermodel.simulation.trajectory import Ending, RunStatus
from propermodel.simulation.trajectory_format import Header, StoredProgress

_OWN = Limits(file_bytes=2**62, trajectory_parts=2**62, values=2**62)  # of a file that this process has written


class RecordingStopped(Exception):
    """No more can be recorded: why."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """What was recorded, and how the run ended."""

    signals: Series
    integrals: Series
    extremes: Series | None  # of the signals between two rows, as `overview.py` describes
    ending: Ending


class Store(Protocol):
    """Where the rows of a run go."""

    @property
    def signals(self) -> Sink:
        """Rows of the recorded signals."""
        ...

    @property
    def integrals(self) -> Sink:
        """Rows of the integrals of power and then of its absolute value."""
        ...

    @property
    def extremes(self) -> Sink | None:
        """Intervals between rows: where each begins, the least and then the greatest values; none if not asked for."""
        ...

    def report_often(self, progress: Callable[[], StoredProgress]) -> None:
        """Note how far the run has come, now and then."""
        ...

    def finish(self, progress: StoredProgress) -> None:
        """Note how the run ended."""
        ...

    def series(self) -> tuple[Series, Series, Series | None]:
        """The signals, integrals and extremes that were kept."""
        ...


class Recording:
    """The rows of one run on their way into a store.

    Raises:
        RecordingStopped: no more can be written.
    """

    def __init__(self, store: Store, selected: IntArray, memory: Memory) -> None:
        self._store = store
        self._selected = selected
        self._intervals = None if store.extremes is None else Intervals(store.extremes, memory)
        self._last_integrals = -np.inf
        self.is_stopped = False
        self.overflow: Overflow | None = None  # the first integrals that were no finite numbers
        self.before = memory.copy()  # the run before the last call, whose numbers were finite

    def keep_signals(self, time: float, signals: FloatArray) -> None:
        """Add a row at an instant of the run's own."""
        with self._writing():
            row = signals[self._selected]
            self._store.signals.add(np.array([time]), row[np.newaxis])
            if self._intervals is not None:
                self._intervals.close_at(time, row)

    def keep(self, outcome: Outcome, progress: Callable[[], StoredProgress]) -> None:
        """Take over what one call recorded, and how far the run has come."""
        with self._writing():
            self._store.signals.add(outcome.row_times, outcome.rows)
            if self._intervals is not None:
                self._intervals.add(outcome.row_times, outcome.least, outcome.greatest)
            self._keep_integrals(outcome.integral_times, outcome.integrals, outcome.activities)
            self._store.report_often(progress)
        if self.overflow is None:
            self.overflow = first_overflow(outcome.integral_times, outcome.integrals, outcome.activities)

    def _keep_integrals(self, times: FloatArray, integrals: FloatArray, activities: FloatArray) -> None:
        if len(times):
            self._store.integrals.add(times, np.concatenate((integrals, activities), axis=1))
            self._last_integrals = float(times[-1])

    def finish(self, progress: StoredProgress, ending: Ending, last: Memory | None = None) -> Recorded:
        """Keep how the run ended, with its last integrals where they are not yet kept; gives all that was kept."""
        if not self.is_stopped:
            try:
                with self._writing():
                    if self._intervals is not None:
                        self._intervals.finish()
                    if last is not None and self._last_integrals < last.time:
                        self._keep_integrals(
                            np.array([last.time]), last.integral[np.newaxis], last.activity[np.newaxis]
                        )
                    self._store.finish(replace(progress, ending=ending))
            except RecordingStopped as error:
                ending = stopped_ending(error, progress.time)
        return Recorded(*self._store.series(), ending)

    @contextmanager
    def _writing(self) -> Generator[None]:
        try:
            yield
        except OSError as error:
            self.is_stopped = True
            raise RecordingStopped(error.strerror or str(error)) from error


def stopped_ending(error: RecordingStopped, time: float) -> Ending:
    """The ending of a run of which no more can be recorded."""
    return Ending(RunStatus.FAILED, f"stopped at {time:.6g} s: it could not be recorded further: {error}", time)


# -- in memory ---------------------------------------------------------------------------------------------


class MemoryStore:
    """Rows kept in memory, with room for those that are expected; it grows where events add some."""

    def __init__(
        self,
        span: float,
        row_period: float,
        columns: int,
        integral_period: float,
        powers: int,
        *,
        has_extremes: bool = False,
    ) -> None:
        room = int(span / row_period) + 3
        self._signals = _Rows(room, columns)
        self._integrals = _Rows(int(span / integral_period) + 3, 2 * powers)
        self._extremes = _Rows(room, 2 * columns) if has_extremes else None
        self.signals: Sink = self._signals
        self.integrals: Sink = self._integrals
        self.extremes: Sink | None = self._extremes

    def report_often(self, progress: Callable[[], StoredProgress]) -> None:
        """Nobody asks while the run goes on."""

    def finish(self, progress: StoredProgress) -> None:
        """The run itself tells."""

    def series(self) -> tuple[Series, Series, Series | None]:
        """The signals, integrals and extremes that were kept."""
        extremes = None if self._extremes is None else self._extremes.series()
        return self._signals.series(), self._integrals.series(), extremes


class _Rows:
    """Rows in memory."""

    def __init__(self, room: int, width: int) -> None:
        self._times: FloatArray = np.empty(room)
        self._rows: FloatArray = np.empty((room, width))
        self._count = 0

    def add(self, times: FloatArray, rows: FloatArray) -> None:
        """Take over some rows."""
        end = self._count + len(times)
        if end > len(self._times):
            bigger = np.empty(2 * end), np.empty((2 * end, self._rows.shape[1]))
            bigger[0][: self._count], bigger[1][: self._count] = self._times[: self._count], self._rows[: self._count]
            self._times, self._rows = bigger
        self._times[self._count : end] = times
        self._rows[self._count : end] = rows
        self._count = end

    def series(self) -> ArraySeries:
        """What was kept."""
        return ArraySeries(self._times[: self._count], self._rows[: self._count])


# -- in a file ---------------------------------------------------------------------------------------------


class FileStore:
    """Rows written to a file as they come."""

    def __init__(
        self, file: FileName, header: Header, columns: int, files: ExitStack, *, has_extremes: bool = False
    ) -> None:
        self._file = file
        self._header = header
        try:
            stream = files.enter_context(open(file, "wb"))  # noqa: PTH123, SIM115
            self._writer = RunWriter(stream, header, columns, has_extremes=has_extremes)
        except OSError as error:
            raise SimulationError.of(
                "simulation/record-to",
                f"the run cannot be recorded to '{file}': {error.strerror or error}",
                help="name a file in a folder that exists and may be written to",
            ) from error
        self.signals: Sink = self._writer.signals
        self.integrals: Sink = self._writer.integrals
        self.extremes: Sink | None = self._writer.extremes

    def report_often(self, progress: Callable[[], StoredProgress]) -> None:
        """Note how far the run has come where rows were written, or after a while."""
        self._writer.report_often(progress)

    def finish(self, progress: StoredProgress) -> None:
        """Write what is left, and how the run ended."""
        self._writer.finish(progress)

    def series(self) -> tuple[Series, Series, Series | None]:
        """The signals, integrals and extremes that are in the file."""
        rows = read_run(self._file, _OWN, self._header).rows
        return rows.signals, rows.integrals, rows.extremes
