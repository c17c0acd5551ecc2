"""Runs that end as soon as it is proved that their errors exceed the tolerances.

Integrals of squares and absolute values only grow, and so does the largest value: what they have reached divided by the
whole window is a lower bound of the error that the complete run will have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.analysis.comparison import Comparison, Feature, compare_columns
from propermodel.analysis.tolerances import Tolerance
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import start_of
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.trajectory import Trajectory

PARTS = (0.05, 0.15, 0.3, 0.5, 0.7, 1.0)  # of the window: where errors are looked at


@dataclass(frozen=True, kw_only=True)
class WatchedRun:
    """What a run with some outputs came to: all its errors, or what they had reached when it was ended."""

    failure: str  # why it did not come to its end; empty where nothing went wrong
    time: float  # where it ended, s
    comparison: Comparison | None  # of a complete run
    reached: Mapping[Path, Mapping[Feature, float]]  # of a run that was ended: errors that the complete one exceeds
    wall_s: float  # of stepping

    def score(self, tolerances: Mapping[Path, Tolerance]) -> float:
        """The largest error over its tolerance, or the least that it can be."""
        if self.failure:
            return math.inf
        if self.comparison is not None:
            return max(tolerances[error.path].score(error) for error in self.comparison.outputs)
        return score_of(self.reached, tolerances)


def run_watched(
    compiled: CompiledModel,
    scenario: Scenario,
    reference: Trajectory,
    tolerances: Mapping[Path, Tolerance],
    stepping: Stepping,
    record_every: float,
) -> WatchedRun:
    """Run a candidate until it has come to the end or is outside.

    Raises:
        SimulationError: the scenario does not fit the model, or it cannot start.
    """
    span = scenario.stop - scenario.start
    run: Trajectory | None = None
    times: list[FloatArray] = []
    values: dict[Path, list[FloatArray]] = {path: [] for path in tolerances}
    wall_s = 0.0
    begun = start_of(compiled, scenario)
    for stop in _stops(scenario, record_every):
        run = simulate(
            compiled,
            replace(scenario, stop=stop),
            method=stepping.method,
            step=stepping.step,
            jacobian_every=stepping.jacobian_every,
            tolerance=stepping.tolerance,
            record=list(tolerances),
            record_every=record_every,
            integrals_every=span,
            continued_from=run,
            start=begun,
        )
        wall_s += run.statistics.wall_s
        if not run.ending.is_complete:
            message, time = run.ending.message, run.ending.time
            return WatchedRun(failure=message, time=time, comparison=None, reached={}, wall_s=wall_s)
        times.append(run.time)
        for path, parts in values.items():
            parts.append(run[path])
        time, columns = np.concatenate(times), {path: np.concatenate(parts) for path, parts in values.items()}
        if stop < scenario.stop:
            reached = least_errors(reference, time, columns)
            if score_of(reached, tolerances) > 1.0:
                return WatchedRun(failure="", time=stop, comparison=None, reached=reached, wall_s=wall_s)
            continue
        instants = reference.time
        comparison = Comparison(
            tuple(
                compare_columns(
                    path, reference.unit(path), instants, reference[path], np.interp(instants, time, columns[path])
                )
                for path in tolerances
            )
        )
        return WatchedRun(failure="", time=stop, comparison=comparison, reached={}, wall_s=wall_s)
    raise AssertionError("a window has an end")


def _stops(scenario: Scenario, record_every: float) -> Sequence[float]:
    """Recording instants at which a run pauses, and the end."""
    span = scenario.stop - scenario.start
    rows = [math.floor(share * span / record_every) for share in PARTS[:-1]]
    early = [scenario.start + count * record_every for count in dict.fromkeys(rows) if count > 0]
    return [*(stop for stop in early if stop < scenario.stop), scenario.stop]


def least_errors(
    reference: Trajectory, time: FloatArray, columns: Mapping[Path, FloatArray]
) -> dict[Path, dict[Feature, float]]:
    """The least that errors of a run can be, as far as it has come."""
    window = float(reference.time[-1] - reference.time[0])
    until = reference.time <= time[-1]
    at = reference.time[until]
    found: dict[Path, dict[Feature, float]] = {}
    for path, values in columns.items():
        expected = reference[path]
        scale = float(np.ptp(expected)) or float(np.max(np.abs(expected))) or 1.0
        difference = np.abs(np.interp(at, time, values) - expected[until]) / scale
        found[path] = {
            Feature.MEAN: float(np.trapezoid(difference, at)) / window,
            Feature.RMS: math.sqrt(float(np.trapezoid(difference**2, at)) / window),
            Feature.LARGEST: float(np.max(difference)),
        }
    return found


def score_of(reached: Mapping[Path, Mapping[Feature, float]], tolerances: Mapping[Path, Tolerance]) -> float:
    """The largest of errors over their tolerances; features of which nothing is known yet do not count."""
    return max(
        (
            reached[path].get(feature, 0.0) / share
            for path, tolerance in tolerances.items()
            for feature, share in tolerance.shares.items()
        ),
        default=0.0,
    )
