"""The sense of a half arrow is bookkeeping: passive elements stay passive, two-ports keep power."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.expressions import Expr
from propermodel.modelling import (
    Compliance,
    EffortSource,
    Inertia,
    OneJunction,
    Parameter,
    Port,
    Resistance,
    Translation,
    ZeroJunction,
    bond,
    connect,
    parameter,
    quantity,
)
from tests.parts import Capacitor, Coil, Flywheel, Ground, Lever, Motor, Resistor, Voltage
from tests.physics.systems import close, eigenvalues, run, system


class Elastic(Compliance):
    port = Port(Translation)
    stiffness: Parameter = parameter("N/m")

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement


class Viscous(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class Heavy(Inertia):
    port = Port(Translation)
    mass: Parameter = parameter("kg")

    def momentum(self, flow: Expr) -> Expr:
        return self.mass * flow


def arrow(one, other, along):
    return bond(one, other) if along else bond(other, one)


@pytest.mark.parametrize("along", list(product([True, False], repeat=3)))
def test_an_oscillator_is_damped_whatever_the_sense_of_its_bonds(along):
    j, m, k, c = OneJunction(), Heavy(mass=1.0), Elastic(stiffness=4.0), Viscous(damping=1.0)
    arrows = [arrow(j, part.port, sense) for part, sense in zip((m, k, c), along, strict=True)]
    model = system(*arrows, j=j, m=m, k=k, c=c)
    assert eigenvalues(model) == pytest.approx([-0.5 - 1.9364917j, -0.5 + 1.9364917j])
    balance = energy_balance(run(model, 3.0, initial={"m.momentum": 1.0}))
    assert balance.dissipated > 0.0
    assert balance.stored == pytest.approx(-balance.dissipated, rel=1e-9)


def test_two_elements_can_be_bonded_to_each_other():
    m, k = Heavy(mass=1.0), Elastic(stiffness=4.0)
    r = run(system(bond(m.port, k.port), m=m, k=k), 3.0, initial={"m.momentum": 1.0})
    close(r["m.port.flow"], np.cos(2.0 * r.time))


class Pull(EffortSource):
    """A force of 6 N."""

    port = Port(Translation)

    def effort(self) -> Expr:
        return quantity(6.0, "N")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_source_can_be_bonded_to_an_element(sign):
    pull, c = Pull(), Viscous(damping=2.0)
    r = run(system(bond(pull.port, c.port) if sign > 0.0 else bond(c.port, pull.port), pull=pull, c=c), 1.0)
    # The same force along the half arrow; a damper counts power into itself.
    assert r.at_end("c.port.flow") == pytest.approx(sign * 3.0)
    assert energy_balance(r).dissipated == pytest.approx(18.0)


@pytest.mark.parametrize("along", list(product([True, False], repeat=2)))
def test_a_lever_passes_power_whatever_the_sense_of_its_bonds(along):
    left, right = OneJunction(), OneJunction()
    m, lever, k = Heavy(mass=1.0), Lever(ratio=1.5), Elastic(stiffness=4.0)
    model = system(
        bond(left, m.port),
        arrow(left, lever.a, along[0]),
        arrow(lever.b, right, along[1]),
        bond(right, k.port),
        left=left,
        right=right,
        m=m,
        lever=lever,
        k=k,
    )
    r = run(model, 3.0, initial={"m.momentum": 1.0})
    close(r["m.port.flow"], np.cos(3.0 * r.time))
    close(r["k.port.flow"], 1.5 * np.cos(3.0 * r.time))
    close(r["lever.a.effort"] * r["lever.a.flow"], r["lever.b.effort"] * r["lever.b.flow"])


@pytest.mark.parametrize("along", [True, False])
def test_a_motor_passes_power_whatever_the_sense_of_its_bonds(along):
    shaft = OneJunction()
    store, motor = Coil(inductance=0.5), Motor(constant=0.2)
    wheel, ground = Flywheel(inertia=0.1), Ground()
    model = system(
        connect(store.a, motor.a),
        connect(store.b, ground.pin),
        arrow(motor.b, shaft, along),
        bond(shaft, wheel.shaft),
        shaft=shaft,
        store=store,
        motor=motor,
        wheel=wheel,
        ground=ground,
    )
    r = run(model, 3.0, initial={"wheel.momentum": 1.0})
    close(r["wheel.shaft.flow"], 10.0 * np.cos(0.2 / np.sqrt(0.5 * 0.1) * r.time))


def test_one_port_may_be_reached_by_several_arrows():
    # Two springs, each between the same mass and a wall of its own, written with 0-junctions.
    one, two, m = ZeroJunction(), ZeroJunction(), Heavy(mass=1.0)
    k1, k2 = Elastic(stiffness=3.0), Elastic(stiffness=6.0)
    model = system(
        bond(m.port, one),
        bond(m.port, two),
        bond(one, k1.port),
        bond(two, k2.port),
        one=one,
        two=two,
        m=m,
        k1=k1,
        k2=k2,
    )
    r = run(model, 3.0, initial={"m.momentum": 1.0})
    close(r["m.port.flow"], np.cos(3.0 * r.time))


@pytest.mark.parametrize("turned", list(product([True, False], repeat=3)))
def test_terminals_of_passive_parts_may_be_swapped(turned):
    source = Voltage(voltage=10.0)
    r1 = Resistor(resistance=2.0)
    l1 = Coil(inductance=0.1)
    c1 = Capacitor(capacitance=1e-3)
    ground = Ground()
    first = [part.b if turn else part.a for part, turn in zip((r1, l1, c1), turned, strict=True)]
    last = [part.a if turn else part.b for part, turn in zip((r1, l1, c1), turned, strict=True)]
    model = system(
        connect(source.a, first[0]),
        connect(last[0], first[1]),
        connect(last[1], first[2]),
        connect(last[2], source.b, ground.pin),
        source=source,
        ground=ground,
        r1=r1,
        l1=l1,
        c1=c1,
    )
    r = run(model, 0.2, step=2e-5)
    t, decay = r.time, 10.0
    w = np.sqrt(1e4 - decay**2)
    sign = -1.0 if turned[2] else 1.0
    close(sign * r["c1.port.effort"], 10.0 * (1.0 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))))
