"""`python -m benchmarks.ensembles [SETS [SECONDS]]`: many designs of the truck on its mission, and of a small model.

The sets draw every parameter of the truck at +-5 % of its value, all but the periods of its controllers, which sample
together. Processor time per mission and of a single run, wall time, what failed, and how far the designs spread; then
the memory that ten thousand designs of a car on a bumpy road take, in a process of their own.
"""

from __future__ import annotations

import subprocess
import sys
import time
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from propermodel.codegen.machine import Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, Op
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.ensemble import designs, simulate_many
from propermodel.simulation.simulate import simulate

FUEL = "engine.fuel_meter.mass"
SPREAD = 0.05
SETS = 48
STEP, JACOBIAN_EVERY = 5e-3, 2
SEED = 48

# Peak memory before and after, in MB.
MEMORY = """
import resource
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
print(f"{runs.statistics.wall_s:.1f} s, {len(runs.failed)} failed, {before:.0f} MB before, {peak():.0f} MB at most")
"""


def drawn(compiled: CompiledModel, scenario: Scenario, count: int, spread: float, seed: int) -> tuple[Scenario, ...]:
    """Scenarios with all parameters drawn uniformly around their values, within their ranges."""
    random = np.random.default_rng(seed)
    periods = {compiled.lowered.parameters[index] for index in compiled.lowered.program.periods}
    sets: dict[Expr | Path | str, ArrayLike] = {}
    for parameter in compiled.graph.parameters.values():
        if parameter.value.op is Op.CONSTANT and parameter.path not in periods:
            values = parameter.value.data[0] * random.uniform(1.0 - spread, 1.0 + spread, count)
            sets[parameter.path] = np.clip(values, parameter.low, parameter.high)
    return designs(scenario, sets)


def print_ensembles(count: int = SETS, until: float | None = None) -> None:
    """Measure and print."""
    truck, scenario = compile_model(elaborate(HybridTruck())), mission("fmtv_mixed", until=until)
    every = drawn(truck, scenario, count, SPREAD, SEED)
    many = partial(simulate_many, truck, method=Method.ROS2, step=STEP, jacobian_every=JACOBIAN_EVERY, record=[FUEL])
    one = partial(simulate, truck, method=Method.ROS2, step=STEP, jacobian_every=JACOBIAN_EVERY, record=[FUEL])
    for warm in (lambda: many(every[:8]), lambda: one(every[0]), lambda: one(every[0])):
        warm()  # until all code is compiled thoroughly
    begin = time.process_time()
    runs = many(every)
    many_s = (time.process_time() - begin) / count
    begin = time.process_time()
    one(every[0])
    one_s = time.process_time() - begin
    fuel = runs.at_end(FUEL)
    print(
        f"{count} sets of {len(every[0].parameters)} parameters at +-{100.0 * SPREAD:g} %, {scenario.stop:g} s, "
        f"ros2 in steps of {STEP * 1e3:g} ms, {runs.lanes} side by side: {many_s:.2f} s of processor time a mission, "
        f"{60.0 / many_s:.0f} missions a core-minute (alone {one_s:.2f} s, {60.0 / one_s:.0f}); "
        f"{runs.statistics.wall_s:.1f} s of wall time; {len(runs.failed)} failed; "
        f"fuel {np.nanmin(fuel):.2f} to {np.nanmax(fuel):.2f} kg"
    )
    for index in runs.failed:
        print(f"  set {index}: {runs.endings[index].message}")
    done = subprocess.run([sys.executable, "-c", MEMORY], check=True, capture_output=True, text=True)
    print(f"10000 designs of a quarter car, 10 s in steps of 1 ms: {done.stdout.strip()}")


if __name__ == "__main__":
    given = sys.argv[1:]
    print_ensembles(int(given[0]) if given else SETS, float(given[1]) if len(given) > 1 else None)
