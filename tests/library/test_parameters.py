"""Every number of the trucks' parameter set, as the models have it, in SI."""

import math

import pytest

from propermodel.diagnostics import parse_path
from propermodel.expressions.core import leaves
from propermodel.library.powertrain.transmission import RATIOS
from propermodel.simulation.start import parameter_values

RPM = math.pi / 30.0
UNIT = "hydraulics.pump_motor"

COMMON = {
    "engine.crankshaft_inertia": 1.1,
    "engine.impeller_inertia": 0.30,
    "engine.inertia.inertia": 1.4,
    "engine.inertia.start_speed": 700 * RPM,
    "engine.injection.idle_speed": 74.704,
    "engine.injection.idle_gain": 60.0,
    "engine.injection.displacement": 7.24e-3,
    "engine.injection.piston_stroke": 0.127,
    "engine.accessories.power": 5000.0,
    "engine.accessories.lowest_speed": 30.0,
    "charging_pump.torque": 15.0,
    "transmission.churning.damping": 0.05,
    "transmission.shift.shift_time": 0.6,
    "transmission.inertia.output_side.inertia": 1.02,
    "transmission.inertia.turbine.inertia": 0.10,
    "transmission.loss.width": 100.0,
    "output_shaft.spring.stiffness": 3.2e5,
    "output_shaft.damper.damping": 60.0,
    "driveline.transfer_case.ratio": 1.0,
    "driveline.transfer_case.efficiency": 0.98,
    "driveline.inter_axle_case.efficiency": 0.985,
    "driveline.transfer_split.share": 0.5,
    "driveline.inter_axle_split.share": 0.5,
    "chassis.body.pitch_inertia": 39000.0,
    "chassis.drag.drag_area": 5.0,
    "chassis.drag.air_density": 1.2,
    "chassis.front_axle.mass": 1000.0,
    "chassis.rear_front_axle.mass": 1100.0,
    "chassis.rear_rear_axle.mass": 1100.0,
    "chassis.front_axle.ahead": 2.75,
    "chassis.rear_front_axle.ahead": 2.75 - 3.40,
    "chassis.rear_rear_axle.ahead": 2.75 - 4.80,
    "chassis.road.rear_rear_ahead": 2.75 - 4.80,
    "chassis.front_axle.cg_height": 0.99,
    "chassis.front_axle.spring.stiffness": 2.053e5,
    "chassis.rear_front_axle.spring.stiffness": 7.340e5,
    "chassis.rear_rear_axle.spring.stiffness": 7.340e5,
    "chassis.front_axle.shock_absorber.damping": 3.4e4,
    "chassis.rear_rear_axle.shock_absorber.damping": 4.0e4,
    "chassis.front_axle.shock_absorber.degressivity_compression": 3.0,
    "chassis.front_axle.shock_absorber.degressivity_rebound": 1.0,
    "chassis.front_axle.wheel.inertia": 61.0,
    "chassis.front_axle.final_drive.ratio": 7.8,
    "chassis.front_axle.final_drive.efficiency": 0.95,
    "chassis.front_axle.tyre.contact.radius": 0.580,
    "chassis.front_axle.tyre.rolling.radius": 0.580,
    "chassis.front_axle.tyre.rolling.width": 0.1,
    "chassis.front_axle.tyre.spring.stiffness": 1.598e6,
    "chassis.front_axle.tyre.damper.damping": 1.88e3,
    "chassis.front_axle.tyre.slip.stiffness": 17.7,
    "chassis.front_axle.tyre.slip.friction": 0.8,
    "chassis.front_axle.tyre.slip.speed_floor": 1.0,
    "chassis.front_axle.brake.lining.torque": 15000.0,
    "chassis.front_axle.brake.lining.width": 0.1,
    "chassis.front_axle.brake.viscous.damping": 0.5,
    "chassis.weight.gravity": 9.81,
    "driver.period": 0.01,
    "driver.preview": 0.3,
    "driver.start_preview": 0.6,
    "driver.proportional_gain": 15000.0,
    "driver.integral_gain": 2500.0,
    "driver.integral_limit": 20e3,
    "driver.wheel_radius": 0.580,
    "driver.final_drive_ratio": 7.8,
    "driver.drag_area": 5.0,
    "power_management.period": 0.01,
    "power_management.brake_torque": 15000.0,
    "power_management.to_braking": -60.0,
    "power_management.to_driving": -10.0,
    "power_management.standing_pedal": 0.6,
    "transmission_control.period": 0.01,
    "transmission_control.rest_time": 1.5,
    "transmission_control.hurry_speed": 2200 * RPM,
    "transmission_control.lock_speed": 1150 * RPM,
    "transmission_control.unlock_speed": 1000 * RPM,
    "transmission_control.clutch_torque": 2000.0,
    "transmission_control.clutch_ramp": 0.5,
    "transmission_control.engagement_rate": 2.5,
}
HYBRID = {
    "chassis.body.mass": 11300.0,
    "driver.mass": 14500.0,
    "chassis.front_suspension_load": pytest.approx(36500.4, abs=0.05),
    "chassis.rear_suspension_load": pytest.approx(37176.3, abs=0.05),
    "chassis.front_axle.static_load": pytest.approx(46310.4, abs=0.05),
    "chassis.rear_front_axle.static_load": pytest.approx(47967.3, abs=0.05),
    "chassis.rear_rear_axle.static_load": pytest.approx(47967.3, abs=0.05),
    "hydraulics.actuator.time_constant": 0.15,
    "hydraulics.gearbox.gear.ratio": 1.25,
    "hydraulics.gearbox.efficiency": 0.98,
    f"{UNIT}.rotating_group.inertia": 0.10,
    f"{UNIT}.ideal.displacement": pytest.approx(3.98e-5, abs=2e-8),
    f"{UNIT}.torque_loss.viscous": 2.35e4,
    f"{UNIT}.torque_loss.coulomb": 0.0537,
    f"{UNIT}.torque_loss.hydrodynamic": 53.6,
    f"{UNIT}.torque_loss.viscosity": 0.0278,
    f"{UNIT}.torque_loss.density": 870.0,
    f"{UNIT}.torque_loss.isolation_width": 0.02,
    f"{UNIT}.torque_loss.width": 1.0,
    f"{UNIT}.volumetric_loss.laminar": 4.26e-9,
    f"{UNIT}.volumetric_loss.turbulent": 0.0,
    f"{UNIT}.volumetric_loss.bulk_modulus": 1.7e9,
    "hydraulics.accumulator.volume": 0.120,
    "hydraulics.accumulator.gas_mass": 16.64,
    "hydraulics.accumulator.start_oil": pytest.approx(4.385e-3, abs=5e-7),
    "hydraulics.accumulator.ambient_pressure": 101325.0,
    "hydraulics.accumulator.ambient_temperature": 300.0,
    "hydraulics.accumulator.liner_heat_capacity": 0.0,
    "hydraulics.accumulator_wall.conductance": 100.0,
    "hydraulics.reservoir.volume": 0.200,
    "hydraulics.reservoir.gas_mass": 0.90,
    "hydraulics.reservoir.start_oil": pytest.approx(0.0756, abs=5e-5),
    "hydraulics.reservoir_wall.conductance": 20.0,
    "hydraulics.accumulator_line.resistance": 1.38e9,
    "hydraulics.reservoir_line.resistance": 3.5e8,
    "power_management.lowest_pressure": 13e6,
    "power_management.lowest_pressure_fade": 0.5e6,
    "power_management.lowest_oil": 1e-3,
    "power_management.lowest_oil_fade": 3e-3,
    "power_management.highest_pressure": 35e6,
    "power_management.highest_pressure_margin": 0.3e6,
    "power_management.highest_pressure_fade": 1e6,
    "power_management.pump_speed": 0.9,
    "power_management.pump_speed_fade": 0.6,
    "power_management.gear_ratio": 1.25,
    "power_management.unit_efficiency": 0.98,
    "power_management.displacement": pytest.approx(3.98e-5, abs=2e-8),
}
CONVENTIONAL = {
    "chassis.body.mass": 10700.0,
    "driver.mass": 13900.0,
    "chassis.front_axle.static_load": pytest.approx(44372.3, abs=0.05),
    "chassis.rear_front_axle.static_load": pytest.approx(45993.3, abs=0.05),
    "chassis.front_suspension_load": pytest.approx(34562.3, abs=0.05),
    "chassis.rear_suspension_load": pytest.approx(35202.3, abs=0.05),
}


