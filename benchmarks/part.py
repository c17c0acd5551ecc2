"""What a part of the benchmarks is: it measures plain data, and writes them down in words, tables and pictures."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.measure import Json

COMMAND = "python -m benchmarks"


@dataclass(frozen=True, slots=True)
class Part:
    """A part; `measure` takes whether it is to be quick, `pages` the data and the folder of pictures."""

    letter: str
    title: str
    measure: Callable[[bool], Json]
    write: Callable[[Json, Path], list[str]]


def paragraph(*lines: str) -> str:
    """A paragraph, its lines filled."""
    return "\n".join(textwrap.wrap(" ".join(lines), 120, break_long_words=False, break_on_hyphens=False))


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers_from: int = 1) -> list[str]:
    """A table in Markdown; columns from a number on are set to the right."""
    marks = ["---:" if i >= numbers_from else "---" for i in range(len(head))]
    return ["", *(f"| {' | '.join(row)} |" for row in (head, marks, *rows)), ""]


def shown(data: Json, factor: float = 1.0, digits: int = 3) -> str:
    """A spread as text: the median, and the quartiles in brackets."""
    median, low, high = (rounded(factor * data[key], digits) for key in ("median", "low", "high"))
    return f"{median} ({low} to {high})"


def rounded(value: float, digits: int = 3) -> str:
    """A number with so many digits, never as a power of ten."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text else text
