"""The intervals between the rows of a run, with the least and greatest values of every recorded signal in each."""

from __future__ import annotations

import numpy as np

from propermodel.codegen.machine import FloatArray, Memory
from propermodel.simulation.overview import Sink


class Intervals:
    """Intervals on their way into a sink. What the one that is still open holds is in the memory of the run."""

    def __init__(self, sink: Sink, memory: Memory) -> None:
        self._sink = sink
        self._memory = memory
        self._begin = memory.time
        self._is_first = True

    def add(self, ends: FloatArray, least: FloatArray, greatest: FloatArray) -> None:
        """Take over intervals that end with these rows."""
        if not len(ends):
            return
        begins = np.concatenate(([self._begin], ends[:-1]))
        # Where the run begins with a row, this row opens the first interval.
        skipped = 1 if self._is_first and ends[0] == self._begin else 0
        # Nothing but numbers that are none was seen where the least is still beyond the greatest.
        rows = np.concatenate([np.where(least > greatest, np.nan, side) for side in (least, greatest)], axis=1)
        self._sink.add(begins[skipped:], rows[skipped:])
        self._begin = float(ends[-1])
        self._is_first = False

    def close_at(self, time: float, row: FloatArray) -> None:
        """End the open interval with a row at an instant of the run's own, with which the next one begins."""
        memory = self._memory
        is_open = memory.least.shape == row.shape
        least, greatest = (memory.least, memory.greatest) if is_open else (np.inf, -np.inf)
        found = np.fmin(least, row), np.fmax(greatest, row)
        self.add(np.array([time]), found[0][np.newaxis], found[1][np.newaxis])
        is_number = ~np.isnan(row)
        memory.least = np.where(is_number, row, np.inf)
        memory.greatest = np.where(is_number, row, -np.inf)

    def finish(self) -> None:
        """End the open interval where the run ends."""
        memory = self._memory
        if memory.time > self._begin and memory.least.size:
            self.add(np.array([memory.time]), memory.least[np.newaxis], memory.greatest[np.newaxis])
