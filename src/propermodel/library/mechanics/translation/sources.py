"""What moves or pushes a flange from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Input, Port, Translation


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


class VelocitySource(FlowSource):
    """A prescribed velocity of whatever is connected."""

    flange = Port(Translation)
    velocity = Input("m/s")

    def flow(self) -> Expr:
        return self.velocity
