"""Small rigs of library components, against closed forms."""

import math

import numpy as np
import pytest

from propermodel.compiler import compile_model
from propermodel.diagnostics import parse_path
from propermodel.library import electrical, hydraulics, thermal
from propermodel.library.control import FirstOrder, RateLimiter, SampledPID
from propermodel.library.mechanics import rotation, translation
from propermodel.library.mechanics.planar import PlanarBody
from propermodel.modelling import Component, Input, Output, Parameter, Scenario, connect, elaborate, parameter
from propermodel.simulation.simulate import simulate


def run(component, stop=1.0, step=1e-4, **inputs):
    scenario = Scenario(stop=stop, inputs={parse_path(name): value for name, value in inputs.items()})
    return simulate(compile_model(elaborate(component)), scenario, step=step, record_every=0.01)


class Pushed(Component):
    force = Input("N")

    source = translation.ForceSource()
    sensor = translation.ForceSensor()
    mass = translation.Mass(mass=4.0)
    motion = translation.MotionSensor()

    connections = (
        connect(source.flange, sensor.a),
        connect(sensor.b, mass.flange, motion.flange),
        connect(force, source.force),
    )


def test_a_force_accelerates_a_mass_and_sensors_tell():
    result = run(Pushed(), force=8.0)
    assert result.at_end("motion.velocity") == pytest.approx(2.0, rel=1e-9)
    assert result.at_end("motion.position") == pytest.approx(1.0, rel=1e-3)
    assert result.at_end("sensor.force") == pytest.approx(8.0)


class Shafts(Component):
    torque = Input("N.m")

    source = rotation.TorqueSource()
    sensor = rotation.TorqueSensor()
    gear = rotation.Gear(ratio=3.0)
    split = rotation.Differential(share=0.3)
    left = rotation.RotatingInertia(inertia=2.0)
    right = rotation.RotatingInertia(inertia=1.0)
    motion = rotation.RotationSensor()

    connections = (
        connect(source.shaft, sensor.a),
        connect(sensor.b, gear.a, motion.shaft),
        connect(gear.b, split.drive),
        connect(split.left, left.shaft),
        connect(split.right, right.shaft),
        connect(torque, source.torque),
    )


def test_a_differential_shares_torque_and_weighs_speeds():
    result = run(Shafts(), torque=10.0)
    left, right = 0.3 * 30.0 / 2.0, 0.7 * 30.0 / 1.0
    assert result.at_end("left.shaft.flow") == pytest.approx(left, rel=1e-9)
    assert result.at_end("right.shaft.flow") == pytest.approx(right, rel=1e-9)
    assert result.at_end("motion.speed") == pytest.approx(3.0 * (0.3 * left + 0.7 * right), rel=1e-9)
    assert result.at_end("sensor.torque") == pytest.approx(10.0)


class Loaded(Component):
    source = rotation.SpeedSource()
    gear = rotation.LossyGear(ratio=2.0, efficiency=0.9)
    load = rotation.ViscousFriction(damping=0.5)
    speed = Input("rad/s")

    connections = (
        connect(source.shaft, gear.a),
        connect(gear.b, load.shaft),
        connect(speed, source.speed),
    )


def test_a_lossy_gear_needs_more_torque_than_it_gives():
    result = run(Loaded(), stop=0.1, speed=100.0)
    assert result.at_end("load.shaft.effort") == pytest.approx(25.0)
    assert result.at_end("gear.a.effort") == pytest.approx(25.0 / 2.0 / 0.9)


class Motor(Component):
    voltage = Input("V")

    supply = electrical.VoltageSource()
    meter = electrical.CurrentSensor()
    motor = electrical.DCMotor(resistance=0.5, inductance=1e-3, constant=0.1, inertia=1e-3, friction=1e-3)
    free_end = rotation.RotationSensor()

    connections = (
        connect(supply.pin, meter.a),
        connect(meter.b, motor.pin),
        connect(motor.shaft, free_end.shaft),
        connect(voltage, supply.voltage),
    )


def test_steady_speed_of_a_motor():
    result = run(Motor(), stop=2.0, voltage=12.0)
    speed = 12.0 * 0.1 / (0.1**2 + 0.5 * 1e-3)
    assert result.at_end("free_end.speed") == pytest.approx(speed, rel=1e-6)
    assert result.at_end("meter.current") == pytest.approx(1e-3 * speed / 0.1, rel=1e-6)


class Discharge(Component):
    capacitor = electrical.Capacitor(capacitance=1e-3, start_voltage=10.0)
    resistor = electrical.Resistor(resistance=200.0)
    ground = electrical.Ground()
    meter = electrical.VoltageSensor()

    connections = (
        connect(capacitor.a, resistor.a, meter.pin),
        connect(capacitor.b, resistor.b, ground.pin),
    )


def test_a_capacitor_discharges_exponentially():
    assert run(Discharge(), stop=0.2).at_end("meter.voltage") == pytest.approx(10.0 * math.exp(-1.0), rel=1e-3)


