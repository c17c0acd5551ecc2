"""Repeated measurements, interleaved, so that a busy machine disturbs all that is compared alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

Json = Any


@dataclass(frozen=True, slots=True)
class Spread:
    """Median and quartiles of repeated measurements."""

    median: float
    low: float
    high: float
    count: int

    def json(self) -> Json:
        """As plain data."""
        return asdict(self)


def spread(values: Iterable[float]) -> Spread:
    """The spread of some values."""
    numbers = np.array(list(values))
    low, middle, high = np.quantile(numbers, (0.25, 0.5, 0.75))
    return Spread(float(middle), float(low), float(high), len(numbers))


def interleaved(tasks: Mapping[str, Callable[[], float]], repeats: int) -> dict[str, list[float]]:
    """What each task measures, in rounds of all tasks; a first round warms up and does not count."""
    for task in tasks.values():
        task()
    found: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(repeats):
        for name, task in tasks.items():
            found[name].append(task())
    return found


def ratios(values: list[float], reference: list[float]) -> Spread:
    """How many times as large the values are as the reference, round by round."""
    return spread(value / other for value, other in zip(values, reference, strict=True))


def cpu_seconds(task: Callable[[], object]) -> float:
    """The processor time of a task, of all its threads."""
    begin = time.process_time()
    task()
    return time.process_time() - begin
