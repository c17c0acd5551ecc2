"""Writes the file of a run, at once or while the run goes on.

Its parts are members of an archive: `header`, what is known at the start; `signals/0`, `signals/1`, ... and
`integrals/0`, ..., matrices whose first column is the time; `signals.1/0`, ..., the levels of overviews; `progress/0`,
..., how far the run has come, with the events since the one before. Where extremes are kept, `extremes/0`, ... hold the
beginnings of the intervals between rows, and the least and then the greatest value of every signal; the levels of
overviews are then made of these, `extremes.1/0`, .... What stands before a `progress` belongs together.
Full matrices are written as they come, and all rows every two seconds, so what a killed process leaves is nearly all.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import replace
from typing import BinaryIO

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.modelling.documents import SharedEntries
from propermodel.simulation.archive_writer import ArchiveWriter
from propermodel.simulation.overview import Pyramid, Sink
from propermodel.simulation.trajectory_format import FORMAT, HEADER, PROGRESS, VERSION, Header, StoredProgress

CHUNK_BYTES = 4 * 2**20
WRITTEN_EVERY_S = 2.0


class RunWriter:
    """A run in a file that grows, with overviews of its signals.

    Raises:
        OSError: something cannot be written.
    """

    def __init__(
        self, stream: BinaryIO, header: Header, columns: int, *, has_extremes: bool = False, is_packed: bool = False
    ) -> None:
        self._archive = ArchiveWriter(stream, is_packed=is_packed)
        self._sinks: list[_FileRows] = []
        rows = self._open("signals", columns)
        integrals = self._open("integrals", 2 * len(header.powers))
        self.integrals: Sink = integrals
        self._series = [rows, integrals]
        self.signals: Sink = rows
        self.extremes: Sink | None = None
        base = "extremes" if has_extremes else "signals"
        pyramid = Pyramid(columns, lambda number, width: self._open(f"{base}.{number}", width))
        if has_extremes:
            extremes = self._open(base, 2 * columns)
            self._series.append(extremes)
            self.extremes = _IntervalsWithOverview(extremes, pyramid, columns)
        else:
            self.signals = _WithOverview(rows, pyramid)
        self._has_news = False  # rows that no report follows
        self._reports = 0
        self._reported_at = time.perf_counter()
        self._events = 0  # that were reported
        document = {"format": FORMAT, "version": VERSION, **HEADER.write(header, SharedEntries())}
        self._write_json("header", document)

    def _open(self, name: str, width: int) -> _FileRows:
        sink = _FileRows(self._write_rows, name, width)
        self._sinks.append(sink)
        return sink

    def _write_rows(self, name: str, rows: FloatArray) -> None:
        self._archive.add(name, rows)
        self._has_news = True

    def _write_json(self, name: str, document: object) -> None:
        text = json.dumps(document, allow_nan=False).encode()
        self._archive.add(name, np.frombuffer(text, dtype=np.uint8))

    def report_often(self, progress: Callable[[], StoredProgress]) -> None:
        """Say how far the run has come where rows were written since the last time, or after a while."""
        if time.perf_counter() - self._reported_at >= WRITTEN_EVERY_S:
            for rows in self._series:
                rows.write()
        if self._has_news:
            self._report(progress())

    def finish(self, progress: StoredProgress) -> None:
        """Write what is left, and how the run ended."""
        for rows in self._sinks:
            rows.write()
        self._report(progress)
        self._archive.finish()

    def _report(self, progress: StoredProgress) -> None:
        news = replace(progress, events=progress.events[self._events :])
        self._write_json(f"progress/{self._reports}", PROGRESS.write(news, SharedEntries()))
        self._reports += 1
        self._reported_at = time.perf_counter()
        self._events = len(progress.events)
        self._has_news = False


class _FileRows:
    """Rows on their way into a file: a matrix at a time, its first column the time."""

    def __init__(self, write: Callable[[str, FloatArray], None], name: str, width: int) -> None:
        self._write = write
        self._name = name
        self._number = 0
        self._waiting: FloatArray = np.empty((max(1, CHUNK_BYTES // (8 * (1 + width))), 1 + width), order="F")
        self._count = 0

    def add(self, times: FloatArray, rows: FloatArray) -> None:
        """Take over some rows."""
        done = 0
        while done < len(times):
            n = min(len(times) - done, len(self._waiting) - self._count)
            here = slice(self._count, self._count + n)
            self._waiting[here, 0] = times[done : done + n]
            self._waiting[here, 1:] = rows[done : done + n]
            self._count += n
            done += n
            if self._count == len(self._waiting):
                self.write()

    def write(self) -> None:
        """Write the rows that wait."""
        if self._count:
            self._write(f"{self._name}/{self._number}", self._waiting[: self._count])
            self._number += 1
            self._count = 0


class _WithOverview:
    """Rows that go into a file and into overviews."""

    def __init__(self, rows: _FileRows, pyramid: Pyramid) -> None:
        self._rows = rows
        self._pyramid = pyramid

    def add(self, times: FloatArray, rows: FloatArray) -> None:
        """Take over some rows."""
        self._rows.add(times, rows)
        self._pyramid.add(times, rows, rows)


class _IntervalsWithOverview:
    """Intervals that go into a file and into overviews."""

    def __init__(self, rows: _FileRows, pyramid: Pyramid, columns: int) -> None:
        self._rows = rows
        self._pyramid = pyramid
        self._columns = columns

    def add(self, times: FloatArray, rows: FloatArray) -> None:
        """Take over some intervals."""
        self._rows.add(times, rows)
        self._pyramid.add(times, rows[:, : self._columns], rows[:, self._columns :])
