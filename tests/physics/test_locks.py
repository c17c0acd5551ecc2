"""Resistances that lock where a compliance or a source sets their effort, so that they give their flow."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, Method
from propermodel.expressions import Expr
from propermodel.library.electrical import Ground, VoltageSource
from propermodel.library.mechanics.translation import Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    Electrical,
    Input,
    Parameter,
    Port,
    Resistance,
    TableValues,
    Translation,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.documents import from_document, to_document
from tests.physics.systems import close, compiled, eigenvalues, run, system

BACKENDS = list(Backend)
STIFFNESS, DAMPING, MASS = 50.0, 2.0, 0.5


class Brake(Resistance):
    """A damper that stands still while its brake is closed."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    closed = Input("1")
    damping: Parameter = parameter("N.s/m", default=DAMPING)

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow

    def locked(self) -> Expr:
        """The condition in which it stands still."""
        return self.closed > 0.5


class Stiction(Resistance):
    """A damper that sticks below a force."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m", default=DAMPING)
    breakaway: Parameter = parameter("N")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow

    def locked(self) -> Expr:
        """The condition in which it sticks."""
        return abs(self.port.effort) < self.breakaway


class Relaxation(Component):
    """A spring that relaxes through a brake: the spring sets its force."""

    pedal = Input("1")
    spring = Spring(stiffness=STIFFNESS, start_compression=0.1)
    brake = Brake()
    left = Fixed()
    right = Fixed()

    connections = (
        connect(left.flange, spring.a),
        connect(spring.b, brake.a),
        connect(brake.b, right.flange),
        connect(pedal, brake.closed),
    )


class Suspended(Component):
    """A mass on a spring and a brake in series."""

    pedal = Input("1")
    mass = Mass(mass=MASS, start_velocity=1.0)
    spring = Spring(stiffness=STIFFNESS)
    brake = Brake()
    wall = Fixed()

    connections = (
        connect(mass.flange, spring.a),
        connect(spring.b, brake.a),
        connect(brake.b, wall.flange),
        connect(pedal, brake.closed),
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_locked_damper_keeps_a_spring_compressed(backend: Backend):
    # The pedal goes down half way between the instants of Euler's method at 0.05 s and 0.0501 s.
    pedal = TableValues(((0.0, 0.05005, 0.050051, 1.0),), (0.0, 0.0, 1.0, 1.0))
    r = run(Relaxation(), 0.1, backend=backend, step=1e-4, method=Method.EULER, inputs={"pedal": pedal})
    steps = np.minimum(np.round(r.time / 1e-4), 501)
    close(r["spring.port.displacement"], 0.1 * (1.0 - 1e-4 * STIFFNESS / DAMPING) ** steps, 1e-9)
    assert not np.any(r["brake.port.flow"][r.time > 0.051])
    assert r.at_end("brake.port.effort") == pytest.approx(STIFFNESS * r.at_end("spring.port.displacement"))


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_mass_behind_a_locked_damper_swings_on_its_spring_without_loss(backend: Backend):
    r = run(Suspended(), 2.0, backend=backend, step=1e-3, inputs={"pedal": 1.0})
    close(r["mass.flange.flow"], np.cos(math.sqrt(STIFFNESS / MASS) * r.time), 1e-7)
    balance = energy_balance(r)
    assert balance.dissipated == 0.0
    assert balance.relative_residual < 1e-6


def test_an_open_damper_follows_its_law():
    # m c s^2 + m k s + c k = 0 for a spring and a damper in series, and for the force that both transmit.
    roots = np.roots([MASS * DAMPING, MASS * STIFFNESS, DAMPING * STIFFNESS])
    close(eigenvalues(Suspended(), inputs={"pedal": 0.0}).real, np.sort(roots.real), 1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_damper_that_sticks_leaves_the_force_at_which_it_sticks(backend: Backend):
    spring, brake, left, right = Spring(stiffness=STIFFNESS), Stiction(breakaway=2.0), Fixed(), Fixed()
    model = system(
        connect(left.flange, spring.a),
        connect(spring.b, brake.a),
        connect(brake.b, right.flange),
        spring=spring,
        brake=brake,
        left=left,
        right=right,
    )
    r = run(model, 0.2, backend=backend, step=1e-5, initial={"spring.port.displacement": 0.1})
    # 5 N decay with c / k until 2 N are left; the step decides how far below they stop.
    expected = np.maximum(5.0 * np.exp(-STIFFNESS / DAMPING * r.time), 2.0)
    close(r["spring.port.effort"], expected, 1e-3)


def test_a_source_on_a_locked_resistance_drives_no_flow():
    class Switch(Resistance):
        """A resistor that conducts only above a voltage."""

        a = Port(Electrical)
        b = Port(Electrical)
        port = Port(Electrical, between=(a, b))
        resistance: Parameter = parameter("Ohm", default=4.0)
        threshold: Parameter = parameter("V", default=3.0)

        def effort(self, flow: Expr) -> Expr:
            return self.resistance * flow

        def locked(self) -> Expr:
            return self.port.effort < self.threshold

    class Circuit(Component):
        voltage = Input("V")
        supply = VoltageSource()
        switch = Switch()
        ground = Ground()

        connections = (
            connect(voltage, supply.voltage),
            connect(supply.pin, switch.a),
            connect(switch.b, ground.pin),
        )

    ramp = TableValues(((0.0, 1.0),), (0.0, 10.0))
    r = run(Circuit(), 1.0, inputs={"voltage": ramp})
    voltage = 10.0 * r.time
    assert np.allclose(r["switch.port.flow"], np.where(voltage < 3.0, 0.0, voltage / 4.0), rtol=1e-12, atol=0.0)


def test_a_lock_comes_back_from_its_document():
    model = elaborate(Suspended())
    again = from_document(to_document(model))
    assert again == model
    one, other = (run(compiled(m), 0.5, inputs={"pedal": 1.0}) for m in (model, again))
    assert np.array_equal(one["mass.flange.flow"], other["mass.flange.flow"])
