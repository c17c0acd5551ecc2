"""The trucks: what they are made of, and that they drive."""

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.analysis.sensitivities import sensitivities
from propermodel.codegen.machine import Method
from propermodel.diagnostics import parse_path
from propermodel.expressions.core import Op, as_expr
from propermodel.library.hydraulics import NITROGEN
from propermodel.library.vehicle.mission import mission
from propermodel.simulation.ensemble import designs, simulate_many
from propermodel.simulation.simulate import simulate
from tests.library.laws import value_of

AXLES = ("front_axle", "rear_front_axle", "rear_rear_axle")
OF_AN_AXLE = (
    *("forward_mass", "vertical_mass", "spring", "shock_absorber", "wheel", "brake", "final_drive.loss"),
    *("tyre.spring", "tyre.damper", "tyre.slip", "tyre.rolling"),
)
HYDRAULICS = (
    *("gearbox.loss", "pump_motor.torque_loss", "pump_motor.volumetric_loss", "pump_motor.rotating_group"),
    *("accumulator", "accumulator_wall", "accumulator_line", "reservoir", "reservoir_wall", "reservoir_line"),
)
# The 57 energy elements of the hybrid truck (Louca and Yildir 2006, as listed for this truck).
ROWS = {
    *("engine.inertia", "charging_pump", "converter", "transmission.churning", "transmission.loss"),
    *("transmission.inertia", "output_shaft.spring", "output_shaft.damper"),
    *("driveline.transfer_case.loss", "driveline.inter_axle_case.loss"),
    *("chassis.body.forward_mass", "chassis.body.vertical_mass", "chassis.body.inertia", "chassis.drag"),
    *(f"chassis.{axle}.{part}" for axle in AXLES for part in OF_AN_AXLE),
    *(f"hydraulics.{part}" for part in HYDRAULICS),
}


def test_the_hybrid_truck_has_57_energy_elements(hybrid):
    assert len(ROWS) == 57
    assert {str(row.path) for row in hybrid.system.rows} == ROWS


def test_the_conventional_truck_has_all_but_the_hydraulics(conventional):
    assert {str(row.path) for row in conventional.system.rows} == {r for r in ROWS if not r.startswith("hydraulics")}


def test_what_runs_with_something_else_is_dependent_storage(hybrid):
    dependent = {str(path) for path in hybrid.system.causal.derivative}
    assert dependent == {
        "transmission.inertia.turbine",
        "hydraulics.pump_motor.rotating_group",
        *(f"chassis.{axle}.forward_mass" for axle in AXLES),
    }


def test_at_the_start_the_accumulator_is_at_its_lowest_working_pressure(hybrid):
    run = simulate(hybrid, mission("fmtv_mixed", until=0.01))
    assert run.at_start("hydraulics.accumulator_pressure") == pytest.approx(13e6, rel=1e-6)
    assert run.at_start("hydraulics.reservoir_pressure") == pytest.approx(643380.6, rel=1e-6)
    empty = value_of(NITROGEN.pressure(as_expr(0.120 / 16.64), as_expr(300.0)))
    assert empty == pytest.approx(12.5e6, rel=1e-3)


@pytest.fixture(scope="module")
def city_start(hybrid):
    return simulate(hybrid, mission("fmtv_mixed", until=60.0))


def test_a_standing_truck_stands(city_start):
    first = city_start.time <= 5.0
    assert np.max(np.abs(city_start["chassis.speed"][first])) < 0.01
    assert city_start["engine.crankshaft.flow"][first] == pytest.approx(np.full(first.sum(), 73.3), abs=0.2)


def test_the_truck_follows_the_city(city_start):
    profile = mission("fmtv_mixed").tables[parse_path("driver.speed_profile")]
    wanted = np.interp(city_start.time, profile.grids[0], profile.values)
    assert np.max(np.abs(city_start["chassis.speed"] - wanted)) < 1.0


def test_the_energy_of_the_truck_balances(city_start):
    balance = energy_balance(city_start)
    # The step of the integration costs some 1e-4; the wiring nothing.
    assert balance.relative_residual < 3e-4
    assert abs(balance.wiring_residual) < 1e-8 * balance.throughput


