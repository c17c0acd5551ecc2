"""Activated bonds against closed forms: nothing acts back, and what their ends give is named in the balance."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.causality.causal import Why
from propermodel.library.electrical import (
    Capacitor,
    CurrentSource,
    Ground,
    IdealTransformer,
    Inductor,
    Resistor,
    VoltageSource,
)
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring

FINE = {"method": pm.Method.RK4, "step": 1e-3}


class TwoLags(pm.Component):
    """Two low passes; the second feels the voltage of the first and does not load it."""

    supply = VoltageSource()
    first_resistor = Resistor(resistance=2.0)
    first = Capacitor(capacitance=0.25)
    second_resistor = Resistor(resistance=2.0)
    second = Capacitor(capacitance=0.25)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "V"), supply.voltage),
        pm.connect(supply.pin, first_resistor.a),
        pm.connect(first_resistor.b, first.a),
        pm.activated_bond(first.a, second_resistor.a, carries="effort"),
        pm.connect(second_resistor.b, second.a),
        pm.connect(ground.pin, first.b, second.b),
    )


def run_of(component: pm.Component, stop: float = 1.0) -> pm.Trajectory:
    return pm.simulate(pm.compile_model(pm.elaborate(component)), pm.Scenario(stop=stop), **FINE)


def test_a_lag_that_is_felt_by_an_activated_bond_is_not_loaded():
    run = run_of(TwoLags())
    t = run.time
    assert run["first.port.effort"] == pytest.approx(1.0 - np.exp(-2.0 * t), abs=1e-9)
    assert run["second.port.effort"] == pytest.approx(1.0 - (1.0 + 2.0 * t) * np.exp(-2.0 * t), abs=1e-9)


def test_the_balance_names_what_an_activated_bond_gives():
    run = run_of(TwoLags())
    balance = pm.energy_balance(run)
    ((name, given),) = balance.activated
    assert str(name) == "first.a.to_second_resistor_a"
    # i = C du/dt = t exp(-2t) at v = 1 - exp(-2t), so that v i integrates to
    x = math.exp(-2.0)
    expected = (1.0 - 3.0 * x) / 4.0 - (1.0 - 5.0 * x**2) / 16.0
    assert given == pytest.approx(expected, rel=1e-6)
    assert [str(path) for path, _ in balance.sources] == ["supply"]
    # The supply only charges the first capacitor: its charge is C (1 - exp(-2)).
    assert balance.supplied == pytest.approx(0.25 * (1.0 - x), rel=1e-6)
    assert balance.relative_residual < 1e-6
    assert f"+ activated bond first.a.to_second_resistor_a {given:.6g} J" in str(balance)


class Follower(pm.Component):
    """The speed of a mass that is braked moves the end of a spring; the mass feels nothing of it."""

    leader = Mass(mass=2.0, start_velocity=3.0)
    brake = Damper(damping=1.0)
    wall = Fixed()
    spring = Spring(stiffness=8.0)
    follower = Mass(mass=0.5)

    connections = (
        pm.connect(leader.flange, brake.a),
        pm.connect(brake.b, wall.flange),
        pm.activated_bond(leader.flange, spring.a, carries="flow"),
        pm.connect(spring.b, follower.flange),
    )


def test_a_flow_that_is_carried_acts_without_reaction():
    run = run_of(Follower(), 2.0)
    t, a, w = run.time, 0.5, 4.0
    leading = 3.0 * np.exp(-a * t)
    share = 3.0 * w**2 / (w**2 + a**2)
    following = share * (np.exp(-a * t) - np.cos(w * t) + a / w * np.sin(w * t))
    assert run["leader.flange.flow"] == pytest.approx(leading, abs=1e-9)
    assert run["follower.flange.flow"] == pytest.approx(following, abs=1e-8)
    balance = pm.energy_balance(run)
    assert balance.relative_residual < 1e-6
    ((_, given),) = balance.activated
    stored = 0.25 * following[-1] ** 2 + 0.5 * 8.0 * run.at_end("spring.port.displacement") ** 2
    assert given == pytest.approx(stored, rel=1e-6)


class Amplifier(pm.Component):
    """The voltage of a node, amplified, feeds the node through a resistor."""

    gain: pm.Parameter = pm.parameter("1", default=3.0)
    node = Capacitor(capacitance=0.5, start_voltage=1.0)
    amplifier = IdealTransformer(ratio=1.0 / gain)
    feedback = Resistor(resistance=4.0)
    ground = Ground()

    connections = (
        pm.activated_bond(node.a, amplifier.primary_a, carries="effort"),
        pm.connect(amplifier.secondary_a, feedback.a),
        pm.connect(feedback.b, node.a),
        pm.connect(ground.pin, node.b, amplifier.primary_b, amplifier.secondary_b),
    )


@pytest.mark.parametrize("gain", [0.5, 1.5, 3.0])
def test_an_active_circuit_grows_by_the_energy_of_its_activated_bond(gain):
    run = run_of(Amplifier(gain=gain), 1.5)
    rate = (gain - 1.0) / (4.0 * 0.5)
    assert run["node.port.effort"] == pytest.approx(np.exp(rate * run.time), rel=1e-9)
    balance = pm.energy_balance(run)
    ((_, given),) = balance.activated
    # The amplifier gives gain v (gain - 1) v / R.
    assert given == pytest.approx(
        gain * (gain - 1.0) / 4.0 * (math.exp(2.0 * rate * 1.5) - 1.0) / (2.0 * rate), rel=1e-6
    )
    assert balance.supplied == 0.0
    assert balance.relative_residual < 1e-6


class ActiveDivider(pm.Component):
    """An amplifier of the same voltage that it feeds: an algebraic loop through an activated bond."""

    supply = VoltageSource()
    series = Resistor(resistance=1.0)
    amplifier = IdealTransformer(ratio=2.0)
    feedback = Resistor(resistance=4.0)
    load = Resistor(resistance=8.0)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(6.0, "V"), supply.voltage),
        pm.connect(supply.pin, series.a),
        pm.connect(series.b, feedback.b, load.a),
        pm.activated_bond(series.b, amplifier.primary_a, carries="effort"),
        pm.connect(amplifier.secondary_a, feedback.a),
        pm.connect(ground.pin, load.b, amplifier.primary_b, amplifier.secondary_b),
    )


def test_an_algebraic_loop_through_an_activated_bond_is_solved():
    run = run_of(ActiveDivider())
    # (6 - v) / 1 + (v / 2 - v) / 4 = v / 8
    assert run.at_end("load.port.effort") == pytest.approx(6.0 / 1.25, rel=1e-12)
    assert pm.energy_balance(run).relative_residual < 1e-12
    report = pm.explain_causality(run.compiled)
    through = [loop for loop in report.loops if "series.b.to_amplifier_primary_a" in map(str, loop.path.places)]
    assert through
    assert "Se to_amplifier_primary_a" in report.text()


class Written(pm.Component):
    """Junctions written out: the current of one mesh drives another, as a bond graph shows it."""

    mesh = pm.OneJunction()
    other = pm.OneJunction()
    coil = Inductor(inductance=2.0, start_current=1.0)
    resistor = Resistor(resistance=6.0)
    load = Resistor(resistance=5.0)
    ground = Ground()

    connections = (
        pm.bond(mesh, coil.port),
        pm.bond(mesh, resistor.port),
        pm.bond(other, load.port),
        pm.activated_bond(mesh, other, carries="flow"),
        pm.connect(ground.pin, coil.a, coil.b, resistor.a, resistor.b, load.a, load.b),
    )


class OnePort(pm.Resistance):
    """A resistor as a one-port."""

    port = pm.Port(pm.Electrical)
    resistance: pm.Parameter = pm.parameter("Ohm")

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return self.resistance * flow


class Coil(pm.Inertia):
    """A coil as a one-port."""

    port = pm.Port(pm.Electrical)
    inductance: pm.Parameter = pm.parameter("H")
    current: pm.Parameter = pm.parameter("A", default=0.0)

    def momentum(self, flow: pm.Expr) -> pm.Expr:
        return self.inductance * flow

    def start(self) -> pm.Expr:
        return self.inductance * self.current


class Meshes(pm.Component):
    """The current of one mesh drives another."""

    mesh = pm.OneJunction()
    other = pm.OneJunction()
    coil = Coil(inductance=2.0, current=1.0)
    resistor = OnePort(resistance=6.0)
    load = OnePort(resistance=5.0)
    second = OnePort(resistance=1.0)

    connections = (
        pm.bond(mesh, coil.port),
        pm.bond(mesh, resistor.port),
        pm.bond(other, load.port),
        pm.bond(other, second.port),
        pm.activated_bond(mesh, other, carries="flow"),
    )


def test_a_current_is_carried_between_written_junctions():
    run = run_of(Meshes())
    assert run["load.port.effort"] == pytest.approx(5.0 * np.exp(-3.0 * run.time), rel=1e-9)


def test_the_stroke_of_an_activated_bond_is_fixed_and_explained():
    compiled = pm.compile_model(pm.elaborate(Meshes()))
    causal = compiled.system.causal
    ((name, bond),) = compiled.graph.activated_sources.items()
    assert causal.strokes[bond.given].why is Why.ACTIVATED
    assert causal.strokes[bond.given].effort_into == name
    report = pm.explain_causality(compiled)
    assert "Sf to_other is the end of an activated bond, which gives the current (flow)" in report.explanation()
    assert "activated bonds: 1\n  mesh.to_other: mesh => other  (activated: current only)" in report.text()
    assert "activated bond" in report.table()
    assert "  mesh => other  (activated: current only)" in str(compiled.graph)
    assert "to_other.port ->" not in str(compiled.graph)
    assert "Se to_other_felt begins an activated bond: it takes no voltage (effort) from bond" in report.explanation()


def test_an_activated_bond_cannot_give_what_a_source_gives():
    class Clash(TwoLags):
        """A source sets the voltage that the activated bond gives."""

        other = VoltageSource()
        connections = (
            *TwoLags.connections,
            pm.connect(pm.quantity(2.0, "V"), other.voltage),
            pm.connect(other.pin, TwoLags.second_resistor.a),
        )

    with pytest.raises(pm.ProperModelError) as caught:
        pm.compile_model(pm.elaborate(Clash()))
    text = str(caught.value)
    assert "causality/conflict" in text
    assert "first.a.to_second_resistor_a  is the end of an activated bond" in text


@pytest.mark.parametrize("component", [TwoLags, Follower, Meshes])
def test_activated_bonds_go_to_a_document_and_back(component, tmp_path):
    model = pm.elaborate(component())
    pm.write_model(model, tmp_path / "model.json")
    again = pm.read_model(tmp_path / "model.json")
    assert again == model
    compiled = pm.compile_model(again)
    first = pm.simulate(pm.compile_model(model), pm.Scenario(stop=0.5), **FINE)
    second = pm.simulate(compiled, pm.Scenario(stop=0.5), **FINE)
    assert np.array_equal(first.columns, second.columns)


def test_activated_bonds_are_no_inputs_of_a_linear_model_unless_asked_for():
    compiled = pm.compile_model(pm.elaborate(TwoLags()))
    model = pm.linearise(compiled, pm.Scenario(), outputs=["second.port.effort"])
    assert [str(path) for path in model.inputs] == ["supply"]
    assert np.sort(np.linalg.eigvals(model.A)) == pytest.approx([-2.0, -2.0], abs=1e-6)


def test_a_current_source_feels_no_activated_bond():
    class Sensed(pm.Component):
        """The voltage over a resistor, felt across a capacitor that it charges."""

        source = CurrentSource()
        shunt = Resistor(resistance=3.0)
        charge = Resistor(resistance=1.0)
        hold = Capacitor(capacitance=1.0)
        ground = Ground()
        connections = (
            pm.connect(pm.quantity(2.0, "A"), source.current),
            pm.connect(source.pin, shunt.a),
            pm.activated_bond(shunt.a, charge.a, carries="effort"),
            pm.connect(charge.b, hold.a),
            pm.connect(ground.pin, shunt.b, hold.b),
        )

    run = run_of(Sensed())
    assert run["shunt.port.effort"] == pytest.approx(6.0)
    assert run.at_end("hold.port.effort") == pytest.approx(6.0 * (1.0 - math.exp(-1.0)), rel=1e-9)
