"""Ideal switches, diodes and thyristors: no voltage while closed, no current while open."""

from __future__ import annotations

from propermodel.expressions import Expr, where
from propermodel.modelling import Discrete, Electrical, Input, Parameter, Port, Resistance, parameter, quantity, when
from propermodel.modelling.events import When

VOLT = quantity(1.0, "V")
AMPERE = quantity(1.0, "A")


class IdealSwitch(Resistance):
    """A switch that is closed while its signal is above 0.5.

    What a coil in series with it holds when it opens, or a capacitor across it when it closes, is lost at once; the
    energy balance counts it. A way for the current (a freewheeling diode) keeps it.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    command = Input("1")
    closed = Discrete("1")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        return where(self.closed > 0.5, effort / VOLT, flow / AMPERE)

    def events(self) -> tuple[When, ...]:
        """It follows its signal."""
        is_on, is_closed = self.command > 0.5, self.closed > 0.5
        return (when(is_on & ~is_closed, {self.closed: 1.0}), when(~is_on & is_closed, {self.closed: 0.0}))


class IdealDiode(Resistance):
    """A diode without threshold or leakage, from a to b.

    It closes when its voltage rises above `least_voltage`, and opens when its current falls below `-least_current`;
    both are there against rounding only.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    least_voltage: Parameter = parameter("V", default=1e-9, low=0.0)
    least_current: Parameter = parameter("A", default=1e-9, low=0.0)
    closed = Discrete("1")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        return where(self.closed > 0.5, effort / VOLT, flow / AMPERE)

    def events(self) -> tuple[When, ...]:
        """It closes or opens."""
        is_closed = self.closed > 0.5
        return (
            when(~is_closed & (self.port.effort > self.least_voltage), {self.closed: 1.0}),
            when(is_closed & (self.port.flow < -self.least_current), {self.closed: 0.0}),
        )


class IdealThyristor(Resistance):
    """A diode from a to b that closes only while its gate is above 0.5, and opens when its current has come to zero.

    `least_voltage` and `least_current` are there against rounding only.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    gate = Input("1")
    least_voltage: Parameter = parameter("V", default=1e-9, low=0.0)
    least_current: Parameter = parameter("A", default=1e-9, low=0.0)
    closed = Discrete("1")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        return where(self.closed > 0.5, effort / VOLT, flow / AMPERE)

    def events(self) -> tuple[When, ...]:
        """It fires or goes out."""
        is_closed, is_fired = self.closed > 0.5, self.gate > 0.5
        return (
            when(~is_closed & is_fired & (self.port.effort > self.least_voltage), {self.closed: 1.0}),
            when(is_closed & (self.port.flow < -self.least_current), {self.closed: 0.0}),
        )
