"""Sensors of rotation, torques and their impulses; they take no power."""

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
    Rotation,
    SignalBlock,
    State,
    connect,
    parameter,
)


class NoTorque(EffortSource):
    """Follows a shaft without torque."""

    shaft = Port(Rotation)

    def effort(self) -> ExprLike:
        return 0.0


class AngleCounter(SignalBlock):
    """The angle turned at a speed."""

    speed = Input("rad/s")
    angle = Output("rad")
    start: Parameter = parameter("rad", default=0.0)
    turned = State("rad", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.angle: self.turned}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.turned: self.speed}


class RotationSensor(Component):
    """Speed and angle of a shaft."""

    shaft = Port(Rotation)
    start: Parameter = parameter("rad", default=0.0, doc="angle at the start")
    speed = Output("rad/s")
    angle = Output("rad")

    touch = NoTorque()
    counter = AngleCounter(start=start)

    connections = (
        connect(shaft, touch.shaft),
        connect(touch.shaft.flow, speed, counter.speed),
        connect(counter.angle, angle),
    )


class RigidShaft(FlowSource):
    """Two shafts that turn together."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))

    def flow(self) -> ExprLike:
        return 0.0


class TorqueSensor(Component):
    """The torque that passes from shaft `a` to shaft `b`."""

    a = Port(Rotation)
    b = Port(Rotation)
    torque = Output("N.m")

    shaft = RigidShaft()

    connections = (
        connect(a, shaft.a),
        connect(shaft.b, b),
        connect(shaft.port.effort, torque),
    )


class Separation(EffortSource):
    """Two shafts between which no torque acts."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class RelativeRotationSensor(Component):
    """Speed and angle of shaft `a` against shaft `b`."""

    a = Port(Rotation)
    b = Port(Rotation)
    start: Parameter = parameter("rad", default=0.0, doc="relative angle at the start")
    speed = Output("rad/s")
    angle = Output("rad")

    touch = Separation()
    counter = AngleCounter(start=start)

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.flow, speed, counter.speed),
        connect(counter.angle, angle),
    )


class AngularImpulseCounter(SignalBlock):
    """The angular momentum that a torque has handed on."""

    torque = Input("N.m")
    impulse = Output("N.m.s")
    start: Parameter = parameter("N.m.s", default=0.0)
    passed = State("N.m.s", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.impulse: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.torque}


class AngularImpulseSensor(Component):
    """The angular momentum that has passed from shaft `a` to shaft `b`, and the torque."""

    a = Port(Rotation)
    b = Port(Rotation)
    start: Parameter = parameter("N.m.s", default=0.0, doc="angular impulse at the start")
    impulse = Output("N.m.s")
    torque = Output("N.m")

    shaft = RigidShaft()
    counter = AngularImpulseCounter(start=start)

    connections = (
        connect(a, shaft.a),
        connect(shaft.b, b),
        connect(shaft.port.effort, torque, counter.torque),
        connect(counter.impulse, impulse),
    )
