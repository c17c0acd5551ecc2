"""What drives an electrical node from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, Electrical, FlowSource, Input, Parameter, Port, parameter


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


class FloatingCurrentSource(FlowSource):
    """A prescribed current that is taken in at `a` and given out at `b`."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    current = Input("A")

    def flow(self) -> Expr:
        return self.current


class ConstantVoltage(EffortSource):
    """A battery without resistance: `p` lies at `voltage` above `n`."""

    p = Port(Electrical)
    n = Port(Electrical)
    port = Port(Electrical, between=(p, n))
    voltage: Parameter = parameter("V")

    def effort(self) -> Expr:
        return self.voltage


class ConstantCurrent(FlowSource):
    """A current that is taken in at `n` and given out at `p`."""

    p = Port(Electrical)
    n = Port(Electrical)
    port = Port(Electrical, between=(n, p))
    current: Parameter = parameter("A")

    def flow(self) -> Expr:
        return self.current
