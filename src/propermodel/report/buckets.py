"""Columns for pictures: least and greatest value of every interval, so that no peak is lost."""

from __future__ import annotations

import base64

import numpy as np

from propermodel.codegen.machine import FloatArray, IntArray


class Intervals:
    """Intervals between edges, and the rows of a time axis that lie in each; rows at an edge lie in both."""

    def __init__(self, time: FloatArray, edges: FloatArray) -> None:
        self._time = time
        self._edges = edges
        firsts = np.searchsorted(time, edges[:-1])
        lasts = np.searchsorted(time, edges[1:], side="right")
        self._filled = np.flatnonzero(lasts > firsts)
        starts, ends = firsts[self._filled], lasts[self._filled]
        # The rows of all intervals one after the other: those at an edge stand there twice.
        lengths = ends - starts
        self._begins = np.cumsum(lengths) - lengths
        self._rows = np.arange(int(lengths.sum())) + np.repeat(starts - self._begins, lengths)
        self._groups = np.repeat(np.arange(len(lengths)), lengths)

    def extremes(self, values: FloatArray, greatest: FloatArray | None = None) -> FloatArray:
        """Two values for each interval, in the order in which they come: its least and its greatest.

        An interval without a row has the interpolated values at its edges, and no values beyond the ends of the axis.
        Numbers that are none are passed over, unless an interval has no others.

        Args:
            values: One for each row; or its least value, where a row stands for several.
            greatest: Then its greatest value.
        """
        found = np.full((len(self._edges) - 1, 2), np.nan)
        if not len(self._time):
            return found.ravel()
        edges = np.interp(self._edges, self._time, values, left=np.nan, right=np.nan)
        found[:, 0], found[:, 1] = edges[:-1], edges[1:]
        if len(self._filled):
            rows = values[self._rows]
            least, first_least = self._reduced(rows, np.fmin)
            most, first_most = self._reduced(rows if greatest is None else greatest[self._rows], np.fmax)
            pairs = np.column_stack([least, most])
            is_first = (first_least <= first_most)[:, np.newaxis]
            found[self._filled] = np.where(is_first, pairs, pairs[:, ::-1])
        return found.ravel()

    def _reduced(self, rows: FloatArray, choose: np.ufunc) -> tuple[FloatArray, IntArray]:
        """The value that is chosen in every interval with a row, and the place of the first row that has it."""
        chosen = choose.reduceat(rows, self._begins)
        places = np.append(np.flatnonzero(rows == chosen[self._groups]), len(rows))
        return chosen, places[np.searchsorted(places, self._begins)]


def extremes(time: FloatArray, values: FloatArray, edges: FloatArray) -> FloatArray:
    """Two values for each interval between edges; see `Intervals.extremes`."""
    return Intervals(time, edges).extremes(values)


def packed(values: FloatArray) -> str:
    """Values as base64 of little-endian float32; what is no finite number becomes NaN, a gap."""
    with np.errstate(over="ignore"):
        narrow = np.asarray(values, dtype="<f4")
    narrow[~np.isfinite(narrow)] = np.nan
    return base64.b64encode(narrow.tobytes()).decode("ascii")


def exactly_packed(values: FloatArray) -> str:
    """Values as base64 of little-endian float64."""
    return base64.b64encode(np.asarray(values, dtype="<f8").tobytes()).decode("ascii")
