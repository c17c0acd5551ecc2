"""`python -m benchmarks`: how long compiling and running take, full against reduced, and how it grows with size."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from statistics import median

from benchmarks.growth import print_growth
from propermodel.analysis.activity import rank_activity
from propermodel.codegen.machine import Method
from propermodel.codegen.object_cache import OFF, VARIABLE
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
STARTS = 10

# Seconds of processor time that a new process spends on this.
TIMED = """
import time
begin = time.process_time()
{}
print(time.process_time() - begin)
"""
IMPORT = "import propermodel"
FIRST_STEP = """
from propermodel import Method, compile_model, elaborate
from propermodel.library.vehicle.truck import HybridTruck
compile_model(elaborate(HybridTruck())).machine(Method.SEMI_IMPLICIT)
"""


def main() -> None:
    """Print every measurement."""
    print(f"{platform.platform()}, {platform.processor() or platform.machine()}, Python {platform.python_version()}")
    os.environ[VARIABLE] = OFF  # compiling is measured, not reading what an earlier run has left
    _starts()
    full = compile_model(elaborate(HybridTruck()))
    scenario = mission("fmtv_mixed")
    reduced = _reduce(full, scenario)
    _race(full, reduced, replace(scenario, stop=WINDOW))
    print_growth()


def _starts() -> None:
    print(f"processor time of new processes, median of {STARTS} (smallest to largest):")
    with tempfile.TemporaryDirectory() as folder:
        # As a user has it: the byte code of Python is kept, too.
        without = os.environ | {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        kept = without | {VARIABLE: folder}
        _seconds(FIRST_STEP, kept)
        _start("import numpy, for comparison", "import numpy", without)
        _start("import propermodel", IMPORT, without)
        _start("truck, from source to machine code", FIRST_STEP, without)
        _start("the same, code kept by an earlier process", FIRST_STEP, kept)


def _start(title: str, code: str, environment: Mapping[str, str]) -> None:
    times = [_seconds(code, environment) for _ in range(STARTS)]
    print(f"  {title:<42} {median(times):.2f} s ({min(times):.2f} to {max(times):.2f})")


def _seconds(code: str, environment: Mapping[str, str]) -> float:
    command = [sys.executable, "-c", TIMED.format(code)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout)


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
