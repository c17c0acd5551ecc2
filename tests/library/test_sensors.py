"""Every sensor of the shelves against a closed form; none takes power."""

from __future__ import annotations

import numpy as np
import pytest

import propermodel as pm
from propermodel.library import electrical, hydraulics, pseudo_thermal, thermal
from propermodel.library.mechanics import rotation, translation

SHELVES = (electrical, translation, rotation, hydraulics, thermal, pseudo_thermal)


class Discharge(pm.Component):
    """A capacitor of 0.5 F at 4 V and a resistor of 2 Ohm: v = 4 exp(-t)."""

    capacitor = electrical.Capacitor(capacitance=0.5, start_voltage=4.0)
    charge = electrical.ChargeSensor(start=1.0)
    current = electrical.CurrentSensor()
    resistor = electrical.Resistor(resistance=2.0)
    between = electrical.FloatingVoltageSensor()
    against_ground = electrical.VoltageSensor()
    flux = electrical.FluxLinkageSensor(start=0.5)
    ground = electrical.Ground()

    connections = (
        pm.connect(capacitor.a, charge.a, against_ground.pin),
        pm.connect(charge.b, current.a),
        pm.connect(current.b, resistor.a, between.a, flux.a),
        pm.connect(ground.pin, capacitor.b, resistor.b, between.b, flux.b),
    )


class Braked(pm.Component):
    """A mass of 2 kg at 3 m/s and a damper of 1 N.s/m: v = 3 exp(-t/2)."""

    mass = translation.Mass(mass=2.0, start_velocity=3.0)
    impulse = translation.ImpulseSensor()
    force = translation.ForceSensor()
    damper = translation.Damper(damping=1.0)
    wall = translation.Fixed()
    motion = translation.MotionSensor(start=1.0)
    relative = translation.RelativeMotionSensor(start=-1.0)

    connections = (
        pm.connect(mass.flange, impulse.a, motion.flange, relative.b),
        pm.connect(impulse.b, force.a),
        pm.connect(force.b, damper.a),
        pm.connect(damper.b, wall.flange, relative.a),
    )


class Spinning(pm.Component):
    """A rotor of 2 kg.m2 at 3 rad/s and a friction of 1 N.m.s/rad: w = 3 exp(-t/2)."""

    rotor = rotation.RotatingInertia(inertia=2.0, start_speed=3.0)
    impulse = rotation.AngularImpulseSensor()
    torque = rotation.TorqueSensor()
    friction = rotation.RotationalDamper(damping=1.0)
    wall = rotation.FixedShaft()
    turning = rotation.RotationSensor(start=1.0)
    relative = rotation.RelativeRotationSensor(start=-1.0)

    connections = (
        pm.connect(rotor.shaft, impulse.a, turning.shaft, relative.b),
        pm.connect(impulse.b, torque.a),
        pm.connect(torque.b, friction.a),
        pm.connect(friction.b, wall.shaft, relative.a),
    )


class Draining(pm.Component):
    """Oil of 1e-9 m3/Pa at 4 bar and a leakage of 1e-9 m3/(s.Pa): p = 4 exp(-t) bar."""

    chamber = hydraulics.OilChamber(volume=1.0, bulk_modulus=1e9, start_pressure=4e5)
    volume = hydraulics.VolumeSensor()
    flow = hydraulics.FlowSensor()
    leakage = hydraulics.Leakage(conductance=1e-9)
    pressure = hydraulics.PressureSensor()
    drop = hydraulics.PressureDropSensor()
    momentum = hydraulics.PressureMomentumSensor()
    tank = hydraulics.OpenTank()

    connections = (
        pm.connect(chamber.port, volume.a, pressure.port),
        pm.connect(volume.b, flow.a),
        pm.connect(flow.b, leakage.a, drop.a, momentum.a),
        pm.connect(leakage.b, drop.b, momentum.b, tank.port),
    )


class Cooling(pm.Component):
    """A body of 10 J/K at 400 K and a wall of 5 W/K to ambient at 300 K: T = 300 + 100 exp(-t/2)."""

    body = thermal.HeatCapacity(capacity=10.0, start_temperature=400.0)
    entropy = thermal.EntropySensor()
    entropy_flow = thermal.EntropyFlowSensor()
    heat_flow = thermal.HeatFlowSensor()
    wall = thermal.Conduction(conductance=5.0)
    temperature = thermal.TemperatureSensor()
    ambient = thermal.Ambient()

    connections = (
        pm.connect(body.port, entropy.a, temperature.port),
        pm.connect(entropy.b, entropy_flow.a),
        pm.connect(entropy_flow.b, heat_flow.a),
        pm.connect(heat_flow.b, wall.a),
        pm.connect(wall.b, ambient.port),
    )


