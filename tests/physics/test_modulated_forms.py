"""MSe, MSf, MTF, MGY, MR, MC and MI against closed forms, with what modulation does to the energy."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.library.electrical import Capacitor, CurrentSource, Ground, Resistor, VoltageSource
from propermodel.library.mechanics.translation import Mass, MotionSensor, VelocitySource

BACKENDS = [pm.Backend.NATIVE, pm.Backend.INTERPRETED]


def seconds() -> pm.Expr:
    return pm.time / pm.quantity(1.0, "s")


def run_of(component: pm.Component, backend: pm.Backend = pm.Backend.NATIVE) -> pm.Trajectory:
    compiled = pm.compile_model(pm.elaborate(component), backend=backend)
    step = 1e-3 if backend is pm.Backend.NATIVE else 1e-2
    return pm.simulate(compiled, pm.Scenario(stop=1.0), method=pm.Method.RK4, step=step)


class Ramp(pm.Component):
    """MSe: a voltage that grows with time behind 2 Ohm, on 0.5 F."""

    supply = VoltageSource()
    resistor = Resistor(resistance=2.0)
    capacitor = Capacitor(capacitance=0.5)
    ground = Ground()

    connections = (
        pm.connect(seconds() * pm.quantity(3.0, "V"), supply.voltage),
        pm.connect(supply.pin, resistor.a),
        pm.connect(resistor.b, capacitor.a),
        pm.connect(capacitor.b, ground.pin),
    )


class Charging(pm.Component):
    """MSf: a current that grows with time into 0.5 F."""

    supply = CurrentSource()
    capacitor = Capacitor(capacitance=0.5)
    ground = Ground()

    connections = (
        pm.connect(seconds() * pm.quantity(3.0, "A"), supply.current),
        pm.connect(supply.pin, capacitor.a),
        pm.connect(capacitor.b, ground.pin),
    )


class Push(pm.EffortSource):
    """A constant force of 6 N."""

    port = pm.Port(pm.Translation)

    def effort(self) -> pm.Expr:
        return pm.quantity(6.0, "N")


class Lever(pm.Transformer):
    """A lever whose ratio is a signal."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation)
    ratio = pm.Input("1")

    def modulus(self) -> pm.Expr:
        return self.ratio


class Shifting(pm.Component):
    """MTF: 6 N over a lever of the ratio 1 + t on 2 kg."""

    push = Push()
    lever = Lever()
    mass = Mass(mass=2.0)

    connections = (
        pm.connect(1.0 + seconds(), lever.ratio),
        pm.bond(push.port, lever.a),
        pm.bond(lever.b, mass.flange),
    )


class Excited(pm.Gyrator):
    """A machine whose constant is a signal."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Rotation)
    constant = pm.Input("V.s/rad")

    def modulus(self) -> pm.Expr:
        return self.constant


class Brake(pm.Resistance):
    """Friction of 5 N.m.s/rad."""

    port = pm.Port(pm.Rotation)

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return pm.quantity(5.0, "N.m.s/rad") * flow


class Weakening(pm.Component):
    """MGY: 2 V on a machine of the constant 1 + t, which turns a brake."""

    supply = VoltageSource()
    machine = Excited()
    brake = Brake()

    connections = (
        pm.connect(pm.quantity(2.0, "V"), supply.voltage),
        pm.connect((1.0 + seconds()) * pm.quantity(1.0, "V.s/rad"), machine.constant),
        pm.connect(supply.pin, machine.a),
        pm.connect(machine.b, brake.port),
    )


class Rheostat(pm.Resistance):
    """A resistor that is a signal."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)
    port = pm.Port(pm.Electrical, between=(a, b))
    resistance = pm.Input("Ohm")

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return self.resistance * flow


