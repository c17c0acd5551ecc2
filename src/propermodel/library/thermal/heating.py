"""Friction whose heat is a bond (RS elements): it keeps energy and makes entropy."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import MultiportResistance, Parameter, Port, Rotation, Thermal, Translation, parameter


class HeatingFriction(MultiportResistance):
    """Viscous friction whose heat is a bond: all its power d w^2 leaves at `heat` as the entropy flow d w^2 / T."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    heat = Port(Thermal)
    damping: Parameter = parameter("N.m.s/rad", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        temperature = self.heat.effort + self.ambient_temperature
        torque, speed = self.port.effort, self.port.flow
        return (
            {
                self.port.effort: self.damping * speed,
                self.heat.flow: -self.damping * speed * speed / temperature,
            },
            {
                self.port.flow: torque / self.damping,
                self.heat.flow: -torque * torque / (self.damping * temperature),
            },
        )


class HeatingDamper(MultiportResistance):
    """A linear damper whose heat is a bond: all its power d v^2 leaves at `heat` as the entropy flow d v^2 / T."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    heat = Port(Thermal)
    damping: Parameter = parameter("N.s/m", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        temperature = self.heat.effort + self.ambient_temperature
        force, speed = self.port.effort, self.port.flow
        return (
            {
                self.port.effort: self.damping * speed,
                self.heat.flow: -self.damping * speed * speed / temperature,
            },
            {
                self.port.flow: force / self.damping,
                self.heat.flow: -force * force / (self.damping * temperature),
            },
        )
