"""Variable pump/motor: an ideal transformer with two losses, one of torque and one of volume."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.expressions import Expr, minimum, sign, sqrt, tanh
from propermodel.library.mechanics.rotation.components import RotatingInertia
from propermodel.modelling import (
    Component,
    Hydraulic,
    Input,
    OneJunction,
    Parameter,
    Port,
    Resistance,
    Rotation,
    Transformer,
    bond,
    connect,
    parameter,
)

UNIT = "Pourmovahed et al. 1992, 107 cm3/rev variable axial piston unit"


class Displacement(Transformer):
    """The ideal machine: Q = s D omega, T = s D dp, with the stroke s from -1 (motor) to 1 (pump)."""

    a = Port(Rotation)
    b = Port(Hydraulic)
    displacement: Parameter = parameter("m3/rad", low=0.0)
    stroke = Input("1")

    def modulus(self) -> Expr:
        return self.stroke * self.displacement


@dataclass(frozen=True, kw_only=True)
class UnitFriction:
    """The three parts of a unit's friction torque at full stroke (Wilson's model; Pourmovahed et al. 1992)."""

    displacement: Expr
    viscous: Expr  # coefficient times viscosity
    coulomb: Expr
    hydrodynamic: Expr  # coefficient times density

    def viscous_torque(self, speed: Expr) -> Expr:
        """Viscous drag, which stays at zero stroke."""
        return self.displacement * self.viscous * abs(speed)

    def pressure_torque(self, pressure: Expr) -> Expr:
        """Friction of the loaded surfaces."""
        return self.displacement * self.coulomb * abs(pressure)

    def hydrodynamic_torque(self, speed: Expr) -> Expr:
        """Churning and throttling, which grow with the square of speed."""
        return 0.5 * self.hydrodynamic * speed * speed * self.displacement ** (5.0 / 3.0)


class TorqueLoss(Resistance):
    """Viscous, pressure-dependent and hydrodynamic friction (Wilson's model; Pourmovahed et al. 1992).

    dT = D Cv mu |w| + chi D Cf |dp| + |s| Ch rho w^2 D^(5/3) / 2, with the sign of w smoothed over a width. At zero
    stroke an isolation valve takes the pressure off: chi = min(1, |s| / s_0).
    """

    shaft = Port(Rotation)
    stroke = Input("1")
    pressure = Input("Pa")
    displacement: Parameter = parameter("m3/rad", low=0.0)
    viscous: Parameter = parameter("1", default=2.35e4, low=0.0, source=UNIT, status="published")
    coulomb: Parameter = parameter("1", default=0.0537, low=0.0, source=UNIT, status="published")
    hydrodynamic: Parameter = parameter("1", default=53.6, low=0.0, source=UNIT, status="published")
    viscosity: Parameter = parameter("Pa.s", default=0.0278, low=0.0, source=UNIT, status="published")
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0, source=UNIT, status="published")
    isolation_width: Parameter = parameter("1", default=0.02, low=0.0, status="estimated")
    width: Parameter = parameter("rad/s", default=1.0, low=0.0, status="estimated", doc="of the sign of speed")

    def effort(self, flow: Expr) -> Expr:
        friction = UnitFriction(
            displacement=self.displacement,
            viscous=self.viscous * self.viscosity,
            coulomb=self.coulomb,
            hydrodynamic=self.hydrodynamic * self.density,
        )
        valve = minimum(1.0, abs(self.stroke) / self.isolation_width)
        size = (
            friction.viscous_torque(flow)
            + valve * friction.pressure_torque(self.pressure)
            + abs(self.stroke) * friction.hydrodynamic_torque(flow)
        )
        return size * tanh(flow / self.width)


class VolumetricLoss(Resistance):
    """Laminar slip, compressibility and turbulent slip (Wilson's model; Pourmovahed et al. 1992).

    dQ = chi D Cs dp / mu + |s| D |w| dp / beta + D^(2/3) Cst sqrt(2 |dp| / rho), from the high pressure side to the
    low one.
    """

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    stroke = Input("1")
    speed = Input("rad/s")
    displacement: Parameter = parameter("m3/rad", low=0.0)
    laminar: Parameter = parameter("1", default=4.26e-9, low=0.0, source=UNIT, status="published")
    turbulent: Parameter = parameter("1", default=0.0, low=0.0, source=UNIT, status="published")
    viscosity: Parameter = parameter("Pa.s", default=0.0278, low=0.0, source=UNIT, status="published")
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0, source=UNIT, status="published")
    bulk_modulus: Parameter = parameter("Pa", default=1.7e9, low=0.0, source=UNIT, status="published")
    isolation_width: Parameter = parameter("1", default=0.02, low=0.0, status="estimated")

    def flow(self, effort: Expr) -> Expr:
        D, s = self.displacement, abs(self.stroke)
        laminar = minimum(1.0, s / self.isolation_width) * D * self.laminar * effort / self.viscosity
        compressed = s * D * abs(self.speed) * effort / self.bulk_modulus
        turbulent = D ** (2.0 / 3.0) * self.turbulent * sign(effort) * sqrt(2.0 * abs(effort) / self.density)
        return laminar + compressed + turbulent


class PumpMotor(Component):
    """A variable pump/motor with its rotating group: a positive stroke pumps from `low` to `high`."""

    shaft = Port(Rotation)
    high = Port(Hydraulic)
    low = Port(Hydraulic)
    stroke = Input("1")
    displacement: Parameter = parameter("m3/rad", low=0.0)
    inertia: Parameter = parameter("kg.m2", low=0.0)

    ideal = Displacement(displacement=displacement)
    torque_loss = TorqueLoss(displacement=displacement)
    volumetric_loss = VolumetricLoss(displacement=displacement)
    rotating_group = RotatingInertia(inertia=inertia)
    passage = OneJunction()

    connections = (
        connect(shaft, ideal.a, torque_loss.shaft, rotating_group.shaft),
        bond(ideal.b, passage),
        bond(low, passage),
        bond(passage, high),
        connect(high, volumetric_loss.a),
        connect(low, volumetric_loss.b),
        connect(stroke, ideal.stroke, torque_loss.stroke, volumetric_loss.stroke),
        connect(ideal.b.effort, torque_loss.pressure),
        connect(ideal.a.flow, volumetric_loss.speed),
    )
