# pyright: basic
"""Rows for values that live from one piece of a function to another, lent again as soon as they are free.

Few rows stay in the fast cache of the processor, also with several lanes.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

from propermodel.codegen.llvm_text import Frame
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
