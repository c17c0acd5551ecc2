"""Bodies that store heat, and what passes it between two of them."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Compliance,
    MultiportResistance,
    Parameter,
    Port,
    PseudoThermal,
    Resistance,
    parameter,
    quantity,
)

STEFAN_BOLTZMANN = quantity(5.670374419e-8, "W/(m2.K4)")  # CODATA 2018


class HeatStore(Compliance):
    """A body of one temperature: Q = C T, counted from absolute zero."""

    port = Port(PseudoThermal)
    capacity: Parameter = parameter("J/K", low=0.0)
    start_temperature: Parameter = parameter("K", default=293.15, low=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacity

    def start(self) -> Expr:
        """The heat at the start."""
        return self.capacity * self.start_temperature


class ThermalConductor(Resistance):
    """Heat between two bodies in proportion to their difference of temperature."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    port = Port(PseudoThermal, between=(a, b))
    conductance: Parameter = parameter("W/K", low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * effort


class ThermalResistor(Resistance):
    """A wall by its resistance to heat."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    port = Port(PseudoThermal, between=(a, b))
    resistance: Parameter = parameter("K/W", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow


class ThermalRadiation(MultiportResistance):
    """Heat radiated between two grey surfaces: Q = sigma epsilon A (T_a^4 - T_b^4) (Stefan and Boltzmann)."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    area: Parameter = parameter("m2", low=0.0, doc="times the view factor")
    emissivity: Parameter = parameter("1", default=1.0, low=0.0, high=1.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        heat = STEFAN_BOLTZMANN * self.emissivity * self.area * (self.a.effort**4.0 - self.b.effort**4.0)
        return ({self.a.flow: heat, self.b.flow: -heat},)

    def residuals(self) -> tuple[ExprLike, ...]:
        """What leaves one surface reaches the other, whatever is given."""
        heat = STEFAN_BOLTZMANN * self.emissivity * self.area * (self.a.effort**4.0 - self.b.effort**4.0)
        return (self.a.flow - heat, self.b.flow + heat)
