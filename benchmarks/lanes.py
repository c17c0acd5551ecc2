"""Part e: missions of the full truck, one after the other, side by side in vector lanes, and in threads."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from benchmarks.measure import Json, interleaved, ratios, spread
from benchmarks.part import Part, paragraph, shown, table
from propermodel.codegen.build import Backend, best_lanes
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, Op
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.ensemble import designs, simulate_many
from propermodel.simulation.start import parameter_values

METHODS = ((Method.SEMI_IMPLICIT, 2e-4, 1), (Method.ROS2, 2e-3, 4))
REPEATS = 5
FUEL = "engine.fuel_meter.mass"
SPREAD = 0.05
DRAWN = 48  # designs with all parameters drawn, of which none may be lost


def measure(is_quick: bool) -> Json:
    """Missions a minute for each method, number of lanes and number of threads; and how many of drawn designs fail."""
    truck = compile_model(elaborate(HybridTruck()))
    full = mission("fmtv_mixed")
    window = 20.0 if is_quick else 200.0
    best = best_lanes(Backend.NATIVE)
    cores = os.cpu_count() or 1
    cases = [
        _measure(
            truck, replace(full, stop=window), full.stop - full.start, setting, best, cores, 3 if is_quick else REPEATS
        )
        for setting in METHODS
    ]
    drawn = replace(full, stop=window if is_quick else full.stop)
    return {
        "window": window,
        "mission": full.stop,
        "lanes": best,
        "cores": cores,
        "cases": cases,
        "drawn": _drawn(truck, drawn),
    }


def _measure(
    truck: CompiledModel,
    scenario: Scenario,
    span: float,
    setting: tuple[Method, float, int],
    best: int,
    cores: int,
    repeats: int,
) -> Json:
    method, step, jacobian_every = setting
    count = 2 * best * cores
    many = designs(scenario, {"sprung_mass": np.linspace(12_000.0, 14_000.0, count)})

    def run(lanes: int, threads: int, clock: Callable[[], float]) -> float:
        begin = clock()
        simulate_many(
            truck,
            many,
            method=method,
            step=step,
            jacobian_every=jacobian_every,
            record=[FUEL],
            lanes=lanes,
            threads=threads,
        )
        # Of one whole mission.
        return (clock() - begin) / count * span / (scenario.stop - scenario.start)

    tasks = {
        f"{lanes} {threads}": lambda n=lanes, m=threads: run(n, m, time.perf_counter)
        for lanes, threads in ((1, 1), (best, 1), (best, cores))
    }
    processor = {f"{lanes}": lambda n=lanes: run(n, 1, time.process_time) for lanes in (1, best)}
    walls = interleaved(tasks, repeats)
    cpu = interleaved(processor, repeats)
    return {
        "method": method.value,
        "step": step,
        "jacobian_every": jacobian_every,
        "per_core_minute": {name: spread(60.0 / value for value in values).json() for name, values in cpu.items()},
        "lanes_gain": ratios(cpu["1"], cpu[str(best)]).json(),
        "per_minute": {name: spread(60.0 / value for value in values).json() for name, values in walls.items()},
        "threads_gain": ratios(walls[f"{best} 1"], walls[f"{best} {cores}"]).json(),
    }


def _drawn(truck: CompiledModel, scenario: Scenario) -> Json:
    """Whole missions with every parameter drawn within 5 %, by ROS2."""
    random = np.random.default_rng(20)
    values = parameter_values(truck, {})
    sets: dict[Expr | Path | str, FloatArray] = {}
    for path, parameter in truck.graph.parameters.items():
        value = values[parameter.symbol]
        # Those that follow from others follow them; lanes sample their controllers together.
        if parameter.value.op is Op.CONSTANT and value != 0.0 and path.name != "period":
            drawn = value * random.uniform(1.0 - SPREAD, 1.0 + SPREAD, DRAWN)
            sets[path] = np.clip(drawn, parameter.low, parameter.high)
    method, step, jacobian_every = METHODS[1]
    runs = simulate_many(
        truck, designs(scenario, sets), method=method, step=step, jacobian_every=jacobian_every, record=[FUEL]
    )
    return {
        "count": DRAWN,
        "parameters": len(sets),
        "window": scenario.stop,
        "failed": [runs.endings[i].message for i in runs.failed],
        "wall_s": runs.statistics.wall_s,
    }


def write(data: Json, _: FilePath) -> list[str]:
    """The table."""
    best, cores = data["lanes"], data["cores"]
    rows = []
    for case in data["cases"]:
        shared = f", LU kept {case['jacobian_every']} steps" if case["jacobian_every"] > 1 else ""
        name = f"{case['method']}, {1e3 * case['step']:g} ms{shared}"
        rows.append(
            [
                name,
                shown(case["per_core_minute"]["1"]),
                shown(case["per_core_minute"][str(best)]),
                shown(case["lanes_gain"]),
                shown(case["per_minute"][f"{best} {cores}"]),
                shown(case["threads_gain"]),
            ]
        )
    drawn = data["drawn"]
    failed = "none failed" if not drawn["failed"] else f"{len(drawn['failed'])} failed: {'; '.join(drawn['failed'])}"
    return [
        paragraph(
            f"`pm.simulate_many` on the full truck, first {data['window']:g} s of its mission, told",
            "as whole missions of",
            f"{data['mission']:g} s: missions a minute of one core (processor time) in one lane and",
            f"in {best}, and missions a",
            f"minute of the whole machine with {best} lanes on {cores} threads.",
        ),
        *table(
            [
                "method and step",
                "1 lane, per core",
                f"{best} lanes, per core",
                "gain of lanes",
                f"{best} lanes, {cores} threads",
                "gain of threads",
            ],
            rows,
        ),
        paragraph(
            f"{drawn['count']} designs with {drawn['parameters']} parameters drawn within 5 %,",
            f"{drawn['window']:g} s each, by",
            f"{data['cases'][1]['method']} in steps of {1e3 * data['cases'][1]['step']:g} ms: {failed}.",
        ),
    ]


PART = Part("e", "Lanes and threads", measure, write)
