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
from propermodel.simulation.trajectory import Ending, Trajectory

PARTS = (0.05, 0.15, 0.3, 0.5, 0.7, 1.0)  # of the window: where errors are looked at


@dataclass(frozen=True, kw_only=True)
class WatchedRun:
    """What a run with some outputs came to: all errors of a complete one, or a lower bound of its score."""

    ending: Ending
    comparison: Comparison | None  # of a complete run
    score: float  # the largest error over its tolerance, or the bound by which it is outside
    wall_s: float  # of stepping


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
            return WatchedRun(ending=run.ending, comparison=None, score=math.inf, wall_s=wall_s)
        times.append(run.time)
        for path, parts in values.items():
            parts.append(run[path])
        time, columns = np.concatenate(times), {path: np.concatenate(parts) for path, parts in values.items()}
        if stop < scenario.stop:
            bound = least_score(reference, time, columns, tolerances)
            if bound > 1.0:
                return WatchedRun(ending=run.ending, comparison=None, score=bound, wall_s=wall_s)
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
        score = max(tolerances[error.path].score(error) for error in comparison.outputs)
        return WatchedRun(ending=run.ending, comparison=comparison, score=score, wall_s=wall_s)
    raise AssertionError("a window has an end")


def _stops(scenario: Scenario, record_every: float) -> Sequence[float]:
    """Recording instants at which a run pauses, and the end."""
    span = scenario.stop - scenario.start
    rows = [math.floor(share * span / record_every) for share in PARTS[:-1]]
    early = [scenario.start + count * record_every for count in dict.fromkeys(rows) if count > 0]
    return [*(stop for stop in early if stop < scenario.stop), scenario.stop]


def least_score(
    reference: Trajectory, time: FloatArray, columns: Mapping[Path, FloatArray], tolerances: Mapping[Path, Tolerance]
) -> float:
    """The least that the score of a run can be, as far as it has come."""
    window = float(reference.time[-1] - reference.time[0])
    worst = 0.0
    for path, tolerance in tolerances.items():
        expected = reference[path]
        scale = float(np.ptp(expected)) or float(np.max(np.abs(expected))) or 1.0
        until = reference.time <= time[-1]
        at = reference.time[until]
        difference = np.abs(np.interp(at, time, columns[path]) - expected[until]) / scale
        reached = {
            Feature.MEAN: float(np.trapezoid(difference, at)) / window,
            Feature.RMS: math.sqrt(float(np.trapezoid(difference**2, at)) / window),
            Feature.LARGEST: float(np.max(difference)),
        }
        for feature, share in tolerance.shares.items():
            worst = max(worst, reached.get(feature, 0.0) / share)
    return worst
