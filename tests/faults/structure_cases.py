"""Faults in the structure of a bond graph: causality and equations."""

from __future__ import annotations

import propermodel as pm
from propermodel import (
    Component,
    Inertia,
    OneJunction,
    Parameter,
    Port,
    Resistance,
    Translation,
    bond,
    compile_model,
    connect,
    elaborate,
    parameter,
)
from tests.faults.case import Case
from tests.parts import Fixed, Force, Ground, Lever, Mass, Resistor, Velocity, Voltage


def compiled(component: Component) -> object:
    return compile_model(elaborate(component))


class TwoVoltages(Component):
    mains = Voltage(voltage=230.0)
    battery = Voltage(voltage=12.0)
    lamp = Resistor(resistance=10.0)
    ground = Ground()

    connections = (
        connect(mains.a, battery.a, lamp.a),
        connect(mains.b, battery.b, lamp.b, ground.pin),
    )


class TwoVelocities(Component):
    road = Velocity(velocity=1.0)
    shaker = Velocity(velocity=2.0)
    mass = Mass(mass=1.0)

    connections = (connect(road.flange, shaker.flange, mass.flange),)


class OneWay(Resistance):
    """A law that cannot be inverted: the same force at both signs of the slip."""

    port = Port(Translation)
    force: Parameter = parameter("N", default=1.0)
    width: Parameter = parameter("m/s", default=0.1)

    def effort(self, flow):
        return self.force * pm.tanh(flow / self.width)


class OnlyForces(Component):
    """Every part at the junction gives a force, none its velocity."""

    push = Force(force=1.0)
    brake = OneWay()

    connections = (connect(push.flange, brake.port),)


class ShortedSource(Component):
    wall = Fixed()
    road = Velocity(velocity=1.0)

    connections = (connect(wall.flange, road.flange),)


class HardMass(Inertia):
    """Momentum that saturates: the law has no inverse."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", default=1.0)
    scale: Parameter = parameter("N.s", default=1.0)

    def flow(self, momentum):
        return self.scale / self.mass * pm.tanh(momentum / self.scale)

    def energy(self, momentum):
        return self.scale * self.scale / self.mass * (momentum / self.scale) ** 2.0


class NoInverse(Component):
    road = Velocity(velocity=1.0)
    mass = HardMass()

    connections = (connect(road.flange, mass.flange),)


class BouncingMass(Mass):
    """A mass that bounces off something."""

    def events(self):
        return (pm.when(self.flange.flow < 0.0, {self.flange.momentum: -self.flange.momentum}),)


class DrivenBouncer(Component):
    road = Velocity(velocity=1.0)
    mass = BouncingMass(mass=1.0)

    connections = (connect(road.flange, mass.flange),)


class Idle(Component):
    """Junctions without anything that decides them."""

    one = OneJunction()
    zero = pm.ZeroJunction()
    a = Lever(ratio=1.0)

    connections = (bond(one, a.a), bond(a.b, one), bond(one, zero))


CASES = (
    Case(
        code="equations/event",
        run=lambda: compiled(DrivenBouncer()),
        names=("mass.momentum", "dependent"),
        at="pm.when(",
        cure="put a compliance in between",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(TwoVoltages()),
        names=("two effort sources", "voltage", "mains", "battery"),
        at="battery = Voltage(",
        cure="put a resistance or inertia between them, or make one of them a flow source",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(TwoVelocities()),
        names=("two flow sources", "velocity", "road", "shaker", "1-junction"),
        at="shaker = Velocity(",
        cure="put a compliance between them, or make one of them an effort source",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(OnlyForces()),
        names=("nothing sets the velocity", "push", "brake"),
        at="brake = OneWay()",
        cure="an inertia",
    ),
    Case(
        code="structure/source-shorted",
        run=lambda: compiled(ShortedSource()),
        names=("road", "flow"),
        at="road = Velocity",
        cure="take one of the two away",
    ),
    Case(
        code="causality/no-inverse",
        run=lambda: compiled(NoInverse()),
        names=("mass", "inverted", "road"),
        at="mass = HardMass()",
        cure="momentum(flow)",
    ),
)