def test_the_locked_converter_does_not_slip(city_start):
    locked = city_start["transmission_control.clutch_closed"] > 0.5
    settled = locked & np.roll(locked, 3)
    slip = city_start["converter.clutch.port.flow"][settled]
    assert settled.sum() > 20
    assert np.max(np.abs(slip)) < 1e-2


def test_the_sensitivity_of_the_fuel_is_the_limit_of_differences(hybrid):
    """While the truck stands and sets off: tables, friction around zero speed, dependent storage, sampled control."""
    scenario = mission("fmtv_mixed", until=12.0)
    parameters = ("sprung_mass", "driveline.transfer_efficiency")
    found = sensitivities(hybrid, scenario, parameters=parameters, outputs=["engine.fuel_used", "chassis.speed"])
    entries = {row.path: row.path if len(row.bonds) > 1 else next(iter(row.bonds)) for row in hybrid.system.rows}
    for k, name in enumerate(parameters):
        value = found.parameter_values[k]
        distance = 1e-6 * value
        sides = designs(scenario, {name: [value - distance, value + distance]})
        runs = simulate_many(hybrid, sides, record=["engine.fuel_used", "chassis.speed"])
        for output, tolerance in (("engine.fuel_used", 1e-5), ("chassis.speed", 2e-3)):
            less, more = runs.at_end(output)
            assert found.at_end(output, name) == pytest.approx((more - less) / (2.0 * distance), rel=tolerance)
        for row in found.rows[:10]:
            less, more = runs.activity(entries[row])
            largest = np.abs(found.row_activity.slopes[:, k]).max()
            assert found.activity(row, name) == pytest.approx((more - less) / (2.0 * distance), abs=1e-4 * largest)
    assert found.at_end("engine.fuel_used", "sprung_mass", relative=True) > 0.0


def test_no_design_within_five_percent_is_lost_with_implicit_steps(hybrid):
    random = np.random.default_rng(20)
    sets = {
        path: np.clip(parameter.value.data[0] * random.uniform(0.95, 1.05, 8), parameter.low, parameter.high)
        for path, parameter in hybrid.graph.parameters.items()
        # Those that follow from others follow them; lanes sample their controllers together.
        if parameter.value.op is Op.CONSTANT and path.name != "period"
    }
    assert len(sets) > 150
    every = designs(mission("fmtv_mixed", until=40.0), sets)
    fuel = parse_path("engine.fuel_meter.mass")
    settings = {"method": Method.ROS2, "step": 5e-3, "jacobian_every": 2, "record": [fuel]}
    runs = simulate_many(hybrid, every, **settings)
    assert runs.failed == ()
    assert np.all(np.isfinite(runs.activities))
    assert np.ptp(runs.at_end(fuel)) > 0.01 * np.mean(runs.at_end(fuel))
    alone = simulate(hybrid, every[5], **settings)
    assert alone.at_end(fuel) == runs.at_end(fuel)[5]
    np.testing.assert_array_equal(alone.memory.activity, runs.activities[5])


@pytest.mark.slow
def test_the_hybrid_mission_is_that_of_an_independent_simulation(hybrid):
    # Another program, written from the same parameter set (C, exact engine torque, same step): 7.56164 kg, 22949.42 m,
    # 192.4213 MJ of activity, 46.53211 MJ of it in the body's forward motion. Here the engine has a map of finite mesh.
    run = simulate(hybrid, mission("fmtv_mixed"))
    ranking = rank_activity(run)
    assert run.at_end("engine.fuel_used") == pytest.approx(7.56164, rel=1e-3)
    assert run.at_end("chassis.odometer.position") == pytest.approx(22949.42, abs=0.5)
    assert ranking.total == pytest.approx(192.4213e6, rel=1e-3)
    assert ranking.rows[0].path == parse_path("chassis.body.forward_mass")
    assert ranking.rows[0].activity == pytest.approx(46.53211e6, rel=1e-3)


@pytest.mark.slow
def test_the_conventional_mission_is_that_of_an_independent_simulation(conventional):
    run = simulate(conventional, mission("fmtv_mixed"))
    assert run.at_end("engine.fuel_used") == pytest.approx(7.607756, rel=1e-3)
    assert run.at_end("chassis.odometer.position") == pytest.approx(22948.676, abs=0.5)
