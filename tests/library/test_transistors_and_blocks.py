"""Transistors, thyristors, storage that signals change, freewheels and signal blocks, against independent solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

import propermodel as pm
from propermodel.expressions import time
from propermodel.library.control import Constant, Derivative, LeadLag, Ramp, Relay, Selector, Sine
from propermodel.library.electrical import (
    ConstantVoltage,
    FloatingVoltageSource,
    Ground,
    IdealThyristor,
    NPNTransistor,
    PNPTransistor,
    Resistor,
    VariableCapacitor,
    VariableInductor,
)
from propermodel.library.mechanics.rotation import Freewheel, RotatingInertia, SpeedSource, ViscousFriction


def simulate(component: pm.Component, stop: float, step: float) -> pm.Trajectory:
    run = pm.simulate(
        pm.compile_model(pm.elaborate(component)),
        pm.Scenario(stop=stop),
        method=pm.Method.RK4,
        step=step,
        record_every=stop / 500.0,
    )
    assert run.ending.is_complete, run.ending.message
    return run


# -- transistors -------------------------------------------------------------------------------------------


def amplifier(kind: type[NPNTransistor | PNPTransistor], supplied: float, base_resistance: float) -> pm.Component:
    class Amplifier(pm.Component):
        """A stage with its emitter on ground, without storage."""

        supply = ConstantVoltage(voltage=supplied)
        base_resistor = Resistor(resistance=base_resistance)
        collector_resistor = Resistor(resistance=1e3)
        transistor = kind(saturation_current=1e-14, forward_gain=80.0, reverse_gain=2.0, leakage=0.0)
        ground = Ground()

        connections = (
            pm.connect(supply.p, base_resistor.a, collector_resistor.a),
            pm.connect(base_resistor.b, transistor.base),
            pm.connect(collector_resistor.b, transistor.collector),
            pm.connect(transistor.emitter, supply.n, ground.pin),
        )

    return Amplifier()


def nodal(supplied: float, base_resistance: float) -> tuple[float, float]:
    """Voltages of base and collector of the n-p-n stage by Kirchhoff's current law."""

    def currents(v: np.ndarray) -> list[float]:
        base, collector = v
        forward, reverse = (1e-14 * math.expm1(min(u, 0.9) / 0.02585) for u in (base, base - collector))
        return [
            1e3 * ((supplied - base) / base_resistance - forward / 80.0 - reverse / 2.0),
            1e3 * ((supplied - collector) / 1e3 - forward + reverse + reverse / 2.0),
        ]

    found, _, code, message = fsolve(currents, [0.65, 0.5 * supplied], full_output=True, xtol=1e-13)
    assert code == 1, message
    return float(found[0]), float(found[1])


@pytest.mark.parametrize("base_resistance", [2e6, 5e4], ids=["amplifies", "saturates"])
def test_bipolar_transistors_meet_kirchhoff(base_resistance: float):
    base, collector = nodal(5.0, base_resistance)
    assert (collector < 0.3) == (base_resistance < 1e5)  # both regions are met
    for kind, sign in ((NPNTransistor, 1.0), (PNPTransistor, -1.0)):
        run = simulate(amplifier(kind, sign * 5.0, base_resistance), 1e-3, 1e-3)
        found = run["transistor.emitter_junction.effort"][0]
        assert found == pytest.approx(sign * base, rel=1e-7)
        assert found - run["transistor.collector_junction.effort"][0] == pytest.approx(sign * collector, rel=1e-6)


def test_a_thyristor_lets_through_what_is_left_of_a_half_wave():
    class Dimmer(pm.Component):
        """A lamp at the mains; the gate is on from a quarter of each period on."""

        mains = FloatingVoltageSource()
        voltage = Sine(amplitude=100.0, frequency=50.0)
        lag = Sine(amplitude=1.0, frequency=50.0, phase=-math.pi / 3.0)
        thyristor = IdealThyristor()
        lamp = Resistor(resistance=10.0)
        ground = Ground()

        connections = (
            pm.connect(mains.a, thyristor.a),
            pm.connect(thyristor.b, lamp.a),
            pm.connect(lamp.b, mains.b, ground.pin),
            pm.connect(voltage.result * pm.quantity(1.0, "V"), mains.voltage),
            pm.connect(pm.where(lag.result > 0.0, 1.0, 0.0), thyristor.gate),
        )

    run = simulate(Dimmer(), 0.06, 1e-5)
    # Mean power of the angles from 60 to 180 degrees of every period.
    angle = math.pi / 3.0
    mean = 100.0**2 / 10.0 / (2.0 * math.pi) * (0.5 * (math.pi - angle) + 0.25 * math.sin(2.0 * angle))
    assert run.work("lamp.port") == pytest.approx(0.06 * mean, rel=1e-6)
    closings = [event.time for event in run.events if "thyristor" in str(event.element)]
    np.testing.assert_allclose(np.asarray(closings)[:3], [0.02 / 6.0, 0.01, 0.02 + 0.02 / 6.0], atol=1e-8)


# -- storage that a signal changes --------------------------------------------------------------------------