class Fading(pm.Component):
    """MR: 0.5 F at 4 V over a resistor of (1 + t) Ohm."""

    capacitor = Capacitor(capacitance=0.5, start_voltage=4.0)
    rheostat = Rheostat()
    ground = Ground()

    connections = (
        pm.connect((1.0 + seconds()) * pm.quantity(1.0, "Ohm"), rheostat.resistance),
        pm.connect(capacitor.a, rheostat.a),
        pm.connect(capacitor.b, rheostat.b, ground.pin),
    )


class Plates(pm.Compliance):
    """A capacitor that is a signal."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)
    port = pm.Port(pm.Electrical, between=(a, b))
    capacitance = pm.Input("F")
    charge: pm.Parameter = pm.parameter("C", default=0.0)

    def effort(self, displacement: pm.Expr) -> pm.Expr:
        return displacement / self.capacitance

    def start(self) -> pm.Expr:
        return self.charge


class Opening(pm.Component):
    """MC: 2 C on plates of 1 F / (1 + t) over 1e15 Ohm."""

    plates = Plates(charge=2.0)
    leak = Resistor(resistance=1e15)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "F") / (1.0 + seconds()), plates.capacitance),
        pm.connect(plates.a, leak.a),
        pm.connect(plates.b, leak.b, ground.pin),
    )


class Held(pm.Component):
    """MC in derivative causality: plates of (1 + t) F at 3 V."""

    supply = VoltageSource()
    plates = Plates()
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(3.0, "V"), supply.voltage),
        pm.connect((1.0 + seconds()) * pm.quantity(1.0, "F"), plates.capacitance),
        pm.connect(supply.pin, plates.a),
        pm.connect(plates.b, ground.pin),
    )


class Skater(pm.Inertia):
    """A body whose moment of inertia is a signal."""

    shaft = pm.Port(pm.Rotation)
    inertia = pm.Input("kg.m2")
    momentum_at_start: pm.Parameter = pm.parameter("N.m.s", default=0.0)

    def momentum(self, flow: pm.Expr) -> pm.Expr:
        return self.inertia * flow

    def start(self) -> pm.Expr:
        return self.momentum_at_start


class Pirouette(pm.Component):
    """MI: a skater of 12 N.m.s draws in arms of 1 kg, whose radius a carriage gives: J = 2 + (2 - t)^2 kg.m2."""

    skater = Skater(momentum_at_start=12.0)
    arms = VelocitySource()
    radius = MotionSensor(start=2.0)

    connections = (
        pm.connect(pm.quantity(-1.0, "m/s"), arms.velocity),
        pm.connect(arms.flange, radius.flange),
        pm.connect(
            pm.quantity(2.0, "kg.m2") + pm.quantity(1.0, "kg") * radius.position * radius.position, skater.inertia
        ),
        pm.connect(skater.shaft),
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_mse(backend: pm.Backend):
    run = run_of(Ramp(), backend)
    # RC = 1 s: v = 3 (t - 1 + exp(-t))
    assert run["capacitor.port.effort"] == pytest.approx(3.0 * (run.time - 1.0 + np.exp(-run.time)), abs=1e-7)
    balance = pm.energy_balance(run)
    # The current is 1.5 (1 - exp(-t)).
    assert balance.supplied == pytest.approx(4.5 * (2.0 / math.e - 0.5), rel=1e-5)
    assert balance.relative_residual < 1e-6


@pytest.mark.parametrize("backend", BACKENDS)
def test_msf(backend: pm.Backend):
    run = run_of(Charging(), backend)
    assert run["capacitor.port.effort"] == pytest.approx(3.0 * run.time**2, abs=1e-9)
    balance = pm.energy_balance(run)
    assert balance.supplied == pytest.approx(0.25 * 9.0, rel=1e-6)
    assert balance.relative_residual < 1e-6


@pytest.mark.parametrize("backend", BACKENDS)
def test_mtf(backend: pm.Backend):
    run = run_of(Shifting(), backend)
    assert run["mass.flange.flow"] == pytest.approx(3.0 * np.log(1.0 + run.time), abs=1e-8)
    balance = pm.energy_balance(run)
    assert balance.supplied == pytest.approx(9.0 * math.log(2.0) ** 2, rel=1e-6)
    assert balance.relative_residual < 1e-6
    assert balance.modulated == ()


@pytest.mark.parametrize("backend", BACKENDS)
def test_mgy(backend: pm.Backend):
    run = run_of(Weakening(), backend)
    assert run["brake.port.flow"] == pytest.approx(2.0 / (1.0 + run.time), rel=1e-12)
    assert run["machine.a.flow"] == pytest.approx(10.0 / (1.0 + run.time) ** 2, rel=1e-12)
    balance = pm.energy_balance(run)
    assert balance.supplied == pytest.approx(20.0 * 0.5, rel=1e-4)
    assert balance.dissipated == pytest.approx(balance.supplied, rel=1e-12)


@pytest.mark.parametrize("backend", BACKENDS)
def test_mr(backend: pm.Backend):
    run = run_of(Fading(), backend)
    assert run["capacitor.port.effort"] == pytest.approx(4.0 / (1.0 + run.time) ** 2, rel=1e-7)
    balance = pm.energy_balance(run)
    assert balance.dissipated == pytest.approx(0.25 * 16.0 * (1.0 - 1.0 / 16.0), rel=1e-5)
    assert balance.relative_residual < 1e-5


@pytest.mark.parametrize("backend", BACKENDS)
def test_mc_that_is_opened_takes_the_work_of_the_hand(backend: pm.Backend):
    run = run_of(Opening(), backend)
    assert run["plates.port.effort"] == pytest.approx(2.0 * (1.0 + run.time), rel=1e-9)
    balance = pm.energy_balance(run)
    # q^2 / (2 C) grows from 2 J to 4 J.
    ((path, work),) = balance.modulated
    assert str(path) == "plates"
    assert work == pytest.approx(2.0, rel=1e-9)
    assert balance.stored == pytest.approx(2.0, rel=1e-9)
    assert balance.relative_residual < 1e-9
    assert "+ modulation of plates 2 J" in str(balance)
    assert run["plates.modulation.work"][-1] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
@pytest.mark.parametrize("backend", BACKENDS)
def test_mc_at_a_given_voltage_gives_half_of_what_the_source_spends_to_the_hand(backend: pm.Backend):
    run = run_of(Held(), backend)
    assert run["plates.port.flow"] == pytest.approx(3.0, rel=1e-12)
    balance = pm.energy_balance(run)
    assert balance.supplied == pytest.approx(9.0, rel=1e-9)
    assert balance.stored == pytest.approx(4.5, rel=1e-9)
    assert balance.modulated[0][1] == pytest.approx(-4.5, rel=1e-9)
    assert balance.relative_residual < 1e-9


@pytest.mark.parametrize("backend", BACKENDS)
def test_mi_keeps_its_momentum_and_takes_the_work_of_the_arms(backend: pm.Backend):
    run = run_of(Pirouette(), backend)
    inertia = 2.0 + (2.0 - run.time) ** 2
    assert run["skater.shaft.flow"] == pytest.approx(12.0 / inertia, rel=1e-9)
    balance = pm.energy_balance(run)
    work = 72.0 * (1.0 / 3.0 - 1.0 / 6.0)
    ((path, found),) = balance.modulated
    assert str(path) == "skater"
    assert found == pytest.approx(work, rel=1e-6 if backend is pm.Backend.NATIVE else 1e-3)
    assert balance.stored == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize("component", [Opening, Held, Pirouette])
def test_modulated_storage_comes_back_from_its_document(component: type[pm.Component], tmp_path):
    model = pm.elaborate(component())
    pm.write_model(model, tmp_path / "model.json")
    assert pm.read_model(tmp_path / "model.json") == model
