"""Bodies that store heat, walls that pass it to ambient or between bodies, and what turns work into heat."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, exp, log
from propermodel.modelling import (
    Compliance,
    Electrical,
    Input,
    MultiportResistance,
    Parameter,
    Port,
    Resistance,
    Thermal,
    parameter,
    quantity,
)

STEFAN_BOLTZMANN = quantity(5.670374419e-8, "W/(m2.K4)")  # CODATA 2018


class HeatCapacity(Compliance):
    """A solid body of one temperature: S = C ln(T / T_a), so that stored energy is what its heat could still do."""

    port = Port(Thermal)
    capacity: Parameter = parameter("J/K", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    start_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.ambient_temperature * (exp(displacement / self.capacity) - 1.0)

    def displacement(self, effort: Expr) -> Expr:
        return self.capacity * log(1.0 + effort / self.ambient_temperature)

    def energy(self, displacement: Expr) -> Expr:
        """The integral of effort over entropy."""
        return self.capacity * self.effort(displacement) - self.ambient_temperature * displacement

    def start(self) -> Expr:
        """Entropy above ambient at the start."""
        return self.capacity * log(self.start_temperature / self.ambient_temperature)


class WallConductance(Resistance):
    """A wall to ambient: the heat flow hA (T - T_a) leaves at temperature T as the entropy flow hA (T - T_a) / T."""

    port = Port(Thermal)
    conductance: Parameter = parameter("W/K", low=0.0, doc="heat transfer coefficient times area")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * effort / (effort + self.ambient_temperature)

    def effort(self, flow: Expr) -> Expr:
        return flow * self.ambient_temperature / (self.conductance - flow)


class Conduction(MultiportResistance):
    """Heat conducted between two bodies: it leaves the warm one and enters the cold one with more entropy.

    Q = G (T_a - T_b); the entropy flows are Q / T_a in at `a` and Q / T_b out at `b`. What it takes as power is the
    work that the heat could have done on its way (Thoma and Bouamama, Modelling and Simulation in Thermal and Chemical
    Engineering, ch. 2).
    """

    a = Port(Thermal)
    b = Port(Thermal)
    conductance: Parameter = parameter("W/K", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        heat = self.conductance * (self.a.effort - self.b.effort)
        return (
            {
                self.a.flow: heat / (self.a.effort + self.ambient_temperature),
                self.b.flow: -heat / (self.b.effort + self.ambient_temperature),
            },
        )

    def residuals(self) -> tuple[ExprLike, ...]:
        """What leaves one side as heat enters the other, whatever is given."""
        heat = self.conductance * (self.a.effort - self.b.effort)
        return (
            self.a.flow * (self.a.effort + self.ambient_temperature) - heat,
            self.b.flow * (self.b.effort + self.ambient_temperature) + heat,
        )


class Convection(MultiportResistance):
    """Heat between a surface `a` and a fluid `b`, its conductance (coefficient times area) a signal."""

    a = Port(Thermal)
    b = Port(Thermal)
    conductance = Input("W/K")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        heat = self.conductance * (self.a.effort - self.b.effort)
        return (
            {
                self.a.flow: heat / (self.a.effort + self.ambient_temperature),
                self.b.flow: -heat / (self.b.effort + self.ambient_temperature),
            },
        )

    def residuals(self) -> tuple[ExprLike, ...]:
        """What leaves one side as heat enters the other, whatever is given."""
        heat = self.conductance * (self.a.effort - self.b.effort)
        return (
            self.a.flow * (self.a.effort + self.ambient_temperature) - heat,
            self.b.flow * (self.b.effort + self.ambient_temperature) + heat,
        )


class Radiation(MultiportResistance):
    """Heat radiated between two grey surfaces: Q = sigma epsilon A (T_a^4 - T_b^4) (Stefan and Boltzmann)."""

    a = Port(Thermal)
    b = Port(Thermal)
    area: Parameter = parameter("m2", low=0.0, doc="times the view factor")
    emissivity: Parameter = parameter("1", default=1.0, low=0.0, high=1.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        at_a = self.a.effort + self.ambient_temperature
        at_b = self.b.effort + self.ambient_temperature
        heat = STEFAN_BOLTZMANN * self.emissivity * self.area * (at_a**4.0 - at_b**4.0)
        return ({self.a.flow: heat / at_a, self.b.flow: -heat / at_b},)

    def residuals(self) -> tuple[ExprLike, ...]:
        """What leaves one side as heat enters the other, whatever is given."""
        at_a = self.a.effort + self.ambient_temperature
        at_b = self.b.effort + self.ambient_temperature
        heat = STEFAN_BOLTZMANN * self.emissivity * self.area * (at_a**4.0 - at_b**4.0)
        return (self.a.flow * at_a - heat, self.b.flow * at_b + heat)


class HeatingResistor(MultiportResistance):
    """An ohmic resistor whose heat is a bond: all its power R i^2 leaves at `heat` as the entropy flow R i^2 / T.

    The RS element of Thoma: it keeps energy and makes entropy.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    heat = Port(Thermal)
    resistance: Parameter = parameter("Ohm", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        temperature = self.heat.effort + self.ambient_temperature
        voltage, current = self.port.effort, self.port.flow
        return (
            {
                self.port.effort: self.resistance * current,
                self.heat.flow: -self.resistance * current * current / temperature,
            },
            {
                self.port.flow: voltage / self.resistance,
                self.heat.flow: -voltage * voltage / (self.resistance * temperature),
            },
        )

    def residuals(self) -> tuple[ExprLike, ...]:
        """Ohm's law, and electrical power that leaves as heat."""
        temperature = self.heat.effort + self.ambient_temperature
        return (
            self.port.effort - self.resistance * self.port.flow,
            self.heat.flow * temperature + self.port.effort * self.port.flow,
        )