def values(compiled):
    symbols = {path: flat.symbol for path, flat in compiled.graph.parameters.items()}
    known = parameter_values(compiled, {})
    return {path: known[symbol] for path, symbol in symbols.items()}


@pytest.mark.parametrize("expected", [COMMON, HYBRID], ids=["common", "hybrid"])
def test_parameters_of_the_hybrid_truck(hybrid, expected):
    found = values(hybrid)
    differing = {p: (found[parse_path(p)], v) for p, v in expected.items() if found[parse_path(p)] != v}
    # Sums of decimal numbers are not exact.
    assert all(given == pytest.approx(wanted, rel=1e-12) for given, wanted in differing.values()), differing


@pytest.mark.parametrize("expected", [COMMON, CONVENTIONAL], ids=["common", "conventional"])
def test_parameters_of_the_conventional_truck(conventional, expected):
    found = values(conventional)
    differing = {p: (found[parse_path(p)], v) for p, v in expected.items() if found[parse_path(p)] != v}
    assert all(given == pytest.approx(wanted, rel=1e-12) for given, wanted in differing.values()), differing


def test_loads_carry_the_truck(hybrid):
    found = values(hybrid)
    loads = [found[parse_path(f"chassis.{a}_axle.static_load")] for a in ("front", "rear_front", "rear_rear")]
    assert sum(loads) == pytest.approx(14500.0 * 9.81)
    moment = sum(load * x for load, x in zip(loads, (0.0, 3.40, 4.80), strict=True))
    assert moment == pytest.approx(9.81 * (11300.0 * 2.75 + 1100.0 * (3.40 + 4.80)))


