"""Sources that never change, brakes, fans and play, in small machines with closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.library import hydraulics, thermal
from propermodel.library.mechanics import rotation, translation
from propermodel.library.mechanics.rotation import Backlash, Brake, ConstantTorque, FixedShaft, RotatingInertia
from propermodel.modelling import evaluate


def run_of(component: pm.Component, stop: float, step: float = 1e-4, **inputs: float) -> pm.Trajectory:
    scenario = pm.Scenario(stop=stop, inputs=dict(inputs))
    run = pm.simulate(pm.compile_model(pm.elaborate(component)), scenario, step=step, method=pm.Method.RK4)
    assert run.ending.is_complete
    return run


class Pushed(pm.Component):
    """A force on a mass with a damper."""

    force = translation.ConstantForce(force=3.0)
    mass = translation.Mass(mass=2.0)
    damper = translation.Damper(damping=4.0)
    belt = translation.ConstantVelocity(velocity=1.5)

    connections = (pm.connect(force.flange, mass.flange, damper.a), pm.connect(damper.b, belt.flange))


def test_a_force_pushes_against_a_damper_on_a_belt():
    run = run_of(Pushed(), 2.0)
    expected = (1.5 + 3.0 / 4.0) * (1.0 - np.exp(-run.time * 4.0 / 2.0))
    np.testing.assert_allclose(run["mass.flange.flow"], expected, rtol=1e-9, atol=1e-12)


class Fan(pm.Component):
    """A motor on a fan."""

    motor = ConstantTorque(torque=2.0)
    rotor = RotatingInertia(inertia=0.5)
    fan = rotation.QuadraticTorque(nominal_torque=2.0, nominal_speed=10.0)

    connections = (pm.connect(motor.shaft, rotor.shaft, fan.shaft),)


def test_a_fan_comes_to_its_speed():
    run = run_of(Fan(), 8.0)
    np.testing.assert_allclose(run["rotor.shaft.flow"], 10.0 * np.tanh(run.time * 2.0 / (0.5 * 10.0)), rtol=1e-8)


class Driven(pm.Component):
    """A shaft at one speed turns a damper."""

    drive = rotation.ConstantSpeed(speed=7.0)
    damper = rotation.ViscousFriction(damping=0.3)
    rotor = RotatingInertia(inertia=1.0)
    coupling = rotation.RotationalDamper(damping=2.0)

    connections = (
        pm.connect(drive.shaft, damper.shaft, coupling.a),
        pm.connect(coupling.b, rotor.shaft),
    )


def test_a_given_speed_costs_what_it_takes():
    run = run_of(Driven(), 1.0)
    assert run["damper.shaft.effort"][-1] == pytest.approx(2.1)
    np.testing.assert_allclose(run["rotor.shaft.flow"], 7.0 * (1.0 - np.exp(-2.0 * run.time)), rtol=1e-9, atol=1e-12)


class Braked(pm.Component):
    """A spinning disc with a brake."""

    capacity = pm.Input("N.m")

    disc = RotatingInertia(inertia=0.2, start_speed=30.0)
    brake = Brake()

    connections = (pm.connect(disc.shaft, brake.shaft), pm.connect(capacity, brake.capacity))


def test_a_brake_stops_a_disc_and_holds_it():
    run = run_of(Braked(), 2.0, step=1e-3, capacity=6.0)
    np.testing.assert_allclose(run["disc.shaft.flow"], np.maximum(30.0 - 30.0 * run.time, 0.0), atol=1e-9)
    (event,) = [event for event in run.events if event.time > 0.0]
    assert event.time == pytest.approx(1.0, abs=1e-9)
    assert pm.energy_balance(run).dissipated == pytest.approx(0.5 * 0.2 * 30.0**2, rel=1e-9)


class Rattling(pm.Component):
    """A rotor between flanks."""

    rotor = RotatingInertia(inertia=0.1, start_speed=2.0)
    play = Backlash(stiffness=1e3, play=0.2)
    wall = FixedShaft()

    connections = (pm.connect(rotor.shaft, play.a), pm.connect(play.b, wall.shaft))


def test_a_rotor_flies_through_play_and_swings_back_at_a_flank():
    period = 2 * 0.2 / 2.0 + 2 * math.pi * math.sqrt(0.1 / 1e3)  # twice across, and one half swing at either flank
    run = run_of(Rattling(), period, step=period / 20000)
    assert run.at_end(pm.Path(("rotor", "shaft", "flow"))) == pytest.approx(2.0, rel=1e-5)
    assert run.at_end(pm.Path(("play", "displacement"))) == pytest.approx(0.0, abs=1e-5)
    assert pm.energy_balance(run).relative_residual < 1e-6


def test_play_carries_nothing():
    play = Backlash(stiffness=100.0, play=0.2)
    assert [evaluate(play.effort, x) for x in (-0.3, -0.05, 0.1, 0.25)] == pytest.approx([-20.0, 0.0, 0.0, 15.0])


class Filled(pm.Component):
    """A pump and a pressure feed a tank through a leakage."""

    pump = hydraulics.ConstantVolumeFlow(volume_flow=1e-4)
    head = hydraulics.ConstantPressure(pressure=2e5)
    pipe = hydraulics.Leakage(conductance=1e-9)
    chamber = hydraulics.LevelTank(area=0.01, density=1000.0, gravity=10.0)

    connections = (pm.connect(pump.port, pipe.b, chamber.port), pm.connect(head.port, pipe.a))


def test_a_tank_fills_from_a_pump_and_a_pressure():
    run = run_of(Filled(), 100.0, step=1e-2)
    level = 2e5 + 1e-4 / 1e-9
    expected = level * (1.0 - np.exp(-run.time * 1e-9 * 1000.0 * 10.0 / 0.01))
    np.testing.assert_allclose(run["chamber.port.effort"], expected, rtol=1e-9, atol=1e-6)


class Warmed(pm.Component):
    """A heater and a wall to a warm room."""

    heater = thermal.ConstantHeatFlow(heat_flow=50.0)
    body = thermal.HeatCapacity(capacity=200.0)
    wall = thermal.Conduction(conductance=5.0)
    room = thermal.FixedTemperature(temperature=310.0)

    connections = (pm.connect(heater.port, body.port, wall.a), pm.connect(wall.b, room.port))


def test_a_heated_body_follows_newtons_law_of_cooling():
    run = run_of(Warmed(), 100.0, step=1e-2)
    expected = 20.0 * (1.0 - np.exp(-run.time * 5.0 / 200.0))  # above the ambient of 300 K
    np.testing.assert_allclose(run["body.port.effort"], expected, rtol=1e-8, atol=1e-9)