class PseudoCooling(pm.Component):
    """The same body with temperature and heat flow."""

    body = pseudo_thermal.HeatStore(capacity=10.0, start_temperature=400.0)
    heat = pseudo_thermal.HeatSensor()
    heat_flow = pseudo_thermal.HeatFlowSensor()
    wall = pseudo_thermal.ThermalConductor(conductance=5.0)
    temperature = pseudo_thermal.TemperatureSensor()
    ambient = pseudo_thermal.FixedTemperature(temperature=300.0)

    connections = (
        pm.connect(body.port, heat.a, temperature.port),
        pm.connect(heat.b, heat_flow.a),
        pm.connect(heat_flow.b, wall.a),
        pm.connect(wall.b, ambient.port),
    )


def fall(tau: float, height: float):
    return lambda t: height * np.exp(-t / tau)


def rise(tau: float, height: float, start: float = 0.0):
    return lambda t: start + height * (1.0 - np.exp(-t / tau))


ANSWERS = {
    Discharge: {
        "against_ground.voltage": fall(1.0, 4.0),
        "between.voltage": fall(1.0, 4.0),
        "current.current": fall(1.0, 2.0),
        "charge.current": fall(1.0, 2.0),
        "charge.charge": rise(1.0, 2.0, 1.0),
        "flux.voltage": fall(1.0, 4.0),
        "flux.flux_linkage": rise(1.0, 4.0, 0.5),
    },
    Braked: {
        "motion.velocity": fall(2.0, 3.0),
        "motion.position": rise(2.0, 6.0, 1.0),
        "relative.velocity": fall(2.0, -3.0),
        "relative.position": rise(2.0, -6.0, -1.0),
        "force.force": fall(2.0, 3.0),
        "impulse.force": fall(2.0, 3.0),
        "impulse.impulse": rise(2.0, 6.0),
    },
    Spinning: {
        "turning.speed": fall(2.0, 3.0),
        "turning.angle": rise(2.0, 6.0, 1.0),
        "relative.speed": fall(2.0, -3.0),
        "relative.angle": rise(2.0, -6.0, -1.0),
        "torque.torque": fall(2.0, 3.0),
        "impulse.torque": fall(2.0, 3.0),
        "impulse.impulse": rise(2.0, 6.0),
    },
    Draining: {
        "pressure.pressure": fall(1.0, 4e5),
        "drop.pressure_drop": fall(1.0, 4e5),
        "flow.volume_flow": fall(1.0, 4e-4),
        "volume.volume_flow": fall(1.0, 4e-4),
        "volume.volume": rise(1.0, 4e-4),
        "momentum.pressure_drop": fall(1.0, 4e5),
        "momentum.momentum": rise(1.0, 4e5),
    },
    Cooling: {
        "temperature.temperature": lambda t: 300.0 + 100.0 * np.exp(-t / 2.0),
        "heat_flow.heat_flow": fall(2.0, 500.0),
        "entropy_flow.entropy_flow": lambda t: 500.0 * np.exp(-t / 2.0) / (300.0 + 100.0 * np.exp(-t / 2.0)),
        "entropy.entropy_flow": lambda t: 500.0 * np.exp(-t / 2.0) / (300.0 + 100.0 * np.exp(-t / 2.0)),
        "entropy.entropy": lambda t: 10.0 * np.log(400.0 / (300.0 + 100.0 * np.exp(-t / 2.0))),
    },
    PseudoCooling: {
        "temperature.temperature": lambda t: 300.0 + 100.0 * np.exp(-t / 2.0),
        "heat_flow.heat_flow": fall(2.0, 500.0),
        "heat.heat_flow": fall(2.0, 500.0),
        "heat.heat": rise(2.0, 1000.0),
    },
}


@pytest.mark.parametrize("component", ANSWERS, ids=lambda component: component.__name__)
def test_sensors_show_the_closed_form_and_take_no_power(component):
    run = pm.simulate(
        pm.compile_model(pm.elaborate(component())), pm.Scenario(stop=1.0), method=pm.Method.RK4, step=1e-3
    )
    for path, answer in ANSWERS[component].items():
        expected = answer(run.time)
        assert run[path] == pytest.approx(expected, rel=1e-8, abs=1e-9 * np.max(np.abs(expected))), path
    sensors = {path.partition(".")[0] for path in ANSWERS[component]}
    balance = pm.energy_balance(run)
    for part in (balance, *balance.pseudo.values()):
        assert part.relative_residual < 1e-6
        assert not [path for path, work in part.sources if path[0] in sensors and work != 0.0]


def test_every_sensor_of_the_shelves_is_measured_here():
    shelved = {getattr(shelf, name) for shelf in SHELVES for name in shelf.__all__ if name.endswith("Sensor")}
    used = {type(part) for rig in ANSWERS for part in rig.declarations.values()}
    assert shelved
    assert shelved <= used


def test_the_models_of_sensors_go_to_documents_and_back(tmp_path):
    for component in ANSWERS:
        model = pm.elaborate(component())
        pm.write_model(model, tmp_path / "model.json")
        assert pm.read_model(tmp_path / "model.json") == model
