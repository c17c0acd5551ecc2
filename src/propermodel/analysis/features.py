"""Features of one signal that engineers compare: its end, its peak, how fast it rises, and when it settles.

A feature that a signal does not have is `Undefined`, with the reason, never a number that means something else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray

RISE_FROM, RISE_TO = 0.1, 0.9  # of the way from the first to the last value
LEAST_RISE = 0.1  # of the range, between first and last value
BAND = 0.02  # of the range, to both sides of the last value
REST = 0.1  # of the window, at least, in which a settled signal stays in the band


@dataclass(frozen=True, slots=True)
class Undefined:
    """A feature that a signal does not have, and why."""

    why: str

    def __str__(self) -> str:
        return f"undefined: {self.why}"


@dataclass(frozen=True, slots=True)
class Peak:
    """The value furthest from where a signal begins, and how long after the beginning it has it, s."""

    value: float
    after: float


@dataclass(frozen=True, slots=True)
class SignalFeatures:
    """The features of one signal.

    `rise` is the time from 10 % to 90 % of the way from the first to the last value, each reached for the first time;
    `settling` the time from the beginning until the signal stays within 2 % of its range about its last value.
    """

    final: float
    peak: Peak | Undefined
    rise: float | Undefined
    settling: float | Undefined


def signal_features(
    time: FloatArray, values: FloatArray, span: float | None = None, side: float = 0.0
) -> SignalFeatures:
    """The features of a signal.

    Args:
        time: Instants, s, not falling.
        values: The signal there; linear in between.
        span: The range that shares refer to; by default its own. Signals that are compared share one.
        side: Where to look for the peak: above the first value (positive), below (negative), or on both sides (0).
    """
    span = float(np.ptp(values)) if span is None else span
    return SignalFeatures(
        final=float(values[-1]),
        peak=_peak(time, values, side),
        rise=_rise(time, values, span),
        settling=_settling(time, values, span),
    )


def _peak(time: FloatArray, values: FloatArray, side: float) -> Peak | Undefined:
    away = values - values[0]
    at = int(np.argmax(np.abs(away) if side == 0.0 else away * np.sign(side)))
    if away[at] == 0.0:
        return Undefined("it never leaves its first value" + ("" if side == 0.0 else " to that side"))
    return Peak(float(values[at]), float(time[at] - time[0]))


def _rise(time: FloatArray, values: FloatArray, span: float) -> float | Undefined:
    way = float(values[-1] - values[0])
    if abs(way) <= LEAST_RISE * span:
        return Undefined("it ends about where it begins, so it does not rise or fall")
    share = (values - values[0]) / way
    duration = _first_reaching(time, share, RISE_TO) - _first_reaching(time, share, RISE_FROM)
    return duration if duration > 0.0 else Undefined("it jumps, in no time")


def _first_reaching(time: FloatArray, share: FloatArray, level: float) -> float:
    """When a signal that begins at 0 and ends at 1 first has a level."""
    at = int(np.argmax(share >= level))
    before, after = float(share[at - 1]), float(share[at])
    return float(time[at - 1] + (time[at] - time[at - 1]) * (level - before) / (after - before))


def _settling(time: FloatArray, values: FloatArray, span: float) -> float | Undefined:
    away = np.abs(values - values[-1])
    band = BAND * span
    outside = np.flatnonzero(away > band)
    if not outside.size:
        return Undefined("it is near its last value all the time")
    at = int(outside[-1])  # the last row outside; the next is inside
    inside = float(time[at] + (time[at + 1] - time[at]) * (away[at] - band) / (away[at] - away[at + 1]))
    if time[-1] - inside < REST * (time[-1] - time[0]):
        return Undefined("it still moves when the run ends")
    return float(inside - time[0])
