"""Windows of a run, and the activity in them, exact or refused."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, ProperModelError, ReductionError
from propermodel.expressions.units import parse_quantity
from propermodel.simulation.trajectory import Trajectory

Window = tuple[float, float]
Windows = int | str | Iterable[Window]
SAME_INSTANT = 1e-6  # of the period at which integrals are kept
MOST_KEPT = 100_000  # rows of integrals of a run for its windows
MOST_WINDOWS = 10_000


def windows_of(windows: Windows, start: float, stop: float) -> tuple[Window, ...]:
    """The windows between two instants.

    Args:
        windows: How many of equal length; or their length as text (`"10 s"`), of which the last is shorter where it
            does not divide the whole; or pairs of instants, s.
        start: Begin of the whole, s.
        stop: Its end, s.

    Raises:
        ReductionError: they are none, too many, outside the whole, or without length.
    """
    if isinstance(windows, int):
        if not 1 <= windows <= MOST_WINDOWS:
            raise _fault(f"{windows} is no number of windows", f"give a number between 1 and {MOST_WINDOWS}")
        edges = [start + (stop - start) * k / windows for k in range(windows)] + [stop]
    elif isinstance(windows, str):
        edges = _by_length(windows, start, stop)
    else:
        pairs = tuple((float(begin), float(end)) for begin, end in windows)
        if not pairs:
            raise _fault("there are no windows", "give pairs of instants, or leave the windows out")
        for begin, end in pairs:
            if not start <= begin < end <= stop:
                raise _fault(
                    f"{begin:g} to {end:g} s is no window of a run from {start:g} to {stop:g} s",
                    "give begin and end inside the run, the begin first",
                )
        return pairs
    return tuple(pairwise(edges))


def _by_length(text: str, start: float, stop: float) -> list[float]:
    try:
        length = parse_quantity(text, "s")
    except ProperModelError as error:
        raise _fault(
            f"'{text}' is no length of windows: {error.diagnostics[0].message}", "write a time with its unit: 10 s"
        ) from error
    if not length > 0.0 or (stop - start) / length > MOST_WINDOWS:
        raise _fault(
            f"windows of {text} do not divide a run of {stop - start:g} s",
            f"give a positive length that makes at most {MOST_WINDOWS} windows",
        )
    count = math.ceil((stop - start) / length * (1.0 - 1e-12))
    return [*(start + k * length for k in range(count)), stop]


def _fault(message: str, cure: str) -> ReductionError:
    return ReductionError.of("activity/window", message, help=cure)


def period_for(windows: Iterable[Window], start: float, stop: float, longest: float) -> float | None:
    """A period of integrals, at most `longest`, at which every edge of windows has its instant; None: too many rows."""
    step = Fraction(0)
    for edge in (edge for window in windows for edge in window if edge < stop):
        since = Fraction(edge - start).limit_denominator(1_000_000)
        step = Fraction(math.gcd(step.numerator * since.denominator, since.numerator * step.denominator), 1) / (
            step.denominator * since.denominator
        )
    if step == 0:
        return longest
    period = float(step / max(1, math.ceil(float(step) / longest)))
    return period if (stop - start) / period <= MOST_KEPT else None


class KeptIntegrals:
    """The activities of a run between instants at which they are known.

    They are known where they were kept and at the end. Nothing is interpolated: an edge in between is refused.
    """

    def __init__(self, run: Trajectory) -> None:
        self.run = run
        self._times = run.integral_times
        self._columns: dict[Path, FloatArray] = {}

    def between(self, entry: Path, window: Window | None) -> float:
        """The activity of a bond or row in a window, by default the whole run, J.

        Raises:
            ReductionError: an edge is no instant at which integrals are known.
        """
        if window is None:
            return self.run.activity(entry)
        if entry not in self._columns:
            self._columns[entry] = self.run.kept_activity(entry)
        kept = self._columns[entry]
        begin, end = (self.run.activity(entry) if at is None else float(kept[at]) for at in map(self._at, window))
        return end - begin

    def _at(self, time: float) -> int | None:
        """The row of integrals at an instant; None at the end of the run."""
        end = self.run.ending.time
        period = float(np.max(np.diff(self._times))) if len(self._times) > 1 else end - self.run.scenario.start
        near = SAME_INSTANT * period
        if abs(time - end) <= near:
            return None
        row = int(np.argmin(np.abs(self._times - time)))
        if abs(self._times[row] - time) <= near:
            return row
        start = self.run.scenario.start
        fine = period_for([(start, time)], start, end, period)
        cure = "" if fine is None else f": simulate(..., integrals_every={fine:.6g})"
        raise ReductionError.of(
            "activity/coarse",
            f"the activity until {time:g} s is not known: integrals of power were kept every {period:g} s",
            help=f"begin and end windows where they were kept, or keep them more often{cure}",
        )
