"""Ideal switches and diodes against closed forms, in circuits where their positions decide which states are free."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, Method
from propermodel.library.control import Constant, PulseWidth, Sine
from propermodel.library.electrical import (
    Capacitor,
    CurrentSource,
    FloatingVoltageSource,
    Ground,
    IdealDiode,
    IdealSwitch,
    Inductor,
    Resistor,
    VoltageSource,
)
from propermodel.modelling import Component, Input, TableValues, connect, quantity
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import RunStatus, Trajectory
from tests.physics.systems import close, compiled, run, scenario, system

BACKENDS = pytest.mark.parametrize("backend", list(Backend))
VOLT = quantity(1.0, "V")
AMPLITUDE, FREQUENCY = 20.0, 50.0
OMEGA = 2.0 * math.pi * FREQUENCY


def complements(r: Trajectory, *elements: str) -> None:
    """No power at any recorded instant: an ideal switch has no voltage or no current."""
    for element in elements:
        effort, flow = np.abs(r[f"{element}.port.effort"]), np.abs(r[f"{element}.port.flow"])
        assert np.all(np.minimum(effort / max(effort.max(), 1.0), flow / max(flow.max(), 1.0)) < 1e-12)


def is_one(instant: float) -> TableValues:
    """A command that rises at an instant."""
    return TableValues(((0.0, instant - 1e-9, instant + 1e-9, 10.0),), (0.0, 0.0, 1.0, 1.0))


def is_zero(instant: float) -> TableValues:
    """A command that falls at an instant."""
    return TableValues(((0.0, instant - 1e-9, instant + 1e-9, 10.0),), (1.0, 1.0, 0.0, 0.0))


class HalfWave(Component):
    """A diode between the mains and a resistor: without any state."""

    mains = Sine(amplitude=AMPLITUDE, frequency=FREQUENCY)
    supply = VoltageSource()
    diode = IdealDiode()
    load = Resistor(resistance=100.0)
    ground = Ground()

    connections = (
        connect(VOLT * mains.result, supply.voltage),
        connect(supply.pin, diode.a),
        connect(diode.b, load.a),
        connect(load.b, ground.pin),
    )


def test_a_half_wave_rectifier_passes_the_positive_half():
    r = run(HalfWave(), 0.05, step=1e-4)
    close(r["load.port.effort"], np.maximum(AMPLITUDE * np.sin(OMEGA * r.time), 0.0), 1e-6)
    assert [e.time for e in r.events] == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04], abs=1e-9)
    complements(r, "diode")


class Bridge(Component):
    """Four diodes, a capacitor and a load; all four are open most of the time, and what floats is decided by no law."""

    mains = Sine(amplitude=AMPLITUDE, frequency=FREQUENCY)
    supply = FloatingVoltageSource()
    up = IdealDiode()
    down = IdealDiode()
    other_up = IdealDiode()
    other_down = IdealDiode()
    load = Resistor(resistance=100.0)
    ground = Ground()

    connections = (
        connect(VOLT * mains.result, supply.voltage),
        connect(supply.a, up.a, down.b),
        connect(supply.b, other_up.a, other_down.b),
        connect(up.b, other_up.b, load.a),
        connect(down.a, other_down.a, load.b, ground.pin),
    )


DIODES = ("up", "down", "other_up", "other_down")


@BACKENDS
def test_a_bridge_passes_both_halves(backend: Backend):
    r = run(Bridge(), 0.025, step=2.5e-4, backend=backend)
    close(r["load.port.effort"], np.abs(AMPLITUDE * np.sin(OMEGA * r.time)), 1e-6)
    complements(r, *DIODES)


class SmoothedBridge(Component):
    """The bridge with a capacitor across the load, which it follows without any resistance in between."""

    mains = Sine(amplitude=AMPLITUDE, frequency=FREQUENCY)
    supply = FloatingVoltageSource()
    up = IdealDiode()
    down = IdealDiode()
    other_up = IdealDiode()
    other_down = IdealDiode()
    capacitor = Capacitor(capacitance=2e-4)
    load = Resistor(resistance=100.0)
    ground = Ground()

    connections = (
        connect(VOLT * mains.result, supply.voltage),
        connect(supply.a, up.a, down.b),
        connect(supply.b, other_up.a, other_down.b),
        connect(up.b, other_up.b, capacitor.a, load.a),
        connect(down.a, other_down.a, capacitor.b, load.b, ground.pin),
    )


def test_a_smoothed_bridge_follows_the_mains_and_lets_go_where_the_capacitor_is_slower():
    r = run(SmoothedBridge(), 0.06, step=2e-5)
    tau = 100.0 * 2e-4
    # Following v = A |sin wt|, the diodes' current C v' + v / R ends where tan(wt) = -w tau.
    leaves = (math.pi - math.atan(OMEGA * tau)) / OMEGA
    half = math.pi / OMEGA
    level = AMPLITUDE * math.sin(OMEGA * leaves)
    t = r.time % half
    # From there it decays, until the next half wave has risen to it.
    meets = leaves
    for _ in range(60):
        meets = half + math.asin(level * math.exp(-(meets - leaves) / tau) / AMPLITUDE) / OMEGA
    late = r.time > half
    follows = late & (t > meets - half + 1e-6) & (t < leaves - 1e-6)
    close(r["load.port.effort"][follows], AMPLITUDE * np.sin(OMEGA * t[follows]), 1e-6)
    since = np.where(t > leaves, t - leaves, t + half - leaves)
    decays = late & ((t > leaves + 1e-6) | (t < meets - half - 1e-6))
    close(r["load.port.effort"][decays], level * np.exp(-since[decays] / tau), 1e-6)
    assert follows.sum() > 20
    assert decays.sum() > 20
    complements(r, *DIODES)
    assert energy_balance(r).relative_residual < 1e-6


class Buck(Component):
    """A converter that steps 24 V down, with a resistor as load."""

    source = Constant(value=24.0)
    pulses = PulseWidth(frequency=2e4, duty=0.25)
    supply = VoltageSource()
    switch = IdealSwitch()
    diode = IdealDiode()
    coil = Inductor(inductance=2e-4)
    capacitor = Capacitor(capacitance=1e-4)
    load = Resistor(resistance=5.0)
    ground = Ground()

    connections = (
        connect(VOLT * source.result, supply.voltage),
        connect(pulses.result, switch.command),
        connect(supply.pin, switch.a),
        connect(switch.b, coil.a, diode.b),
        connect(coil.b, capacitor.a, load.a),
        connect(diode.a, capacitor.b, load.b, ground.pin),
    )


def test_a_buck_converter_has_the_ripple_of_its_design_equations():
    duty, period, inductance, capacitance = 0.25, 5e-5, 2e-4, 1e-4
    # The periodic solution of the two linear systems, exactly: current and voltage where the switch closes.
    a = np.array([[0.0, -1.0 / inductance], [1.0 / capacitance, -1.0 / (5.0 * capacitance)]])
    forced = np.linalg.solve(a, np.array([24.0 / inductance, 0.0]))
    on, off = expm(a * duty * period), expm(a * (1.0 - duty) * period)
    lowest, voltage_there = np.linalg.solve(np.eye(2) - off @ on, off @ (on - np.eye(2)) @ forced)
    start = {"coil.momentum": inductance * lowest, "capacitor.displacement": capacitance * voltage_there}
    r = run(Buck(), 1e-3, step=1e-6, every=1e-6, initial=start)
    assert r.at_end("coil.port.flow") == pytest.approx(lowest, rel=1e-7)
    assert r.at_end("capacitor.port.effort") == pytest.approx(voltage_there, rel=1e-7)
    current, voltage = r["coil.port.flow"], r["capacitor.port.effort"]
    # Erickson, Maksimovic (2020), Fundamentals of Power Electronics, eqs. 2.15 and 2.60, for a ripple of 1 % or less.
    ripple = duty * 24.0 * (1.0 - duty) * period / inductance
    assert voltage.mean() == pytest.approx(duty * 24.0, rel=1e-3)
    assert np.ptp(current) == pytest.approx(ripple, rel=1e-2)
    assert np.ptp(voltage) == pytest.approx(ripple * period / (8.0 * capacitance), rel=1e-2)
    complements(r, "switch", "diode")
    balance = energy_balance(r)
    assert balance.lost_in_events == pytest.approx(0.0, abs=1e-12)
    assert balance.relative_residual < 1e-7


def test_a_buck_converter_at_light_load_has_a_time_without_current():
    resistance, capacitance = 200.0, 1e-5
    # Erickson, Maksimovic, eq. 5.30: M = 2 / (1 + sqrt(1 + 4 K / D^2)), K = 2 L / (R T).
    k = 2.0 * 2e-4 / (resistance * 5e-5)
    ratio = 2.0 / (1.0 + math.sqrt(1.0 + 4.0 * k / 0.25**2))
    r = run(
        Buck(),
        4e-3,
        step=2.5e-6,
        every=2.5e-6,
        parameters={"load.resistance": resistance, "capacitor.capacitance": capacitance},
        initial={"capacitor.displacement": capacitance * 24.0 * ratio},
    )
    late = r.time > 3e-3
    assert r["capacitor.port.effort"][late].mean() == pytest.approx(24.0 * ratio, rel=1e-2)
    peak = (24.0 - 24.0 * ratio) * 0.25 * 5e-5 / 2e-4
    assert r["coil.port.flow"][late].max() == pytest.approx(peak, rel=2e-2)
    idle = late & (r["switch.closed"] < 0.5) & (r["diode.closed"] < 0.5)
    assert idle.mean() > 0.005
    assert not np.any(np.abs(r["coil.port.flow"][idle]) > 1e-12)
    # With both open the coil has no voltage: the node between floats at that of the capacitor.
    close(-r["diode.port.effort"][idle], r["capacitor.port.effort"][idle], 1e-9)


class Oscillator(Component):
    """A charged capacitor that a switch joins to a coil."""

    command = Input("1")
    capacitor = Capacitor(capacitance=1e-6, start_voltage=10.0)
    switch = IdealSwitch()
    coil = Inductor(inductance=1e-3)
    ground = Ground()

    connections = (
        connect(command, switch.command),
        connect(capacitor.a, switch.a),
        connect(switch.b, coil.a),
        connect(capacitor.b, coil.b, ground.pin),
    )


@BACKENDS
def test_a_capacitor_swings_with_a_coil_once_a_switch_joins_them(backend: Backend):
    r = run(Oscillator(), 4e-4, step=2e-6, backend=backend, inputs={"command": is_one(1e-4)})
    omega = 1.0 / math.sqrt(1e-9)
    since = np.maximum(r.time - 1e-4, 0.0)
    apart = np.abs(r.time - 1e-4) > 1e-8
    close(r["capacitor.port.effort"][apart], 10.0 * np.cos(omega * since)[apart], 1e-4)
    complements(r, "switch")
    assert energy_balance(r).relative_residual < 1e-6


@pytest.mark.parametrize("method", list(Method))
def test_a_switch_that_opens_takes_the_energy_of_the_coil_and_the_balance_counts_it(method: Method):
    r = run(Oscillator(), 1e-4, step=1e-7, method=method, inputs={"command": is_zero(2e-5)})
    opened = r.time > 2.001e-5
    assert np.all(np.abs(r["coil.port.flow"][opened]) < 1e-20)
    assert np.ptp(r["capacitor.port.effort"][opened]) == 0.0
    lost = r.events[-1]
    assert str(lost.element) == "switch"
    current = 10.0 * math.sqrt(1e-6 / 1e-3) * math.sin(2e-5 / math.sqrt(1e-9))
    assert lost.lost == pytest.approx(0.5e-3 * current**2, rel=2e-2 if method is Method.EULER else 1e-3)
    assert energy_balance(r).lost_in_events == lost.lost
    assert energy_balance(r).relative_residual < (1e-6 if method is Method.RK4 else 0.05)


class Freewheel(Component):
    """A coil that is switched off, with a diode that lets its current go on."""

    command = Input("1")
    source = Constant(value=12.0)
    supply = VoltageSource()
    switch = IdealSwitch()
    coil = Inductor(inductance=0.1)
    wire = Resistor(resistance=4.0)
    diode = IdealDiode()
    ground = Ground()

    connections = (
        connect(command, switch.command),
        connect(VOLT * source.result, supply.voltage),
        connect(supply.pin, switch.a),
        connect(switch.b, coil.a, diode.b),
        connect(coil.b, wire.a),
        connect(wire.b, diode.a, ground.pin),
    )


def test_a_freewheeling_diode_takes_over_the_current_of_a_coil():
    off = 0.05
    r = run(Freewheel(), 0.2, inputs={"command": is_zero(off)})
    tau = 0.1 / 4.0
    at_off = 3.0 * (1.0 - math.exp(-off / tau))
    rises = 3.0 * (1.0 - np.exp(-r.time / tau))
    falls = at_off * np.exp(-(r.time - off) / tau)
    close(r["coil.port.flow"], np.where(r.time < off, rises, falls), 1e-6)
    assert sum(e.lost for e in r.events) == pytest.approx(0.0, abs=1e-12)
    complements(r, "switch", "diode")
    assert energy_balance(r).relative_residual < 1e-7


class TwoCapacitors(Component):
    """Two capacitors, one of them charged, that a switch joins."""

    command = Input("1")
    full = Capacitor(capacitance=1e-3, start_voltage=10.0)
    empty = Capacitor(capacitance=3e-3)
    switch = IdealSwitch()
    ground = Ground()

    connections = (
        connect(command, switch.command),
        connect(full.a, switch.a),
        connect(switch.b, empty.a),
        connect(full.b, empty.b, ground.pin),
    )


@BACKENDS
def test_capacitors_that_are_joined_share_their_charge_and_lose_energy(backend: Backend):
    r = run(TwoCapacitors(), 1.0, step=0.01, backend=backend, inputs={"command": is_one(0.5)})
    assert r.at_end("full.port.effort") == pytest.approx(2.5, rel=1e-12)
    assert r.at_end("empty.port.effort") == pytest.approx(2.5, rel=1e-12)
    # C1 C2 V^2 / 2 (C1 + C2)
    assert r.events[-1].lost == pytest.approx(0.5 * 0.75e-3 * 100.0, rel=1e-12)
    balance = energy_balance(r)
    assert balance.lost_in_events == r.events[-1].lost
    assert balance.relative_residual < 1e-12
    complements(r, "switch")


def test_a_capacitor_that_is_shorted_loses_what_it_holds():
    capacitor, switch, ground = Capacitor(capacitance=2e-3, start_voltage=5.0), IdealSwitch(), Ground()
    pulses = PulseWidth(frequency=1.0, duty=0.5)
    model = system(
        connect(pulses.result, switch.command),
        connect(capacitor.a, switch.a),
        connect(capacitor.b, switch.b, ground.pin),
        capacitor=capacitor,
        switch=switch,
        pulses=pulses,
        ground=ground,
    )
    r = run(model, 1.5)
    assert r.at_end("capacitor.port.effort") == 0.0
    assert energy_balance(r).lost_in_events == pytest.approx(0.5 * 2e-3 * 25.0, rel=1e-12)


def charging(resistance: float | None) -> Component:
    """A capacitor that a switch joins to a battery, with or without a resistance in between."""
    command, switch = Sine(amplitude=1.0, frequency=0.25), IdealSwitch()
    source, supply, capacitor, ground = Constant(value=10.0), VoltageSource(), Capacitor(capacitance=1e-3), Ground()
    parts = {"command": command, "switch": switch, "source": source, "supply": supply}
    parts |= {"capacitor": capacitor, "ground": ground}
    between = (switch.b, capacitor.a)
    connections = [
        connect(command.result, switch.command),
        connect(VOLT * source.result, supply.voltage),
        connect(supply.pin, switch.a),
        connect(capacitor.b, ground.pin),
    ]
    if resistance is None:
        return system(*connections, connect(*between), **parts)
    wire = Resistor(resistance=resistance)
    return system(*connections, connect(switch.b, wire.a), connect(wire.b, capacitor.a), wire=wire, **parts)


def test_an_impulse_through_a_source_is_refused_by_name():
    r = simulate(compiled(charging(None)), scenario(1.0), step=1e-2)
    assert r.ending.status is RunStatus.FAILED
    assert "an impulse of switch would pass through the source supply" in r.ending.message
    assert r.ending.time == pytest.approx(1.0 / 3.0, abs=1e-9)
    close(run(charging(1.0), 0.5, step=1e-4)["capacitor.port.effort"][-1:], np.array([10.0]), 1e-9)


def test_a_switch_across_a_source_is_refused_by_name_when_it_closes():
    command, source = Sine(amplitude=1.0, frequency=0.25), Constant(value=10.0)
    supply, switch, ground = VoltageSource(), IdealSwitch(), Ground()
    load = Resistor(resistance=1.0)
    model = system(
        connect(command.result, switch.command),
        connect(VOLT * source.result, supply.voltage),
        connect(supply.pin, switch.a, load.a),
        connect(switch.b, load.b, ground.pin),
        command=command,
        source=source,
        supply=supply,
        switch=switch,
        load=load,
        ground=ground,
    )
    r = simulate(compiled(model), scenario(1.0), step=1e-2, record_every=0.1)
    assert r.ending.status is RunStatus.FAILED
    assert "switch: closed around a source of effort" in r.ending.message
    assert r.ending.time == pytest.approx(1.0 / 3.0, abs=1e-9)


def test_a_switch_across_mains_that_closes_as_they_pass_zero_is_refused_too():
    mains, supply, diode, ground = Sine(amplitude=10.0, frequency=1.0), VoltageSource(), IdealDiode(), Ground()
    model = system(
        connect(VOLT * mains.result, supply.voltage),
        connect(supply.pin, diode.a),
        connect(diode.b, ground.pin),
        mains=mains,
        supply=supply,
        diode=diode,
        ground=ground,
    )
    r = simulate(compiled(model), scenario(1.0), step=1e-2, method=Method.RK4)
    assert r.ending.status is RunStatus.FAILED
    assert "diode: closed around a source of effort" in r.ending.message


def test_a_switch_in_series_with_a_source_of_current_is_refused_when_it_opens():
    command = PulseWidth(frequency=1.0, duty=0.5)
    source, supply, switch, ground = Constant(value=2.0), CurrentSource(), IdealSwitch(), Ground()
    model = system(
        connect(command.result, switch.command),
        connect(quantity(1.0, "A") * source.result, supply.current),
        connect(supply.pin, switch.a),
        connect(switch.b, ground.pin),
        command=command,
        source=source,
        supply=supply,
        switch=switch,
        ground=ground,
    )
    r = simulate(compiled(model), scenario(1.0), step=1e-2)
    assert r.ending.status is RunStatus.FAILED
    assert "switch: closed around a source of effort, or open in series with a source of flow" in r.ending.message
    assert r.ending.time == pytest.approx(0.5, abs=1e-9)
