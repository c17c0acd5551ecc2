"""What moves or pushes a flange from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Input, Parameter, Port, Translation, parameter


class Fixed(FlowSource):
    """A flange that does not move."""

    flange = Port(Translation)

    def flow(self) -> ExprLike:
        return 0.0


class ForceSource(EffortSource):
    """A force on whatever is connected, in the positive direction."""

    flange = Port(Translation)
    force = Input("N")

    def effort(self) -> Expr:
        return -self.force


class ConstantForce(EffortSource):
    """A force in the positive direction that is always the same."""

    flange = Port(Translation)
    force: Parameter = parameter("N")

    def effort(self) -> Expr:
        return -self.force


class ConstantVelocity(FlowSource):
    """A velocity of whatever is connected that is always the same."""

    flange = Port(Translation)
    velocity: Parameter = parameter("m/s")

    def flow(self) -> Expr:
        return self.velocity


class VelocitySource(FlowSource):
    """A prescribed velocity of whatever is connected."""

    flange = Port(Translation)
    velocity = Input("m/s")

    def flow(self) -> Expr:
        return self.velocity


class Weight(EffortSource):
    """The weight of a mass whose positive direction is upward."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", low=0.0)
    gravity: Parameter = parameter("m/s2", default=9.80665, source="standard gravity", status="published")

    def effort(self) -> Expr:
        return self.mass * self.gravity
