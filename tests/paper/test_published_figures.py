"""The published figures of Louca and Yildir (2006), beside what this truck gives over its whole mission.

Their parameters and their mission were never published, so their figures are only reported: run with `-s`, or read the
properties of the JUnit report. Ours are those of the README, which were measured with another method and step.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.compiler import CompiledModel, Method, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling import elaborate
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate

FUEL = "engine.fuel_meter.mass"


@dataclass(frozen=True)
class Figure:
    """A published number and ours, which may be off by `within` from the README; `why` says why ours differs."""

    name: str
    published: float
    here: float
    within: float
    unit: str
    why: str


FIGURES = (
    Figure("duration of the mission", 2200.0, 2200.0, 0.0, "s", "same"),
    Figure("share of the most active element", 25.5, 24.2, 0.1, "%", "mass, speeds and stops of the mission"),
    Figure("share of the first 15 elements", 90.0, 87.5, 0.1, "%", "'about' in the text"),
    Figure("elements kept at 99 %", 30, 38, 0, "", "parameters; roughness of the road"),
    Figure("activity kept at 99 %", 99.22, 99.09, 0.02, "%", "where the last kept element ends"),
    Figure(
        "elements removed at 99 %", 27, 25, 0, "", "driven parts go here too; what is not small at its junction stays"
    ),
    Figure("fuel of the full truck", 6.9404, 7.5642, 0.001, "kg", "mission, engine and vehicle"),
    Figure("fuel of the reduced truck", 6.9326, 7.5550, 0.001, "kg", "mission, engine and vehicle"),
    Figure("difference in fuel", 0.11, 0.12, 0.01, "%", "which elements go"),
    Figure("gain in speed", 2.5, 1.2, inf, "times", "machine, method and code: wall time here, same step"),
)
MOST_ACTIVE = "chassis.body.forward_mass"
LEAST_ACTIVE = "a rear tyre damper"


@pytest.fixture(scope="module")
def truck() -> CompiledModel:
    return compile_model(elaborate(HybridTruck()))


def test_the_truck_has_57_energy_elements(truck):
    assert len(truck.system.rows) == 57


@pytest.mark.slow
def test_published_figures_beside_ours(truck, record_property):
    scenario = mission("fmtv_mixed")
    full = simulate(truck, scenario, method=Method.ROS2, step=5e-3)
    ranking = rank_activity(full)
    reduction = plan_reduction(truck, full, ranking, threshold=0.99, protected=["chassis.speed", FUEL])
    reduced_model = compile_model(truck.model.without(reduction.removals))
    reduced = simulate(reduced_model, scenario, method=Method.ROS2, step=5e-3, record=[FUEL])
    assert full.ending.is_complete
    assert reduced.ending.is_complete
    kept = ranking.kept_by(0.99)
    used, used_after = full.at_end(FUEL), reduced.at_end(FUEL)
    measured = {
        "duration of the mission": scenario.stop - scenario.start,
        "share of the most active element": 100.0 * ranking.rows[0].index,
        "share of the first 15 elements": 100.0 * ranking.rows[14].cumulative,
        "elements kept at 99 %": len(kept),
        "activity kept at 99 %": 100.0 * sum(row.index for row in kept),
        "elements removed at 99 %": len(reduction.removed),
        "fuel of the full truck": used,
        "fuel of the reduced truck": used_after,
        "difference in fuel": 100.0 * abs(used_after / used - 1.0),
        "gain in speed": full.statistics.wall_s / reduced.statistics.wall_s,
    }
    assert set(measured) == {figure.name for figure in FIGURES}
    print()
    for figure in FIGURES:
        record_property(figure.name, measured[figure.name])
        assert abs(measured[figure.name] - figure.here) <= figure.within
        print(
            f"{figure.name:<34} published {figure.published:>8g} here {measured[figure.name]:>10.5g} {figure.unit:<6}"
            f" {figure.why}"
        )
    record_property("most active", str(ranking.rows[0].path))
    record_property("least active", str(ranking.rows[-1].path))
    print(f"most active: published {MOST_ACTIVE}, here {ranking.rows[0].path}")
    print(f"least active: published {LEAST_ACTIVE}, here {ranking.rows[-1].path}")
