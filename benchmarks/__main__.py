"""`python -m benchmarks`: how long compiling and running take, full against reduced, and how it grows with size."""

from __future__ import annotations

import platform
import subprocess
import sys
from dataclasses import replace
from statistics import median

from benchmarks.growth import print_growth
from propermodel.analysis.activity import rank_activity
from propermodel.codegen.machine import Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate

OUTPUTS = (
    "chassis.speed",
    "chassis.acceleration",
    "engine.crankshaft.flow",
    "engine.injection.fuel",
    "hydraulics.accumulator_pressure",
)
STEP = 2e-4  # s
WINDOW = 200.0  # s of the mission, for timing
REPEATS = 5

COLD = """
import time
begin = time.perf_counter()
from propermodel import Method, compile_model, elaborate
from propermodel.library.vehicle.truck import HybridTruck
compile_model(elaborate(HybridTruck())).machine(Method.SEMI_IMPLICIT)
print(time.perf_counter() - begin)
"""


def main() -> None:
    """Print every measurement."""
    print(f"{platform.platform()}, {platform.processor() or platform.machine()}, Python {platform.python_version()}")
    _cold_start()
    full = compile_model(elaborate(HybridTruck()))
    scenario = mission("fmtv_mixed")
    reduced = _reduce(full, scenario)
    _race(full, reduced, replace(scenario, stop=WINDOW))
    print_growth()


def _cold_start() -> None:
    seconds = float(subprocess.run([sys.executable, "-c", COLD], check=True, capture_output=True, text=True).stdout)
    print(f"from source to the first step of the truck, new process: {seconds:.2f} s")


def _reduce(full: CompiledModel, scenario: Scenario) -> CompiledModel:
    run = simulate(full, scenario, step=STEP)
    print(f"{run}; peak memory {_peak_memory()}")
    plan = plan_reduction(full, run, rank_activity(run), protected=OUTPUTS)
    return compile_model(full.model.without(plan.removals))


def _peak_memory() -> str:
    try:
        import resource
    except ImportError:
        return "not measured on this system"
    return f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB"


def _race(full: CompiledModel, reduced: CompiledModel, scenario: Scenario) -> None:
    print(f"first {scenario.stop:g} s at {STEP * 1e3:g} ms, interleaved, median of {REPEATS} (smallest to largest):")
    for method in Method:
        walls: dict[str, list[float]] = {"full": [], "reduced": []}
        steps = 0
        for _ in range(REPEATS):
            for name, compiled in (("full", full), ("reduced", reduced)):
                run = simulate(compiled, scenario, method=method, step=STEP, record=OUTPUTS)
                walls[name].append(run.statistics.wall_s)
                steps = run.statistics.steps
        for name, times in walls.items():
            spread = f"{min(times) / steps * 1e9:.0f} to {max(times) / steps * 1e9:.0f}"
            print(f"  {method:<20} {name:<8} {median(times) / steps * 1e9:>6.0f} ns a step ({spread})")
        print(f"  {method:<20} ratio    {median(walls['full']) / median(walls['reduced']):>6.2f}")


if __name__ == "__main__":
    main()
