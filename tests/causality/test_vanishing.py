"""Strokes where the modulus of a two-port may be zero: it multiplies, so that runs may begin there."""

from __future__ import annotations

import numpy as np
import pytest

import propermodel as pm
from propermodel.causality.vanishing import vanishing_two_ports
from propermodel.expressions import Expr, ExprLike, cos, sin, time
from propermodel.library.mechanics.planar import PlanarFrame
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Weight
from propermodel.modelling import Output, SignalBlock, Transformer, Translation, quantity

RATE = 0.5  # rad/s
MASS, DAMPING = 2.0, 3.0


class Turning(SignalBlock):
    """The sine and cosine of an angle that begins at zero."""

    sine = Output("1")
    cosine = Output("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        angle = quantity(RATE, "1/s") * time
        return {self.sine: sin(angle), self.cosine: cos(angle)}


class ModulatedGearOfTime(Transformer):
    """A lever whose ratio grows with time."""

    a = pm.Port(Translation)
    b = pm.Port(Translation)

    def modulus(self) -> Expr:
        return 1.0 + quantity(RATE, "1/s") * time * quantity(RATE, "1/s") * time


class Falling(pm.Component):
    """A mass falls; what brakes it stands along and across an axis that turns, and is alike in all directions."""

    angle = Turning()
    frame = PlanarFrame()
    mass = Mass(mass=MASS)
    weight = Weight(mass=MASS)
    along = Damper(damping=DAMPING)
    across = Damper(damping=DAMPING)
    sideways = Damper(damping=5.0)
    ground = Fixed()

    connections = (
        pm.connect(angle.sine, frame.sine),
        pm.connect(angle.cosine, frame.cosine),
        pm.connect(frame.forward, sideways.b),
        pm.connect(frame.vertical, mass.flange, weight.flange),
        pm.connect(frame.along, along.b),
        pm.connect(frame.upward, across.b),
        pm.connect(ground.flange, along.a, across.a, sideways.a),
    )


def test_a_sine_that_begins_at_zero_multiplies():
    compiled = pm.compile_model(pm.elaborate(Falling()))
    causal = compiled.system.causal
    elements = {str(element.path): element for element in vanishing_two_ports(compiled.graph)}
    names = ["frame.to_along.of_second", "frame.to_upward.of_first"]
    assert list(elements)[:2] == names  # the sines come before the cosines
    for name in names:
        bonds = {bond.name.name: bond for bond in compiled.graph.normal.at()[elements[name].path]}
        assert not causal.receives_effort(bonds["a"], elements[name])
        assert causal.receives_effort(bonds["b"], elements[name])


def test_a_run_begins_where_a_modulus_is_zero():
    run = pm.simulate(pm.compile_model(pm.elaborate(Falling())), pm.Scenario(stop=2.0), method=pm.Method.RK4, step=1e-3)
    assert run.ending.is_complete, run.ending.message
    exact = -MASS * 9.80665 / DAMPING * (1.0 - np.exp(-DAMPING / MASS * run.time))
    assert run["mass.flange.flow"] == pytest.approx(exact, rel=1e-3, abs=1e-6)


class Lever(pm.Component):
    """A gear whose ratio follows the time, and never is zero."""

    mass = Mass(mass=1.0)
    gear = ModulatedGearOfTime()
    wheel = Mass(mass=1.0)

    connections = (pm.connect(mass.flange, gear.a), pm.connect(gear.b, wheel.flange))


def test_a_modulus_that_never_is_zero_may_divide():
    assert not vanishing_two_ports(pm.compile_model(pm.elaborate(Lever())).graph)
