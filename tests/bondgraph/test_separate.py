"""Models that are in several parts: what counts as being one part."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel import Component, FlowSource, Input, Output, Port, SignalBlock, Translation, connect
from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.separate import separate_parts
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import Severity
from tests.parts import Fixed, Force, Mass, Spring


class Oscillator(Component):
    mass = Mass(mass=2.0)
    spring = Spring(stiffness=8.0)
    wall = Fixed()

    connections = (connect(mass.flange, spring.a), connect(spring.b, wall.flange))


class Two(Component):
    left = Oscillator()
    right = Oscillator()


class Double(SignalBlock):
    speed = Input("m/s")
    twice = Output("m/s")

    def outputs(self):
        return {self.twice: 2.0 * self.speed}


class Follower(FlowSource):
    """Moves at the speed that it is told."""

    flange = Port(Translation)
    speed = Input("m/s")

    def flow(self):
        return self.speed


class Observing(Component):
    """The one follows the other, through signals alone."""

    leader = Oscillator()
    double = Double()
    follower = Follower()
    spring = Spring(stiffness=1.0)
    mass = Mass(mass=1.0)

    connections = (
        connect(leader.mass.flange.flow, double.speed),
        connect(double.twice, follower.speed),
        connect(follower.flange, spring.a),
        connect(spring.b, mass.flange),
    )


def parts(component: Component) -> list[tuple[str, str]]:
    """The parts that are told apart: the first component, and with which others."""
    found = separate_parts(flatten(pm.elaborate(component)))
    assert all(diagnostic.severity is Severity.WARNING for diagnostic in found)
    return [(involved.path, involved.role) for diagnostic in found for involved in diagnostic.involved]


def test_a_connected_model_is_one_part():
    assert parts(Oscillator()) == []


def test_parts_are_called_by_the_outermost_components_within_them():
    assert parts(Two()) == [("left", "stands alone"), ("right", "stands alone")]


def test_one_that_observes_the_other_is_no_part_of_its_own():
    assert parts(Observing()) == []


def test_many_parts_are_counted():
    members = {f"system_{number}": Oscillator() for number in range(11)}
    found = parts(type("Many", (Component,), members)())
    assert found[0] == ("system_0", "stands alone")
    assert found[-1] == ("...", "and 3 more")


def test_both_parts_are_simulated():
    compiled = compile_quietly(pm.elaborate(Two()))
    starts = {pm.Path(("left", "mass", "momentum")): 2.0, pm.Path(("right", "mass", "momentum")): 6.0}
    run = pm.simulate(compiled, pm.Scenario(stop=1.0, initial=starts), method=pm.Method.RK4, step=1e-3)
    # v = v0 cos(w t) with w = sqrt(8 / 2)
    cosine = -0.4161468365471424
    assert run.at_end("left.mass.flange.flow") == pytest.approx(1.0 * cosine, abs=1e-9)
    assert run.at_end("right.mass.flange.flow") == pytest.approx(3.0 * cosine, abs=1e-9)


def test_a_component_with_ports_is_one_thing():
    class Body(Component):
        x = Port(Translation)
        y = Port(Translation)
        along = Mass(mass=1.0)
        upward = Mass(mass=1.0)
        connections = (connect(x, along.flange), connect(y, upward.flange))

    class Flight(Component):
        body = Body()
        push = Force(force=1.0)
        weight = Force(force=-9.81)
        connections = (connect(push.flange, body.x), connect(weight.flange, body.y))

    assert separate_parts(flatten(pm.elaborate(Flight()))) == ()
