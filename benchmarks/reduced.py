"""Part f: the full truck against the reduced one, at the same step, and each at its best step for the same error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.alone import Alone
from benchmarks.measure import Json, interleaved, ratios, spread
from benchmarks.part import Part, paragraph, rounded, shown, table
from propermodel.analysis.activity import rank_activity
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory, interpolated, observable_path

FUEL = "engine.fuel_meter.mass"
OUTPUTS = (
    "chassis.speed",
    "chassis.acceleration",
    "engine.crankshaft.flow",
    "engine.injection.fuel",
    "hydraulics.accumulator_pressure",
)
JUDGED = ("hydraulics.accumulator_pressure", "engine.crankshaft.flow", "chassis.speed")  # and fuel
SAME = ((Method.EULER, 2e-4), (Method.SEMI_IMPLICIT, 2e-4), (Method.RK4, 2e-4), (Method.ROS2, 2e-3))
LADDER = {
    Method.SEMI_IMPLICIT: tuple(1e-4 * 2.0 ** (k / 2) for k in range(14)),
    Method.RK4: tuple(2e-4 * 2.0 ** (k / 2) for k in range(13)),
    Method.ROS2: tuple(5e-4 * 2.0 ** (k / 2) for k in range(11)),
    Method.RODAS: (1e-6, 1e-5, 1e-4, 1e-3, 1e-2),  # tolerances
}
ERRORS = (1e-3, 1e-2)  # fuel as a share, the others as rms over range
REFERENCE = (Method.ROS2, 1.25e-4)
RECORD_EVERY = 0.1
REPEATS = 7
MODELS = ("full", "reduced")


@dataclass(frozen=True)
class Answer:
    """What a run gives that is judged."""

    fuel: float
    columns: Mapping[str, FloatArray]

    def error(self, exact: Answer) -> float:
        """The largest error: of fuel as a share, of the others as rms over range; infinite where it is no number."""
        errors = [abs(self.fuel / exact.fuel - 1.0)]
        for path, column in exact.columns.items():
            errors.append(float(np.sqrt(np.mean((self.columns[path] - column) ** 2))) / float(np.ptp(column)))
        worst = max(errors)
        return worst if math.isfinite(worst) else math.inf


def measure(is_quick: bool) -> Json:
    """Times at the same steps, and at the largest step of each model for the same error."""
    full = compile_model(elaborate(HybridTruck()))
    whole = mission("fmtv_mixed", until=60.0 if is_quick else None)
    planned = simulate(full, whole, step=2e-4)
    reduction = plan_reduction(full, planned, rank_activity(planned), protected=OUTPUTS, threshold=0.99)
    models = {"full": full, "reduced": compile_model(full.model.without(reduction.removals))}
    timed = replace(whole, stop=min(whole.stop, 20.0 if is_quick else 100.0))
    judged = replace(whole, stop=min(whole.stop, 60.0 if is_quick else 300.0))
    repeats = 3 if is_quick else REPEATS
    return {
        "states": {name: len(model.system.states) for name, model in models.items()},
        "removed": len(reduction.removed),
        "timed": timed.stop,
        "judged": judged.stop,
        "repeats": repeats,
        "same": [_race(models, timed, dict.fromkeys(MODELS, setting), repeats) for setting in SAME],
        "best": _best(models, judged, timed, repeats),
        "between": _answer(models["reduced"], judged, *REFERENCE).error(_answer(full, judged, *REFERENCE)),
    }


def _run(compiled: CompiledModel, scenario: Scenario, method: Method, value: float) -> Trajectory:
    """A run at a step, or at a tolerance where the method chooses its steps."""
    chosen = {"tolerance": value} if method.is_adaptive else {"step": value}
    return simulate(compiled, scenario, method=method, record=[FUEL, *JUDGED], record_every=RECORD_EVERY, **chosen)


def _answer(compiled: CompiledModel, scenario: Scenario, method: Method, step: float) -> Answer:
    run = _run(compiled, scenario, method, step)
    if not run.ending.is_complete:
        return Answer(math.nan, {path: np.full(1, math.nan) for path in JUDGED})
    times = np.arange(0.0, scenario.stop, RECORD_EVERY)
    columns = {path: interpolated(run, observable_path(path), times) for path in JUDGED}
    return Answer(run.at_end(FUEL) - run.at_start(FUEL), columns)


def _race(
    models: Mapping[str, CompiledModel], scenario: Scenario, settings: Mapping[str, tuple[Method, float]], repeats: int
) -> Json:
    """Both models in turn."""
    tasks = {
        name: partial(Alone(models[name], scenario, method).seconds, value)
        for name, (method, value) in settings.items()
    }
    times = interleaved(tasks, repeats)
    return {
        "settings": {name: {"method": method.value, "step": step} for name, (method, step) in settings.items()},
        "seconds": {name: spread(values).json() for name, values in times.items()},
        "ratio": ratios(times["full"], times["reduced"]).json(),
    }


def _best(models: Mapping[str, CompiledModel], judged: Scenario, timed: Scenario, repeats: int) -> list[Json]:
    """For each error the fastest method and step of each model, against a converged run of that model itself."""
    trials: dict[str, list[tuple[float, float, Method, float]]] = {}
    for name, model in models.items():
        exact = _answer(model, judged, *REFERENCE)
        trials[name] = []
        for method, steps in LADDER.items():
            alone = Alone(model, timed, method)
            for step in steps:
                error = _answer(model, judged, method, step).error(exact)
                if not math.isfinite(error):
                    break
                seconds = min(alone.seconds(step) for _ in range(2))
                trials[name].append((error, seconds, method, step))
    found: list[Json] = []
    for most in ERRORS:
        settings: dict[str, tuple[Method, float]] = {}
        for name in MODELS:
            good = [trial for trial in trials[name] if trial[0] <= most]
            if good:
                _, _, method, step = min(good, key=lambda trial: trial[1])
                settings[name] = method, step
        if len(settings) == len(MODELS):
            found.append({"error": most, **_race(models, timed, settings, repeats)})
        else:
            found.append({"error": most, "missing": [name for name in MODELS if name not in settings]})
    return found


def _named(method: str, step: float) -> str:
    is_adaptive = Method(method).is_adaptive
    return f"{method}, tolerance {step:.0e}" if is_adaptive else f"{method}, {rounded(1e3 * step)} ms"


def write(data: Json, _: Path) -> list[str]:
    """The tables."""
    states = data["states"]
    same = [
        [
            _named(**case["settings"]["full"]),
            shown(case["seconds"]["full"]),
            shown(case["seconds"]["reduced"]),
            shown(case["ratio"]),
        ]
        for case in data["same"]
    ]
    best = []
    for case in data["best"]:
        if "missing" in case:
            best.append([f"{100 * case['error']:g} %", "-", "-", f"no step will do: {', '.join(case['missing'])}"])
            continue
        used = [f"{_named(**case['settings'][name])}: {shown(case['seconds'][name])}" for name in MODELS]
        best.append([f"{100 * case['error']:g} %", *used, shown(case["ratio"])])
    return [
        paragraph(
            f"The truck of {states['full']} states and the one that a threshold of 99 % of the activity leaves, with",
            f"{states['reduced']} states and {data['removed']} elements removed; the first",
            f"{data['timed']:g} s of the mission,",
            f"processor seconds of the run alone, median and quartiles of {data['repeats']} interleaved repeats. At",
            "the same method and step:",
        ),
        *table(["method and step", "full s", "reduced s", "full / reduced"], same),
        paragraph(
            "Each at the method and step (or tolerance) that is fastest for an error, against a converged run of",
            "the same model: of fuel",
            "as a share, of accumulator pressure, engine speed and vehicle speed as rms over range,",
            f"over {data['judged']:g} s.",
            f"The converged runs of both models differ by {100 * data['between']:.2g} % in the same measure.",
        ),
        *table(["error", "full s", "reduced s", "full / reduced"], best),
    ]


PART = Part("f", "Full against reduced model", measure, write)
