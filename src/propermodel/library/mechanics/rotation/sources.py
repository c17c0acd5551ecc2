"""What turns a shaft from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Input, Parameter, Port, Rotation, parameter


class FixedShaft(FlowSource):
    """A shaft that does not turn."""

    shaft = Port(Rotation)

    def flow(self) -> ExprLike:
        return 0.0


class TorqueSource(EffortSource):
    """A torque on whatever is connected, in the positive sense."""

    shaft = Port(Rotation)
    torque = Input("N.m")

    def effort(self) -> Expr:
        return -self.torque


class SpeedSource(FlowSource):
    """A prescribed angular velocity of whatever is connected."""

    shaft = Port(Rotation)
    speed = Input("rad/s")

    def flow(self) -> Expr:
        return self.speed


class ConstantTorque(EffortSource):
    """A torque in the positive sense that is always the same."""

    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m")

    def effort(self) -> Expr:
        return -self.torque


class ConstantSpeed(FlowSource):
    """An angular velocity of whatever is connected that is always the same."""

    shaft = Port(Rotation)
    speed: Parameter = parameter("rad/s")

    def flow(self) -> Expr:
        return self.speed
