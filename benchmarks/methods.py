"""`python -m benchmarks.methods [SECONDS]`: what each method and step costs on the truck's mission, and what it misses.

Processor time of the run alone, without building the machine, smallest of three; against the same mission with RODAS at
a tolerance of 1e-8. The last column is the largest difference of an activity index.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.ranking import ActivityRanking
from propermodel.codegen.machine import Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.stepping import Stepping

FUEL = "engine.fuel_meter.mass"
REPEATS = 3
REFERENCE = Stepping(Method.RODAS, tolerance=1e-8)
TRIED = (
    Stepping(Method.EULER, 2e-4),
    Stepping(Method.SEMI_IMPLICIT, 2e-4),
    Stepping(Method.RK4, 4e-4),
    Stepping(Method.ROS2, 1e-3),
    Stepping(Method.ROS2, 2e-3),
    Stepping(Method.ROS2, 2e-3, 5),
    Stepping(Method.ROS2, 1e-2 / 3.0, 3),
    Stepping(Method.ROS2, 5e-3),
    Stepping(Method.ROS2, 5e-3, 2),
    *(Stepping(Method.RODAS, tolerance=tolerance) for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
    Stepping(Method.DOPRI5, tolerance=1e-4),
)


@dataclass(frozen=True)
class Measured:
    """One run."""

    cpu_s: float
    steps: int
    rejected: int
    fuel: float
    ranking: ActivityRanking


def main() -> None:
    """Print the table."""
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    truck, scenario = compile_model(elaborate(HybridTruck())), mission("fmtv_mixed", until=until)
    exact = _run(truck, scenario, REFERENCE, repeats=1)
    print(f"{scenario.name}, {scenario.stop:g} s, against {REFERENCE}")
    print(
        "method                step ms  Jacobian for  tolerance    CPU s     steps  rejected  ns a step      fuel  "
        "total activity   index, points"
    )
    for stepping in TRIED:
        found = _run(truck, scenario, stepping, repeats=REPEATS)
        indices = {row.path: row.index for row in found.ranking.rows}
        worst = max(abs(indices[row.path] - row.index) for row in exact.ranking.rows)
        is_adaptive = stepping.method.is_adaptive
        step = "" if is_adaptive else f"{stepping.longest() * 1e3:.3g}"
        tolerance = f"{stepping.tolerance:g}" if is_adaptive else ""
        print(
            f"{stepping.method:<20} {step:>8} {stepping.jacobian_every:>13} {tolerance:>10} {found.cpu_s:>8.2f} "
            f"{found.steps:>9} {found.rejected:>9} {found.cpu_s / (found.steps + found.rejected) * 1e9:>10.0f} "
            f"{found.fuel / exact.fuel - 1.0:>+9.1e} "
            f"{100.0 * (found.ranking.total / exact.ranking.total - 1.0):>+14.3f}% {100.0 * worst:>15.4f}",
            flush=True,
        )


def _run(truck: CompiledModel, scenario: Scenario, stepping: Stepping, *, repeats: int) -> Measured:
    truck.machine(stepping.method)
    times: list[float] = []
    while True:
        begin = time.process_time()
        run = simulate(
            truck,
            scenario,
            method=stepping.method,
            step=stepping.step,
            jacobian_every=stepping.jacobian_every,
            tolerance=stepping.tolerance,
            record=[FUEL],
        )
        times.append(time.process_time() - begin)
        if len(times) == repeats:
            statistics = run.statistics
            return Measured(min(times), statistics.steps, statistics.rejected, run.at_end(FUEL), rank_activity(run))


if __name__ == "__main__":
    main()
