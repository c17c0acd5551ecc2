"""Sensors of rotation; they take no power."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    FlowSource,
    Input,
    Output,
    Port,
    Rotation,
    SignalBlock,
    State,
    connect,
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
    turned = State("rad")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.angle: self.turned}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.turned: self.speed}


class RotationSensor(Component):
    """Speed and angle of a shaft."""

    shaft = Port(Rotation)
    speed = Output("rad/s")
    angle = Output("rad")

    touch = NoTorque()
    counter = AngleCounter()

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
