"""Overviews of long columns: least and greatest values of groups of rows, so that no peak is lost in a picture.

A run that keeps extremes has an interval between every two rows: its beginning, and the least and the greatest value
of every column after any step in it. Then groups are made of intervals instead of rows.

A level holds, for each group of 32 rows or intervals of what is below it, the first instant and the least and greatest
value of every column; its own groups make the next level. A column of millions of rows is so drawn from some thousand
pairs. Numbers that are none are passed over, unless a group has no others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.simulation.series import Series

GROUP = 32  # rows


@dataclass(frozen=True, eq=False, slots=True)
class Overview:
    """A column in intervals of time: where each begins, and the least and greatest value in it."""

    time: FloatArray
    least: FloatArray
    greatest: FloatArray


class Sink(Protocol):
    """Where rows go as they come."""

    def add(self, times: FloatArray, rows: FloatArray) -> None:
        """Take over some rows."""
        ...


class OpenLevel(Protocol):
    """Makes the sink of the level of a number, beginning with 1, for rows of a width."""

    def __call__(self, number: int, width: int) -> Sink: ...


class Pyramid:
    """All levels above some rows or intervals, made as these come. Groups that are not full are not kept."""

    def __init__(self, width: int, open_level: OpenLevel) -> None:
        self._width = width
        self._open_level = open_level
        self._levels: list[_Level] = []

    def add(self, times: FloatArray, least: FloatArray, greatest: FloatArray) -> None:
        """Take over some intervals; of a row the least value is the greatest."""
        found = times, least, greatest
        for number in range(1, 100):
            if not len(found[0]):
                return
            if len(self._levels) < number:
                self._levels.append(_Level(self._width, self._open_level(number, 2 * self._width)))
            found = self._levels[number - 1].add(*found)


class _Level:
    """Groups of rows of what is below."""

    def __init__(self, width: int, sink: Sink) -> None:
        self._sink = sink
        empty = np.empty((0, width))
        self._waiting: tuple[FloatArray, FloatArray, FloatArray] = (np.empty(0), empty, empty)

    def add(
        self, times: FloatArray, least: FloatArray, greatest: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Take over rows from below; gives the groups that they fill."""
        times, least, greatest = (
            np.concatenate(pair) for pair in zip(self._waiting, (times, least, greatest), strict=True)
        )
        full = len(times) // GROUP * GROUP
        self._waiting = times[full:], least[full:], greatest[full:]
        groups = (full // GROUP, GROUP, least.shape[1])
        found = (
            times[:full:GROUP],
            np.fmin.reduce(least[:full].reshape(groups), axis=1),
            np.fmax.reduce(greatest[:full].reshape(groups), axis=1),
        )
        if full:
            self._sink.add(found[0], np.concatenate(found[1:], axis=1))
        return found


def make_overview(series: Series, column: int, width: int, start: float, stop: float, points: int) -> Overview:
    """The overview of a column of rows of this width, in about so many intervals of equally many rows."""
    first, last = series.find(start), series.find(stop, is_after=True)
    return _overview(_Column(series, width, column, column), first, last, points)


def overview_of_intervals(
    intervals: Series, column: int, width: int, start: float, stop: float, points: int
) -> Overview:
    """The same from the extremes of this many columns; the interval in which it starts is seen as a whole."""
    first, last = intervals.find(start, is_after=True), intervals.find(stop, is_after=True)
    return _overview(_Column(intervals, width, column, width + column), max(first - 1, 0), last, points)


def extremes_of(intervals: Series, column: int, width: int) -> Overview:
    """The extremes of one of so many columns in every interval."""
    return Overview(intervals.times(), intervals.column(column), intervals.column(width + column))


@dataclass(frozen=True, eq=False, slots=True)
class _Column:
    """A column of rows or intervals, with all levels above it."""

    series: Series
    width: int
    least: int  # its place in the series
    greatest: int

    def pieces(self, first: int, last: int, level: int) -> list[_Piece]:
        """From the first to before the last: whole groups of a level, and what is left from those below."""
        if level == 0:
            return [self._read(self.series, self.least, self.greatest, first, last, 1)]
        groups, size = self.series.levels[level - 1], GROUP**level
        begin = -(-first // size)
        end = min(last // size, len(groups))
        if begin >= end:
            return self.pieces(first, last, level - 1)
        column = self.least
        return [
            *self.pieces(first, begin * size, level - 1),
            self._read(groups, column, self.width + column, begin, end, size),
            *self.pieces(end * size, last, level - 1),
        ]

    @staticmethod
    def _read(series: Series, least: int, greatest: int, first: int, last: int, size: int) -> _Piece:
        low = series.column(least, first, last)
        high = low if greatest == least else series.column(greatest, first, last)
        return np.arange(first * size, last * size, size, dtype=np.float64), series.times(first, last), low, high


_Piece = tuple[FloatArray, FloatArray, FloatArray, FloatArray]  # first row of each group, its instant, least, greatest


def _overview(column: _Column, first: int, last: int, points: int) -> Overview:
    rows = -(-max(last - first, 1) // points)
    level = 0
    while level < len(column.series.levels) and GROUP ** (level + 1) <= rows:
        level += 1
    rows = -(-rows // GROUP**level) * GROUP**level
    pieces = column.pieces(first, last, level)
    begins, times, least, greatest = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    # Intervals begin at whole numbers of groups, where a piece begins, too.
    edges = np.arange(first // rows * rows, last, rows)
    edges[:1] = first
    places = np.searchsorted(begins, edges)
    if not places.size:
        return Overview(times, least, greatest)
    return Overview(times[places], np.fmin.reduceat(least, places), np.fmax.reduceat(greatest, places))
