"""Part e: missions of the full truck, one after the other, side by side in vector lanes, and in threads.

And the memory that ten thousand designs of a small model take, in a process of their own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
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


@dataclass(frozen=True)
class Case:
    """A method, and how much of the mission it is measured on: with long steps starts weigh more."""

    method: Method
    step: float
    jacobian_every: int
    window: float  # s


CASES = (Case(Method.SEMI_IMPLICIT, 2e-4, 1, 200.0), Case(Method.ROS2, 5e-3, 2, 2200.0))
QUICK = 0.1  # of the window
REPEATS = 5
FUEL = "engine.fuel_meter.mass"
SPREAD = 0.05
DRAWN = 48  # designs with all parameters drawn, of which none may be lost

# Peak memory before and after, in MB.
MEMORY = """
import json, resource
import numpy as np
import propermodel as pm
from examples.quarter_car import QuarterCar, scenario

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

car = pm.compile_model(pm.elaborate(QuarterCar()))
every = pm.designs(scenario(), {"suspension.damping": np.linspace(500.0, 4000.0, 10_000)})
pm.simulate_many(car, every[:8], step=1e-3)
before = peak()
runs = pm.simulate_many(car, every, step=1e-3)
found = {"count": len(runs), "failed": len(runs.failed), "before": before, "peak": peak()}
print(json.dumps(found | {"wall_s": runs.statistics.wall_s, "observables": len(runs.paths)}))
"""


def measure(is_quick: bool) -> Json:
    """Missions a minute for each method, number of lanes and number of threads; and how many of drawn designs fail."""
    truck = compile_model(elaborate(HybridTruck()))
    full = mission("fmtv_mixed")
    share = QUICK if is_quick else 1.0
    best = best_lanes(Backend.NATIVE)
    cores = os.cpu_count() or 1
    repeats = 3 if is_quick else REPEATS
    cases = [_measure(truck, full, case, share * case.window, best, cores, repeats) for case in CASES]
    drawn = replace(full, stop=share * full.stop)
    return {
        "mission": full.stop,
        "lanes": best,
        "cores": cores,
        "cases": cases,
        "drawn": _drawn(truck, drawn),
        "memory": _memory(),
    }


def _memory() -> Json:
    done = subprocess.run([sys.executable, "-c", MEMORY], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def _measure(
    truck: CompiledModel, full: Scenario, case: Case, window: float, best: int, cores: int, repeats: int
) -> Json:
    count = 2 * best * cores
    scenario = replace(full, stop=full.start + window)
    many = designs(scenario, {"sprung_mass": np.linspace(12_000.0, 14_000.0, count)})

    def run(lanes: int, threads: int, clock: Callable[[], float]) -> float:
        begin = clock()
        simulate_many(
            truck,
            many,
            method=case.method,
            step=case.step,
            jacobian_every=case.jacobian_every,
            record=[FUEL],
            lanes=lanes,
            threads=threads,
        )
        # Of one whole mission.
        return (clock() - begin) / count * (full.stop - full.start) / window

    tasks = {
        f"{lanes} {threads}": lambda n=lanes, m=threads: run(n, m, time.perf_counter)
        for lanes, threads in ((1, 1), (best, 1), (best, cores))
    }
    processor = {f"{lanes}": lambda n=lanes: run(n, 1, time.process_time) for lanes in (1, best)}
    walls = interleaved(tasks, repeats)
    cpu = interleaved(processor, repeats)
    return {
        "method": case.method.value,
        "step": case.step,
        "jacobian_every": case.jacobian_every,
        "window": window,
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
    case = CASES[1]
    runs = simulate_many(
        truck,
        designs(scenario, sets),
        method=case.method,
        step=case.step,
        jacobian_every=case.jacobian_every,
        record=[FUEL],
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
        name = f"{case['method']}, {1e3 * case['step']:g} ms{shared}; {case['window']:g} s"
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
    drawn, memory = data["drawn"], data["memory"]
    failed = "none failed" if not drawn["failed"] else f"{len(drawn['failed'])} failed: {'; '.join(drawn['failed'])}"
    return [
        paragraph(
            "`pm.simulate_many` on the full truck, the first seconds of its mission, told as whole missions of",
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
        "",
        paragraph(
            f"{memory['count']} designs of a quarter car, 10 s in steps of 1 ms, with the final values of all",
            f"{memory['observables']} observables: {memory['wall_s']:.0f} s on all cores, {memory['failed']} failed;",
            f"{memory['before']:.0f} MB of memory before and {memory['peak']:.0f} MB at most.",
        ),
    ]


PART = Part("e", "Lanes and threads", measure, write)
