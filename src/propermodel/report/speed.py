"""How much faster a reduced model runs: at the same step, and each at the largest step that is still good."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from propermodel.analysis.activity import row_activities
from propermodel.codegen.machine import sample_periods
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import RunStatus, Trajectory

LONGEST_RUN_S = 3.0  # wall time of one timed run of the full model
LONGEST_SEARCH_RUN_S = 1.0  # the same in the search for steps, at the step of the study
MOST_OUTPUT_CHANGE = 1e-3  # rms over range
MOST_INDEX_CHANGE = 0.3  # percentage points
MOST_HALVINGS = 3
RUNG = 2.0**0.5  # from one step of the ladder to the next
REFERENCE = 4.0  # the step of a reference run is this much smaller


@dataclass(frozen=True, slots=True)
class Timing:
    """Wall times of repeated runs of one model, s."""

    step: float
    steps: int
    runs: tuple[float, ...]

    @property
    def median(self) -> float:
        """The median, s."""
        return median(self.runs)


@dataclass(frozen=True, slots=True)
class Speed:
    """Interleaved runs of the full and the reduced model: same method, recorded signals and window."""

    window: tuple[float, float]
    full: Timing
    reduced: Timing

    @property
    def ratio(self) -> float:
        """How many times faster the reduced model is, from medians."""
        return self.full.median / max(self.reduced.median, 1e-12)


@dataclass(frozen=True, slots=True)
class BestSteps:
    """Speed with each model at its own largest good step; without it where no step of the ladder is good."""

    window: tuple[float, float]
    full_step: float | None
    reduced_step: float | None
    speed: Speed | None


def measure_speed(full: Trajectory, reduced: Trajectory, outputs: Iterable[Path], repeats: int) -> Speed:
    """Time both models at the step of the study on the first part of the scenario (at most about 3 s a run)."""
    window = _window(full, LONGEST_RUN_S)
    return _race(full, reduced, (full.step, reduced.step), window, tuple(outputs), repeats)


def measure_best_steps(full: Trajectory, reduced: Trajectory, outputs: Iterable[Path], repeats: int) -> BestSteps:
    """Time each model at the largest step of a ladder up to which the answers are good.

    Good means: compared with a run at a quarter of the step, no output changes by more than 0.1 % (rms over range) and
    no activity index by more than 0.3 points.
    """
    outputs = tuple(outputs)
    window = _window(full, LONGEST_SEARCH_RUN_S)
    steps = [_largest_good_step(run, window, outputs) for run in (full, reduced)]
    speed = None
    if steps[0] is not None and steps[1] is not None:
        speed = _race(full, reduced, (steps[0], steps[1]), window, outputs, repeats)
    return BestSteps(window, steps[0], steps[1], speed)


def _window(full: Trajectory, longest: float) -> tuple[float, float]:
    span = full.scenario.stop - full.scenario.start
    share = min(1.0, longest / max(full.statistics.wall_s, 1e-9))
    return full.scenario.start, full.scenario.start + span * share


def _race(
    full: Trajectory,
    reduced: Trajectory,
    steps: tuple[float, float],
    window: tuple[float, float],
    outputs: tuple[Path, ...],
    repeats: int,
) -> Speed:
    walls: tuple[list[float], list[float]] = ([], [])
    counts = [0, 0]
    for _ in range(repeats):
        for index, run in enumerate((full, reduced)):
            done = _run(run.compiled, run.scenario, run, steps[index], window, outputs)
            walls[index].append(done.statistics.wall_s)
            counts[index] = done.statistics.steps
    return Speed(
        window,
        Timing(steps[0], counts[0], tuple(walls[0])),
        Timing(steps[1], counts[1], tuple(walls[1])),
    )


def _run(
    compiled: CompiledModel,
    scenario: Scenario,
    like: Trajectory,
    step: float,
    window: tuple[float, float],
    outputs: tuple[Path, ...],
) -> Trajectory:
    run = simulate(
        compiled,
        replace(scenario, stop=window[1]),
        method=like.method,
        step=step,
        jacobian_every=like.jacobian_every,
        tolerance=like.tolerance,
        record=outputs,
        record_every=_period(like),
    )
    if run.ending.status is RunStatus.INTERRUPTED:
        raise KeyboardInterrupt
    return run


def _period(run: Trajectory) -> float:
    return float(run.time[1] - run.time[0]) if len(run.time) > 1 else 0.1


def _largest_good_step(run: Trajectory, window: tuple[float, float], outputs: tuple[Path, ...]) -> float | None:
    """The last good step on a ladder upward from the step of the study, or the first one downward from it.

    The ladder ends at the shortest tick, since a step never reaches over a sample of a controller or a recording.
    """
    runs: dict[float, Trajectory] = {}

    def is_good(step: float) -> bool:
        for each in (step, step / REFERENCE):
            if each not in runs:
                runs[each] = _run(run.compiled, run.scenario, run, each, window, outputs)
        found, reference = runs[step], runs[step / REFERENCE]
        return found.ending.is_complete and reference.ending.is_complete and _agree(found, reference, outputs)

    longest = min([_period(run), *sample_periods(run.compiled.lowered.program, run.memory)])
    if not is_good(run.step):
        smaller = (run.step / RUNG**k for k in range(1, 2 * MOST_HALVINGS + 1))
        return next((step for step in smaller if is_good(step)), None)
    best = run.step
    while best * RUNG <= longest and is_good(best * RUNG):
        best *= RUNG
    return best


def _agree(run: Trajectory, reference: Trajectory, outputs: tuple[Path, ...]) -> bool:
    for path in outputs:
        expected = reference[path]
        span = float(np.ptp(expected)) or 1.0
        if float(np.sqrt(np.mean((run[path] - expected) ** 2))) > MOST_OUTPUT_CHANGE * span:
            return False
    found, fine = row_activities(run), row_activities(reference)
    total, fine_total = sum(found.values()), sum(fine.values())
    if not total > 0.0 or not fine_total > 0.0:
        return False
    changes = (abs(found[path] / total - fine[path] / fine_total) * 100.0 for path in fine)
    return max(changes) <= MOST_INDEX_CHANGE
