"""What turns a shaft from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Input, Port, Rotation


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
