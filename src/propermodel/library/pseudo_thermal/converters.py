"""Converters between true bonds and pseudo bonds of heat."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Electrical,
    MultiportResistance,
    Parameter,
    Port,
    PseudoThermal,
    Rotation,
    Thermal,
    Translation,
    parameter,
)


class ResistorHeat(MultiportResistance):
    """An ohmic resistor whose power R i^2 is a heat flow at `heat`."""

    converts = True

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    heat = Port(PseudoThermal)
    resistance: Parameter = parameter("Ohm", low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        voltage, current = self.port.effort, self.port.flow
        return (
            {self.port.effort: self.resistance * current, self.heat.flow: -self.resistance * current * current},
            {self.port.flow: voltage / self.resistance, self.heat.flow: -voltage * voltage / self.resistance},
        )


class DamperHeat(MultiportResistance):
    """A linear damper whose power d v^2 is a heat flow at `heat`."""

    converts = True

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    heat = Port(PseudoThermal)
    damping: Parameter = parameter("N.s/m", low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        force, speed = self.port.effort, self.port.flow
        return (
            {self.port.effort: self.damping * speed, self.heat.flow: -self.damping * speed * speed},
            {self.port.flow: force / self.damping, self.heat.flow: -force * force / self.damping},
        )


class FrictionHeat(MultiportResistance):
    """Viscous friction whose power d w^2 is a heat flow at `heat`."""

    converts = True

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    heat = Port(PseudoThermal)
    damping: Parameter = parameter("N.m.s/rad", low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        torque, speed = self.port.effort, self.port.flow
        return (
            {self.port.effort: self.damping * speed, self.heat.flow: -self.damping * speed * speed},
            {self.port.flow: torque / self.damping, self.heat.flow: -torque * torque / self.damping},
        )


class TrueThermalPort(MultiportResistance):
    """One temperature on both sides: entropy flow S at the true port `entropy` is the heat flow T S at `heat`."""

    converts = True

    entropy = Port(Thermal)
    heat = Port(PseudoThermal)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        temperature = self.entropy.effort + self.ambient_temperature
        return (
            {self.heat.effort: temperature, self.entropy.flow: -self.heat.flow / temperature},
            {
                self.entropy.effort: self.heat.effort - self.ambient_temperature,
                self.heat.flow: -self.entropy.flow * self.heat.effort,
            },
        )
