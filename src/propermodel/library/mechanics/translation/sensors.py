"""Sensors of straight-line motion, forces and their impulses; they take no power."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    FlowSource,
    Input,
    Output,
    Parameter,
    Port,
    SignalBlock,
    State,
    Translation,
    connect,
    parameter,
)


class NoForce(EffortSource):
    """Follows a flange without force."""

    flange = Port(Translation)

    def effort(self) -> ExprLike:
        return 0.0


class Odometer(SignalBlock):
    """The distance covered at a velocity."""

    velocity = Input("m/s")
    position = Output("m")
    start: Parameter = parameter("m", default=0.0)
    covered = State("m", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.position: self.covered}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.covered: self.velocity}


class MotionSensor(Component):
    """Velocity and position of a flange."""

    flange = Port(Translation)
    start: Parameter = parameter("m", default=0.0, doc="position at the start")
    velocity = Output("m/s")
    position = Output("m")

    touch = NoForce()
    odometer = Odometer(start=start)

    connections = (
        connect(flange, touch.flange),
        connect(touch.flange.flow, velocity, odometer.velocity),
        connect(odometer.position, position),
    )


class RigidLink(FlowSource):
    """Two flanges that move together."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))

    def flow(self) -> ExprLike:
        return 0.0


class ForceSensor(Component):
    """The force that passes from flange `a` to flange `b`, positive in compression."""

    a = Port(Translation)
    b = Port(Translation)
    force = Output("N")

    link = RigidLink()

    connections = (
        connect(a, link.a),
        connect(link.b, b),
        connect(link.port.effort, force),
    )


class Separation(EffortSource):
    """Two flanges between which no force acts."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class RelativeMotionSensor(Component):
    """Velocity and position of flange `a` against flange `b`."""

    a = Port(Translation)
    b = Port(Translation)
    start: Parameter = parameter("m", default=0.0, doc="relative position at the start")
    velocity = Output("m/s")
    position = Output("m")

    touch = Separation()
    odometer = Odometer(start=start)

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.flow, velocity, odometer.velocity),
        connect(odometer.position, position),
    )


class ImpulseCounter(SignalBlock):
    """The momentum that a force has handed on."""

    force = Input("N")
    impulse = Output("N.s")
    start: Parameter = parameter("N.s", default=0.0)
    passed = State("N.s", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.impulse: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.force}


class ImpulseSensor(Component):
    """The momentum that has passed from flange `a` to flange `b`, and the force, positive in compression."""

    a = Port(Translation)
    b = Port(Translation)
    start: Parameter = parameter("N.s", default=0.0, doc="impulse at the start")
    impulse = Output("N.s")
    force = Output("N")

    link = RigidLink()
    counter = ImpulseCounter(start=start)

    connections = (
        connect(a, link.a),
        connect(link.b, b),
        connect(link.port.effort, force, counter.force),
        connect(counter.impulse, impulse),
    )