class Cooling(Component):
    body = thermal.HeatCapacity(capacity=500.0, start_temperature=360.0)
    wall = thermal.WallConductance(conductance=50.0)
    sensor = thermal.TemperatureSensor()

    connections = (connect(body.port, wall.port, sensor.port),)


def test_a_warm_body_cools_exponentially():
    result = run(Cooling(), stop=10.0, step=1e-3)
    assert result.at_end("sensor.temperature") == pytest.approx(300.0 + 60.0 * math.exp(-1.0), rel=1e-4)


class Charging(Component):
    inflow = Input("m3/s")

    source = hydraulics.VolumeFlowSource()
    meter = hydraulics.FlowSensor()
    line = hydraulics.LineResistance(resistance=1e9)
    chamber = hydraulics.OilChamber(volume=1e-3)
    gauge = hydraulics.PressureSensor()

    connections = (
        connect(source.port, meter.a),
        connect(meter.b, line.a, gauge.port),
        connect(line.b, chamber.port),
        connect(inflow, source.volume_flow),
    )


def test_oil_is_compressed_in_a_chamber():
    result = run(Charging(), stop=0.1, inflow=1e-5)
    assert result.at_end("meter.volume_flow") == pytest.approx(1e-5)
    assert result.at_end("chamber.port.effort") == pytest.approx(1.7e9 / 1e-3 * 1e-6, rel=1e-6)
    assert result.at_end("gauge.pressure") == pytest.approx(1.7e6 + 1e9 * 1e-10, rel=1e-6)


class Bottle(Component):
    """A gas vessel filled at constant flow with an insulated wall."""

    inflow = Input("m3/s")

    source = hydraulics.VolumeFlowSource()
    vessel = hydraulics.GasVessel(volume=0.12, gas_mass=16.64)
    wall = thermal.HeatSource()
    no_heat: Parameter = parameter("W/K", default=0.0)

    connections = (
        connect(source.port, vessel.oil),
        connect(vessel.wall, wall.port),
        connect(inflow, source.volume_flow),
        connect(no_heat, wall.entropy_flow),
    )


def test_gas_compressed_without_heat_keeps_its_entropy_and_warms_up():
    # From 12.5 MPa to 35 MPa adiabatically: 51.4 L of oil, 406 K.
    result = run(Bottle(), stop=5.0, step=1e-4, inflow=0.0514 / 5.0)
    assert result.at_end("vessel.oil.effort") == pytest.approx(35e6, rel=0.01)
    assert result.at_end("vessel.wall.effort") == pytest.approx(106.0, abs=1.0)
    assert result.at_end("vessel.wall.displacement") == pytest.approx(
        result.at_start("vessel.wall.displacement"), abs=0.05
    )


class Thrown(Component):
    body = PlanarBody(mass=3.0, pitch_inertia=2.0, start_speed=5.0)
    spin = rotation.SpeedSource()
    forward = translation.MotionSensor()
    upward = translation.MotionSensor()
    pitch_rate = Input("rad/s")

    connections = (
        connect(body.forward, forward.flange),
        connect(body.vertical, upward.flange),
        connect(body.pitch, spin.shaft),
        connect(pitch_rate, spin.speed),
    )


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
def test_a_free_body_flies_straight_while_its_frame_turns():
    # Without forces the velocity keeps its direction in space, so in a frame that pitches up it turns down.
    result = run(Thrown(), stop=1.0, step=1e-5, pitch_rate=0.7)
    assert result.at_end("forward.velocity") == pytest.approx(5.0 * math.cos(0.7), rel=1e-4)
    assert result.at_end("upward.velocity") == pytest.approx(-5.0 * math.sin(0.7), rel=1e-4)


class Lagged(Component):
    given = Input("1")
    slow = Output("1")
    limited = Output("1")

    lag = FirstOrder(time_constant=0.5)
    limiter = RateLimiter(rate=0.8)

    connections = (
        connect(given, lag.signal, limiter.signal),
        connect(lag.result, slow),
        connect(limiter.result, limited),
    )


def test_a_lag_and_a_rate_limit():
    result = run(Lagged(), given=2.0)
    assert result.at_end("slow") == pytest.approx(2.0 * (1.0 - math.exp(-2.0)), rel=1e-3)
    assert result.at_end("limited") == pytest.approx(0.8, rel=1e-3)


class Heater(Component):
    """A plant of first order under a sampled PID controller with limits."""

    setpoint = Input("1")

    plant = FirstOrder(time_constant=2.0)
    controller = SampledPID(proportional_gain=2.0, integral_gain=1.5, low=0.0, high=1.5)

    connections = (
        connect(setpoint, controller.setpoint),
        connect(plant.result, controller.measurement),
        connect(controller.command, plant.signal),
    )


def test_a_pid_controller_settles_without_error_and_without_windup():
    result = run(Heater(), stop=20.0, step=1e-3, setpoint=1.0)
    measured = result["plant.result"]
    assert measured[-1] == pytest.approx(1.0, abs=1e-3)
    assert np.max(result["controller.command"]) <= 1.5
    assert np.max(measured) < 1.15
