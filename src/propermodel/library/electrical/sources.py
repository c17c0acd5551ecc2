"""What drives an electrical node from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, Electrical, FlowSource, Input, Port


class Ground(EffortSource):
    """The zero of voltage."""

    pin = Port(Electrical)

    def effort(self) -> ExprLike:
        return 0.0


class VoltageSource(EffortSource):
    """A prescribed voltage of a node against ground."""

    pin = Port(Electrical)
    voltage = Input("V")

    def effort(self) -> Expr:
        return self.voltage


class FloatingVoltageSource(EffortSource):
    """A prescribed voltage of `a` above `b`, with neither on ground."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    voltage = Input("V")

    def effort(self) -> Expr:
        return self.voltage


class CurrentSource(FlowSource):
    """A prescribed current into whatever is connected."""

    pin = Port(Electrical)
    current = Input("A")

    def flow(self) -> Expr:
        return -self.current
