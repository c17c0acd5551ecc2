"""Columns of runs for plots, also of runs that are still recorded: read once, then kept up with the file."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, one_of
from propermodel.modelling.limits import LIMITS
from propermodel.report.buckets import Intervals
from propermodel.simulation.display_units import display_for
from propermodel.simulation.overview import make_overview
from propermodel.simulation.run_file import RunRows, read_rows
from propermodel.simulation.series import FileSeries
from propermodel.studio.faults import StudioError

Json = Any

MOST_BYTES = 400 * 2**20  # of columns of all runs
MOST_ROWS = 300_000  # of a column that is kept; of longer ones what is asked for is read
_ROWS_EACH = 32  # in an interval of a column that is not kept, from which on its overview is read instead
_POINTS = 2  # of an overview for each interval: a group that lies in two intervals counts in the first
_POWER = "power"


@dataclass
class RecordedRun:
    """One run; its columns are those of the file when it was last looked at."""

    file: FilePath
    rows: RunRows
    stamp: tuple[int, int]
    entries: dict[Path, tuple[str, int]]
    kept: OrderedDict[int, FloatArray] = field(default_factory=OrderedDict[int, FloatArray])  # -1: the time

    @property
    def start(self) -> float:
        """When the run begins, s."""
        return self.rows.contents.start

    @property
    def end(self) -> float:
        """How far the run has come, s."""
        time = self.rows.progress.time
        return time if math.isfinite(time) else self.start

    def signals(self) -> Json:
        """Every recorded observable with its unit and the unit that readers are used to."""
        found: list[Json] = []
        sizes = self._sizes()
        for path, (unit, column) in self.entries.items():
            display = display_for(unit, sizes[column])
            shown = {"unit": display.unit, "factor": display.factor}
            found.append({"path": str(path), "unit": unit, "display": shown})
        return found

    def __getitem__(self, observable: Path, /) -> FloatArray:
        """All rows of an observable.

        Raises:
            StudioError: there is no such observable.
        """
        return self._values(observable, 0, len(self.rows.signals))

    @property
    def time(self) -> FloatArray:
        """The instants of all rows, s."""
        return self._column(-1, 0, len(self.rows.signals))

    def unit(self, observable: Path, /) -> str:
        """The unit of an observable.

        Raises:
            StudioError: there is no such observable.
        """
        if observable in self.entries:
            return self.entries[observable][0]
        self._factors(observable)
        return "W"

    def extremes(self, paths: list[Path], start: float, stop: float, count: int) -> tuple[FloatArray, list[FloatArray]]:
        """Instants (edge and middle of each interval in turn), and for each observable two values an interval.

        Raises:
            StudioError: there is no such observable.
        """
        edges = np.linspace(start, stop, count + 1)
        times = np.column_stack([edges[:-1], 0.5 * (edges[:-1] + edges[1:])]).ravel()
        first, last = self._window(start, stop)
        if len(self.rows.signals) > MOST_ROWS and last - first > _ROWS_EACH * count:
            return times, [self._from_overview(path, edges, first, last) for path in paths]
        intervals = Intervals(self._column(-1, first, last), edges)
        return times, [intervals.extremes(self._values(path, first, last)) for path in paths]

    def nearest(self, paths: list[Path], time: float) -> tuple[float, list[float]]:
        """The recorded instant nearest to a time, and the values there.

        Raises:
            StudioError: there is no such observable, or no row.
        """
        count = len(self.rows.signals)
        if not count:
            raise StudioError.with_status(409, "studio/no-rows", "nothing is recorded yet", help="ask again later")
        after = min(self.rows.signals.find(time), count - 1)
        row = after
        if after > 0:
            before, behind = self._column(-1, after - 1, after + 1).tolist()
            row = after - 1 if time - before < behind - time else after
        at = float(self._column(-1, row, row + 1)[0])
        return at, [float(self._values(path, row, row + 1)[0]) for path in paths]

    def columns(self, paths: list[Path], first: int, last: int) -> list[FloatArray]:
        """The time and some observables between two rows."""
        return [self._column(-1, first, last), *(self._values(path, first, last) for path in paths)]

    def check(self, paths: list[Path]) -> None:
        """Refuse what was not recorded.

        Raises:
            StudioError: there is no such observable.
        """
        for path in paths:
            self._factors(path)

    # -- columns -------------------------------------------------------------------------------------------

    def _window(self, start: float, stop: float) -> tuple[int, int]:
        """The rows in a window, and one more on each side to interpolate from."""
        series = self.rows.signals
        if not len(series):
            return 0, 0
        return max(0, series.find(start) - 1), min(len(series), series.find(stop, is_after=True) + 1)

    def _values(self, path: Path, first: int, last: int) -> FloatArray:
        factors = [self._column(column, first, last) for column in self._factors(path)]
        return factors[0] if len(factors) == 1 else factors[0] * factors[1]

    def _factors(self, path: Path) -> tuple[int, ...]:
        """The columns whose product an observable is: its own, or effort and flow of a power."""
        if path in self.entries:
            return (self.entries[path][1],)
        pair = [path.parent / "effort", path.parent / "flow"]
        if path.name == _POWER and all(item in self.entries for item in pair):
            return tuple(self.entries[item][1] for item in pair)
        raise StudioError.with_status(
            404,
            "studio/signal",
            f"the run has no signal '{str(path)[:200]}'",
            help=one_of(str(path)[:200], map(str, self.entries)),
        )

    def _column(self, column: int, first: int, last: int) -> FloatArray:
        """Some rows of a column; one that is not too long is kept, and only what is new of it is read."""
        series = self.rows.signals
        if len(series) > MOST_ROWS:
            return series.times(first, last) if column < 0 else series.column(column, first, last)
        kept = self.kept.pop(column, np.empty(0))
        if len(kept) < len(series):
            begin = len(kept)
            new = series.times(begin) if column < 0 else series.column(column, begin)
            kept = np.concatenate([kept, new])
        self.kept[column] = kept
        return kept[first:last]

    def _from_overview(self, path: Path, edges: FloatArray, first: int, last: int) -> FloatArray:
        column, *others = self._factors(path)
        if others:
            return Intervals(self._column(-1, first, last), edges).extremes(self._values(path, first, last))
        series = self.rows.signals
        begin, end = series.times(first, first + 1).item(), series.times(last - 1, last).item()
        seen = make_overview(series, column, series.width, begin, end, _POINTS * (len(edges) - 1))
        # The first group begins with the row before the window, and counts in it.
        return Intervals(np.maximum(seen.time, edges[0]), edges).extremes(seen.least, seen.greatest)

    def _sizes(self) -> FloatArray:
        """The greatest magnitude of every column, from a few rows of it where it is long."""
        series = self.rows.signals
        sizes = np.zeros(series.width)
        level: FileSeries = series
        for upper in series.levels:
            if isinstance(upper, FileSeries) and len(upper):
                level = upper
        for _, rows in level.pieces():
            magnitudes = np.fmax.reduce(np.abs(rows), axis=0, initial=0.0)
            if level is not series:
                magnitudes = np.fmax(magnitudes[: series.width], magnitudes[series.width :])
            sizes = np.fmax(sizes, magnitudes)
        return sizes


class RecordedRuns:
    """Runs that somebody looks at; those that nobody has looked at for longest are forgotten."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._runs: OrderedDict[FilePath, RecordedRun] = OrderedDict()
        self.lock = threading.Lock()  # held by who uses a run: columns are read in threads of the server

    def get(self, file: FilePath) -> RecordedRun:
        """The run in a file, as it is now.

        Raises:
            StudioError: nothing is recorded yet.
            DocumentError: the file is not what a run records.
        """
        try:
            status = file.stat()
        except OSError:
            raise StudioError.with_status(
                409, "studio/no-rows", "nothing is recorded yet", help="ask again when the run has begun"
            ) from None
        stamp = (status.st_mtime_ns, status.st_size)
        known = self._runs.pop(file, None)
        if known is None or known.stamp[1] > stamp[1]:  # a file that has shrunk is another one
            rows = read_rows(file, LIMITS)
            known = RecordedRun(file, rows, stamp, {path: (u, column) for path, u, column in rows.contents.columns})
        elif known.stamp != stamp:
            known.rows, known.stamp = read_rows(file, LIMITS, known.rows.contents), stamp
        self._runs[file] = known
        self._forget()
        return known

    def drop(self, file: FilePath) -> None:
        """Forget a run that is deleted."""
        self._runs.pop(file, None)

    def _forget(self) -> None:
        used = sum(column.nbytes for run in self._runs.values() for column in run.kept.values())
        for run in list(self._runs.values()):
            while used > self._most_bytes and run.kept:
                used -= run.kept.popitem(last=False)[1].nbytes


def packed_series(times: FloatArray, columns: list[FloatArray]) -> bytes:
    """Instants as 8-byte numbers, then columns as 4-byte ones, little-endian; what is no finite number is NaN."""
    parts = [np.asarray(times, dtype="<f8").tobytes()]
    with np.errstate(over="ignore", invalid="ignore"):
        for column in columns:
            narrow = np.asarray(column, dtype="<f4")
            narrow[~np.isfinite(narrow)] = np.nan
            parts.append(narrow.tobytes())
    return b"".join(parts)
