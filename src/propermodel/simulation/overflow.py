"""Energies of a run that are no longer finite numbers: the run has blown up, though its states still are finite.

Powers are products, so they leave the range of numbers at the square root of the size at which states do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray, Memory


@dataclass(frozen=True, slots=True)
class Overflow:
    """The first instant at which kept integrals of power were no finite numbers, and which entries."""

    time: float
    powers: tuple[int, ...]


def first_overflow(times: FloatArray, integrals: FloatArray, activities: FloatArray) -> Overflow | None:
    """The first of the kept rows (rows x powers) that holds something else than finite numbers."""
    bad = ~(np.isfinite(integrals) & np.isfinite(activities))
    rows = np.flatnonzero(bad.any(axis=1))
    if not rows.size:
        return None
    return Overflow(float(times[rows[0]]), tuple(int(index) for index in np.flatnonzero(bad[rows[0]])))


def overflow_at_end(memory: Memory) -> Overflow | None:
    """What overflowed between the last kept row and where a run of one lane is."""
    return first_overflow(np.array([memory.time]), memory.integral[np.newaxis], memory.activity[np.newaxis])