def test_drivetrain_inertia_at_the_output_in_every_gear():
    found = [1.02 + 0.10 * i * i for i in RATIOS]
    assert found == pytest.approx([5.82, 2.77, 1.52, 1.31, 1.16, 1.10, 1.08], abs=0.006)


def test_tables_of_the_transmission(hybrid):
    tables = hybrid.graph.tables

    def table(path):
        return list(tables[parse_path(path)].values.values)

    assert table("transmission.shift.ratios") == [6.93, 4.18, 2.24, 1.69, 1.20, 0.90, 0.78]
    assert table("transmission.shift.efficiencies") == [0.95, 0.96, 0.97, 0.97, 0.975, 0.975, 0.97]
    lines = {name: [x / RPM for x in table(f"transmission_control.{name}")] for name in ("up_idle", "up_full")}
    assert lines["up_idle"][:6] == pytest.approx([1750, 1850, 1650, 1650, 1700, 1650])
    assert lines["up_full"][:6] == pytest.approx([2100, 2350, 2350, 2350, 2350, 2350])
    assert [x / RPM for x in table("transmission_control.down_idle")[1:]] == pytest.approx([950, 850] + [950] * 4)
    assert [x / RPM for x in table("transmission_control.down_full")[1:]] == pytest.approx([1250, 1150] + [1250] * 4)


# Starts, periods, switches and options, and the acceleration of gravity.
WITHOUT_STATUS = {
    *("start_speed", "start_velocity", "start_compression", "start_temperature", "start", "period"),
    *("torque_scale", "foam_heat_capacity", "liner_heat_capacity", "overrun_demand", "gravity", "share"),
}


@pytest.mark.parametrize("name", ["hybrid", "conventional"])
def test_values_say_how_sure_they_are(name, request):
    parameters = request.getfixturevalue(name).graph.parameters
    own = [p for p in parameters.values() if not leaves(p.value) and p.path.name not in WITHOUT_STATUS]
    unsure = [str(p.path) for p in own if p.status not in ("published", "derived", "estimated")]
    assert not unsure
