"""Comparison of two runs on the outputs that matter."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from propermodel.analysis.features import Peak, SignalFeatures, Undefined, signal_features
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr
from propermodel.presentation import notebook_html
from propermodel.simulation.observables import observable_path
from propermodel.simulation.trajectory import Trajectory


class Feature(StrEnum):
    """What of an output can be compared; `Tolerance` says what each means."""

    MEAN = "mean"
    RMS = "rms"
    LARGEST = "largest"
    FINAL = "final"
    PEAK = "peak"
    PEAK_TIME = "peak_time"
    RISE = "rise"
    SETTLING = "settling"


@dataclass(frozen=True, slots=True)
class OutputError:
    """How one output of a run differs from the reference.

    Differences of values are shares of the reference's range, or of its largest value if it is constant. Mean and root
    mean square are over time.
    """

    path: Path
    unit: str
    reference_range: float
    mean: float  # of the absolute difference: L1
    rms: float  # L2
    largest: float  # L-infinity
    at: float  # time of the largest, s
    scale: float  # what the shares refer to
    reference: SignalFeatures
    other: SignalFeatures

    @property
    def final_error(self) -> float:
        """The difference of the final values, with its sign."""
        return (self.other.final - self.reference.final) / self.scale

    def of(self, feature: Feature) -> float | Undefined:
        """The size of one difference: of values as a share of the range, of times as a share of the reference's time.

        Undefined where the reference or the other run lacks the feature.
        """
        match feature:
            case Feature.MEAN:
                return self.mean
            case Feature.RMS:
                return self.rms
            case Feature.LARGEST:
                return self.largest
            case Feature.FINAL:
                return abs(self.final_error)
            case Feature.PEAK:
                return _of_peaks(self.reference.peak, self.other.peak, self.scale)
            case Feature.PEAK_TIME:
                return _of_times(_time_of(self.reference.peak), _time_of(self.other.peak))
            case Feature.RISE:
                return _of_times(self.reference.rise, self.other.rise)
            case Feature.SETTLING:
                return _of_times(self.reference.settling, self.other.settling)

    def is_defined(self, feature: Feature) -> bool:
        """Whether the reference has a feature."""
        return not isinstance(replace(self, other=self.reference).of(feature), Undefined)

    def __str__(self) -> str:
        return (
            f"{self.path}: rms {self.rms:.3%} of its range, largest {self.largest:.3%} at {self.at:.1f} s, "
            f"final {self.reference.final:.6g} -> {self.other.final:.6g} {self.unit} ({self.final_error:+.3%})"
        )


def _of_peaks(before: Peak | Undefined, after: Peak | Undefined, scale: float) -> float | Undefined:
    """The change of a peak as a share of the range."""
    if isinstance(before, Undefined):
        return before
    return after if isinstance(after, Undefined) else abs(after.value - before.value) / scale


def _time_of(peak: Peak | Undefined) -> float | Undefined:
    return peak if isinstance(peak, Undefined) else peak.after


def _of_times(before: float | Undefined, after: float | Undefined) -> float | Undefined:
    """The change of a time as a share of it."""
    if isinstance(before, Undefined):
        return before
    return after if isinstance(after, Undefined) else abs(after / before - 1.0)


@dataclass(frozen=True)
class Comparison:
    """The differences of a run from a reference run."""

    outputs: tuple[OutputError, ...]

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    def __str__(self) -> str:
        return "\n".join(str(output) for output in self.outputs)


def compare(reference: Trajectory, other: Trajectory, outputs: Iterable[Expr | Path | str]) -> Comparison:
    """Compare a run with a reference, output by output, at the instants of the reference.

    Raises:
        SimulationError: an output is not in both runs.
    """
    paths = [observable_path(output) for output in outputs]
    return Comparison(tuple(_compare_output(reference, other, path) for path in paths))


def _compare_output(reference: Trajectory, other: Trajectory, path: Path) -> OutputError:
    time = reference.time
    found = np.interp(time, other.time, other[path])
    return compare_columns(path, reference.unit(path), time, reference[path], found)


def compare_columns(path: Path, unit: str, time: FloatArray, expected: FloatArray, found: FloatArray) -> OutputError:
    """Compare the values of one output at the same instants."""
    scale = float(np.ptp(expected)) or float(np.max(np.abs(expected))) or 1.0
    difference = np.abs(found - expected)
    worst = int(np.argmax(difference))
    before = signal_features(time, expected, scale)
    side = 0.0 if isinstance(before.peak, Undefined) else before.peak.value - float(expected[0])
    return OutputError(
        path=path,
        unit=unit,
        reference_range=float(np.ptp(expected)),
        mean=_mean(time, difference) / scale,
        rms=float(np.sqrt(_mean(time, difference**2))) / scale,
        largest=float(difference[worst]) / scale,
        at=float(time[worst]),
        scale=scale,
        reference=before,
        other=signal_features(time, found, scale, side),
    )


def _mean(time: FloatArray, values: FloatArray) -> float:
    """The mean over time of what is linear between instants."""
    window = float(time[-1] - time[0])
    return float(np.trapezoid(values, time)) / window if window > 0.0 else float(np.mean(values))
