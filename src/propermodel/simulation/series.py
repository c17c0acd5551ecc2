"""Rows of numbers over time, in memory or in a file; rows of one kind, one after the other, are a series."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Protocol

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import DocumentError
from propermodel.modelling.files import FileName, of_file, open_file
from propermodel.simulation.archives import Member, read_array, read_column

_PIECE = 2**17  # numbers


class Series(Protocol):
    """Rows over times that never decrease; `first` and `last` bound rows as slices do."""

    def __len__(self) -> int: ...

    @property
    def levels(self) -> tuple[Series, ...]:
        """Least and greatest values of ever longer groups of rows, as `overview.py` describes; may be none."""
        ...

    def times(self, first: int = 0, last: int | None = None) -> FloatArray:
        """The instants of rows."""
        ...

    def column(self, index: int, first: int = 0, last: int | None = None) -> FloatArray:
        """The numbers of one column."""
        ...

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Times and rows, some at a time, so that a long series need not be held as a whole."""
        ...

    def values(self) -> FloatArray:
        """All rows."""
        ...

    def find(self, time: float, *, is_after: bool = False) -> int:
        """The number of rows before an instant, those at it included if `is_after`."""
        ...


@dataclass(frozen=True, eq=False)
class ArraySeries:
    """A series in memory."""

    instants: FloatArray
    rows: FloatArray
    levels: tuple[Series, ...] = ()

    def __len__(self) -> int:
        return len(self.instants)

    def times(self, first: int = 0, last: int | None = None) -> FloatArray:
        """The instants of rows."""
        return self.instants[first:last]

    def column(self, index: int, first: int = 0, last: int | None = None) -> FloatArray:
        """The numbers of one column."""
        return self.rows[first:last, index]

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Times and rows, some at a time."""
        count = max(1, _PIECE // max(1, self.rows.shape[1]))
        for first in range(0, len(self), count):
            yield self.instants[first : first + count], self.rows[first : first + count]

    def values(self) -> FloatArray:
        """All rows."""
        return self.rows

    def find(self, time: float, *, is_after: bool = False) -> int:
        """The number of rows before an instant, those at it included if `is_after`."""
        return int(np.searchsorted(self.instants, time, "right" if is_after else "left"))


@dataclass(frozen=True, eq=False)
class FileSeries:
    """A series in an archive: matrices one after the other, whose first column is the time. Nothing of it is held."""

    file: FileName
    members: tuple[Member, ...]
    width: int  # columns without the time
    levels: tuple[Series, ...] = ()
    _starts: tuple[int, ...] = field(init=False, repr=False)  # the first row of each member, and the number of all

    def __post_init__(self) -> None:
        starts = tuple(accumulate((member.shape[0] for member in self.members), initial=0))
        object.__setattr__(self, "_starts", starts)

    def __len__(self) -> int:
        return self._starts[-1]

    def times(self, first: int = 0, last: int | None = None) -> FloatArray:
        """The instants of rows."""
        return self._read(0, first, last)

    def column(self, index: int, first: int = 0, last: int | None = None) -> FloatArray:
        """The numbers of one column."""
        return self._read(1 + index, first, last)

    def _read(self, index: int, first: int, last: int | None) -> FloatArray:
        last = len(self) if last is None else min(last, len(self))
        if first >= last:
            return np.empty(0)
        begin, end = self._holder(first), self._holder(last - 1) + 1
        found = np.empty(last - first)
        with self._about_file(), open_file(self.file) as stream:
            for member, start in zip(self.members[begin:end], self._starts[begin:end], strict=True):
                here = max(first, start), min(last, start + member.shape[0])
                column = read_column(stream, member, index, here[0] - start, here[1] - start)
                found[here[0] - first : here[1] - first] = column
        return found

    def _holder(self, row: int) -> int:
        """The member that holds a row."""
        return bisect_right(self._starts, row) - 1

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Times and rows, some at a time."""
        with self._about_file(), open_file(self.file) as stream:
            for member in self.members:
                matrix = read_array(stream, member)
                yield matrix[:, 0], matrix[:, 1:]

    def values(self) -> FloatArray:
        """All rows."""
        found = np.empty((len(self), self.width))
        done = 0
        for times, rows in self.pieces():
            found[done : done + len(times)] = rows
            done += len(times)
        return found

    def find(self, time: float, *, is_after: bool = False) -> int:
        """The number of rows before an instant, those at it included if `is_after`."""
        low, high = 0, len(self.members)  # members before the low one end before the instant
        while low < high:
            middle = (low + high) // 2
            end = self.times(self._starts[middle + 1] - 1, self._starts[middle + 1])[0]
            if end < time or (is_after and end == time):
                low = middle + 1
            else:
                high = middle
        if low == len(self.members):
            return len(self)
        times = self.times(self._starts[low], self._starts[low + 1])
        return self._starts[low] + int(np.searchsorted(times, time, "right" if is_after else "left"))

    def _about_file(self) -> _AboutFile:
        return _AboutFile(self.file)


@dataclass(frozen=True, slots=True)
class _AboutFile:
    """Says of which file an error is."""

    file: FileName

    def __enter__(self) -> None:
        return None

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, DocumentError):
            raise of_file(error, self.file) from error