def test_a_capacitor_that_grows_is_charged_as_its_equation_says():
    class Plates(pm.Component):
        """A battery charges plates that somebody pushes together."""

        battery = ConstantVoltage(voltage=10.0)
        resistor = Resistor(resistance=1e3)
        plates = VariableCapacitor()
        capacitance = Ramp(before=1e-6, after=3e-6, end=2e-3)
        ground = Ground()

        connections = (
            pm.connect(battery.p, resistor.a),
            pm.connect(resistor.b, plates.a),
            pm.connect(plates.b, battery.n, ground.pin),
            pm.connect(capacitance.result * pm.quantity(1.0, "F"), plates.capacitance),
        )

    run = simulate(Plates(), 2e-3, 1e-6)
    growth, resistance = 1e-3, 1e3  # F/s, Ohm
    along = 1e-6 + growth * run.time
    share = 10.0 / (1.0 + resistance * growth)
    charge = share * along - share * 1e-6 * (along / 1e-6) ** (-1.0 / (resistance * growth))
    np.testing.assert_allclose(run["plates.port.effort"], charge / along, rtol=1e-9, atol=1e-9)
    assert abs(pm.energy_balance(run).relative_residual) < 1e-9


def test_a_coil_that_grows_takes_its_current_as_its_equation_says():
    class Coil(pm.Component):
        """A battery on a coil whose iron somebody pushes in."""

        battery = ConstantVoltage(voltage=10.0)
        resistor = Resistor(resistance=5.0)
        coil = VariableInductor()
        inductance = Ramp(before=0.1, after=0.3, end=0.1)
        ground = Ground()

        connections = (
            pm.connect(battery.p, resistor.a),
            pm.connect(resistor.b, coil.a),
            pm.connect(coil.b, battery.n, ground.pin),
            pm.connect(inductance.result * pm.quantity(1.0, "H"), coil.inductance),
        )

    run = simulate(Coil(), 0.1, 1e-4)
    growth = 2.0  # H/s
    along = 0.1 + growth * run.time
    share = 10.0 / (growth + 5.0)
    flux = share * along - share * 0.1 * (along / 0.1) ** (-5.0 / growth)
    np.testing.assert_allclose(run["coil.port.flow"], flux / along, rtol=1e-8, atol=1e-9)


# -- a freewheel ---------------------------------------------------------------------------------------------


def test_a_freewheel_drives_and_lets_run_on():
    rate, decay = 2.0 * math.pi, 0.5

    class Ratchet(pm.Component):
        """A pedal that goes to and fro, and a wheel that runs on."""

        pedal = SpeedSource()
        speed = Sine(amplitude=10.0, frequency=1.0)
        freewheel = Freewheel()
        wheel = RotatingInertia(inertia=2.0)
        bearing = ViscousFriction(damping=2.0 * decay)

        connections = (
            pm.connect(pedal.shaft, freewheel.a),
            pm.connect(freewheel.b, wheel.shaft, bearing.shaft),
            pm.connect(speed.result * pm.quantity(1.0, "rad/s"), pedal.speed),
        )

    run = simulate(Ratchet(), 1.2, 1e-3)
    # It lets go when the wheel would be slower by itself: at tan(w t) = -w / d.
    parts = (math.pi - math.atan(rate / decay)) / rate
    peak = 10.0 * math.sin(rate * parts)
    free = peak * np.exp(-decay * (run.time - parts))
    expected = np.where(
        run.time < parts, 10.0 * np.sin(rate * run.time), np.maximum(free, 10 * np.sin(rate * run.time))
    )
    np.testing.assert_allclose(run["wheel.shaft.flow"], expected, atol=2e-6)  # it locks at a slip of 1e-6
    assert run["freewheel.port.effort"].min() > -1e-6  # it never pulls back
    assert abs(pm.energy_balance(run).relative_residual) < 1e-9


# -- signals -----------------------------------------------------------------------------------------------


class Blocks(pm.Component):
    """A wave through several blocks."""

    wave = Sine(amplitude=2.0, frequency=1.0)
    derivative = Derivative(filter_time=0.01)
    compensator = LeadLag(lead_time=0.2, lag_time=0.05)
    relay = Relay(high=1.0, low=-1.0, on=3.0, off=-3.0)
    zero = Constant(value=0.0)
    selector = Selector()

    connections = (
        pm.connect(wave.result, derivative.signal, compensator.signal, relay.signal, selector.first),
        pm.connect(zero.result, selector.second),
        pm.connect(pm.where(time > pm.quantity(2.0, "s"), 1.0, 0.0), selector.choice),
    )


def test_blocks_answer_a_wave_by_their_transfer_functions():
    run = simulate(Blocks(), 4.0, 1e-3)
    s = 2j * math.pi
    t = run.time
    settled = t > 1.0
    for name, gain in (("derivative", s / (1.0 + 0.01 * s)), ("compensator", (1.0 + 0.2 * s) / (1.0 + 0.05 * s))):
        expected = np.imag(2.0 * gain * np.exp(s * t))
        np.testing.assert_allclose(run[f"{name}.result"][settled], expected[settled], atol=1e-6)
    np.testing.assert_array_equal(run["selector.result"][t < 1.99], 0.0)
    np.testing.assert_array_equal(run["selector.result"][t > 2.01], run["wave.result"][t > 2.01])


def test_a_relay_switches_at_its_thresholds():
    run = simulate(Blocks(), 2.0, 1e-3)
    times = [event.time for event in run.events]
    np.testing.assert_allclose(times, [1 / 12, 7 / 12, 13 / 12, 19 / 12], atol=1e-9)
    held = (run.time > 0.1) & (run.time < 0.58)
    np.testing.assert_array_equal(run["relay.result"][held], 3.0)
    np.testing.assert_array_equal(run["relay.result"][run.time < 0.08], -3.0)
