"""`python -m benchmarks.methods [SECONDS]`: what each method and step costs on the truck's mission, and what it misses.

Processor time of the run alone, without building the machine, smallest of three; against the same mission with ROS2 in
steps of 0.25 ms. The last column is the largest difference of an activity index.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

from propermodel.analysis.activity import ActivityRanking, rank_activity
from propermodel.codegen.machine import Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate

FUEL = "engine.fuel_meter.mass"
REPEATS = 3
REFERENCE_STEP = 2.5e-4  # s
TRIED = (
    (Method.EULER, 2e-4, 1),
    (Method.SEMI_IMPLICIT, 2e-4, 1),
    (Method.RK4, 4e-4, 1),
    (Method.ROS2, 1e-3, 1),
    (Method.ROS2, 2e-3, 1),
    (Method.ROS2, 2e-3, 5),
    (Method.ROS2, 1e-2 / 3.0, 3),
    (Method.ROS2, 5e-3, 1),
    (Method.ROS2, 5e-3, 2),
)


@dataclass(frozen=True)
class Measured:
    """One run."""

    cpu_s: float
    steps: int
    fuel: float
    ranking: ActivityRanking


def main() -> None:
    """Print the table."""
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    truck, scenario = compile_model(elaborate(HybridTruck())), mission("fmtv_mixed", until=until)
    exact = _run(truck, scenario, Method.ROS2, REFERENCE_STEP, 1, repeats=1)
    print(f"{scenario.name}, {scenario.stop:g} s")
    print("method                step ms  Jacobian for    CPU s  ns a step      fuel  total activity   index, points")
    for method, step, steps_each in TRIED:
        found = _run(truck, scenario, method, step, steps_each, repeats=REPEATS)
        indices = {row.path: row.index for row in found.ranking.rows}
        worst = max(abs(indices[row.path] - row.index) for row in exact.ranking.rows)
        print(
            f"{method:<20} {step * 1e3:>8.3g} {steps_each:>13} {found.cpu_s:>8.2f} "
            f"{found.cpu_s / found.steps * 1e9:>10.0f} {found.fuel / exact.fuel - 1.0:>+9.1e} "
            f"{100.0 * (found.ranking.total / exact.ranking.total - 1.0):>+14.3f}% {100.0 * worst:>15.4f}"
        )


def _run(
    truck: CompiledModel, scenario: Scenario, method: Method, step: float, jacobian_every: int, *, repeats: int
) -> Measured:
    truck.machine(method)
    times: list[float] = []
    while True:
        begin = time.process_time()
        run = simulate(truck, scenario, method=method, step=step, jacobian_every=jacobian_every, record=[FUEL])
        times.append(time.process_time() - begin)
        if len(times) == repeats:
            return Measured(min(times), run.statistics.steps, run.at_end(FUEL), rank_activity(run))


if __name__ == "__main__":
    main()
