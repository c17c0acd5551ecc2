"""Bodies that store heat and walls that pass it to ambient."""

from __future__ import annotations

from propermodel.expressions import Expr, exp, log
from propermodel.modelling import Compliance, Parameter, Port, Resistance, Thermal, parameter


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
