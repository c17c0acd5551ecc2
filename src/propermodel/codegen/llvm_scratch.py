# pyright: basic
"""Rows for values between pieces of a function, and for what loops read and write.

What lives from one piece to another has a row that is lent again as soon as it is free: few rows stay in the fast
cache of the processor, also with several lanes. Loops want their values side by side.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

from propermodel.codegen.llvm_text import Frame
from propermodel.codegen.schedule import Level
from propermodel.expressions.core import Expr


class Life(NamedTuple):
    """The piece that computes a value, and the last that reads it."""

    first: int
    last: int


@dataclass
class Scratch:
    """Rows of a frame that all functions share; a function that calls another keeps its own while that is written."""

    frame: Frame
    _rows: list[int] = field(default_factory=list)
    _taken: int = 0  # by the functions that are being written

    @contextmanager
    def lent(self, lives: Mapping[Expr, Life]) -> Iterator[dict[Expr, int]]:
        """A row for each value, for as long as its function is written."""
        places = _places(lives)
        before = self._taken
        self._taken += max(places.values(), default=-1) + 1
        while len(self._rows) < self._taken:
            self._rows.append(self.frame.new_row())
        yield {node: self._rows[before + place] for node, place in places.items()}
        self._taken = before


def _places(lives: Mapping[Expr, Life]) -> dict[Expr, int]:
    """Small numbers, different for values that are alive in the same piece."""
    found: dict[Expr, int] = {}
    free: list[int] = []
    alive: list[tuple[int, int]] = []  # the last piece that reads a value, and its number
    count = 0
    for node, life in sorted(lives.items(), key=lambda item: item[1].first):
        while alive and alive[0][0] < life.first:
            heapq.heappush(free, heapq.heappop(alive)[1])
        if not free:
            heapq.heappush(free, count)
            count += 1
        found[node] = heapq.heappop(free)
        heapq.heappush(alive, (life.last, found[node]))
    return found


class Packs:
    """Values that change only between runs, or between samples, laid out once in the order in which loops read them."""

    def __init__(self, frame: Frame, levels: Mapping[Expr, Level]) -> None:
        self._frame = frame
        self._levels = levels
        self._first: dict[tuple[Expr, ...], int] = {}

    def has(self, node: Expr) -> bool:
        """Whether a node can be laid out."""
        return self._levels[node] < Level.STEP

    def first_row(self, nodes: tuple[Expr, ...]) -> int:
        """Where the first of these nodes is; the others follow it."""
        first = self._first.get(nodes)
        if first is None:
            first = self._first[nodes] = self._frame.new_row(len(nodes))
        return first

    def rows(self, level: Level) -> Iterator[tuple[int, Expr]]:
        """The rows to be filled as often as this, and with what."""
        for nodes, first in self._first.items():
            if max(self._levels[node] for node in nodes) is level:
                yield from enumerate(nodes, first)


class Streams:
    """Runs of rows for the values of loops; every function has them all for itself."""

    def __init__(self, frame: Frame) -> None:
        self._frame = frame
        self._all: list[tuple[int, int]] = []  # count and first row
        self._free: list[tuple[int, int]] = []

    def begin_function(self) -> None:
        """Forget who has which rows."""
        self._free = sorted(self._all)

    def take(self, count: int) -> int:
        """The first of so many rows."""
        for place, (size, first) in enumerate(self._free):
            if size >= count:
                del self._free[place]
                return first
        first = self._frame.new_row(count)
        self._all.append((count, first))
        return first
