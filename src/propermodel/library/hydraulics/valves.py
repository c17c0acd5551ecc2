"""Valves: one-way, relief, metering and the four-way servo valve."""

from __future__ import annotations

from propermodel.expressions import Expr, clip, sqrt
from propermodel.modelling import Component, Hydraulic, Input, Parameter, Port, Resistance, connect, parameter


def opened(pressure: Expr, opening: Expr, width: Expr) -> Expr:
    """The pressure above the one that opens a valve, its corner rounded over a width; zero at zero pressure."""

    def above(excess: Expr) -> Expr:
        return 0.5 * (excess + sqrt(excess * excess + width * width))

    return above(pressure - opening) - above(-opening)


class CheckValve(Resistance):
    """Lets oil pass from `a` to `b` above a small opening pressure, and next to none back.

    Q = G opened(dp) + L dp, its corner rounded over a width of pressure.
    """

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    conductance: Parameter = parameter("m3/(s.Pa)", low=0.0, doc="when open")
    leakage: Parameter = parameter("m3/(s.Pa)", default=1e-15, low=0.0)
    opening_pressure: Parameter = parameter("Pa", default=2e4, low=0.0)
    width: Parameter = parameter("Pa", default=5e3, low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * opened(effort, self.opening_pressure, self.width) + self.leakage * effort


class ReliefValve(Resistance):
    """Opens above a set pressure of `a` over `b`; each pascal beyond lets `conductance` pass (its override)."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    set_pressure: Parameter = parameter("Pa", low=0.0)
    conductance: Parameter = parameter("m3/(s.Pa)", low=0.0, doc="rated flow over the override pressure")
    leakage: Parameter = parameter("m3/(s.Pa)", default=1e-15, low=0.0)
    width: Parameter = parameter("Pa", default=1e5, low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * opened(effort, self.set_pressure, self.width) + self.leakage * effort


class MeteringOrifice(Resistance):
    """An orifice whose opening, 0 to 1, is a signal; laminar below a transition pressure.

    Q = C_d A s sqrt(2 / rho) dp / (dp^2 + w^2)^(1/4), which is the sharp orifice above w and has a slope below.
    """

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    opening = Input("1")
    area: Parameter = parameter("m2", low=0.0)
    discharge: Parameter = parameter("1", default=0.61, low=0.0)
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0)
    transition_pressure: Parameter = parameter("Pa", default=1e4, low=0.0)

    def flow(self, effort: Expr) -> Expr:
        width = self.transition_pressure
        root = effort / sqrt(sqrt(effort * effort + width * width))
        return self.discharge * self.area * self.opening * sqrt(2.0 / self.density) * root


class ServoValve(Component):
    """A four-way valve with four metering edges (Merritt, Hydraulic Control Systems, ch. 5).

    A positive opening, up to 1, joins `supply` with `a` and `b` with `tank`; a negative one the other way.
    """

    supply = Port(Hydraulic)
    tank = Port(Hydraulic)
    a = Port(Hydraulic)
    b = Port(Hydraulic)
    opening = Input("1")
    area: Parameter = parameter("m2", low=0.0, doc="of one edge, fully open")

    supply_a = MeteringOrifice(area=area)
    supply_b = MeteringOrifice(area=area)
    a_tank = MeteringOrifice(area=area)
    b_tank = MeteringOrifice(area=area)

    connections = (
        connect(supply, supply_a.a, supply_b.a),
        connect(tank, a_tank.b, b_tank.b),
        connect(a, supply_a.b, a_tank.a),
        connect(b, supply_b.b, b_tank.a),
        connect(clip(opening, 0.0, 1.0), supply_a.opening, b_tank.opening),
        connect(clip(-opening, 0.0, 1.0), supply_b.opening, a_tank.opening),
    )
