"""Inertias, shafts and friction that turn about an axis."""

from __future__ import annotations

from propermodel.expressions import Expr, tanh
from propermodel.modelling import (
    Compliance,
    Component,
    Inertia,
    Parameter,
    Port,
    Resistance,
    Rotation,
    connect,
    parameter,
)


class RotatingInertia(Inertia):
    """A rigid body turning about its axis."""

    shaft = Port(Rotation)
    inertia: Parameter = parameter("kg.m2", low=0.0)
    start_speed: Parameter = parameter("rad/s", default=0.0)

    def momentum(self, flow: Expr) -> Expr:
        return self.inertia * flow

    def start(self) -> Expr:
        """The angular momentum at the start."""
        return self.inertia * self.start_speed


class TorsionSpring(Compliance):
    """A linear torsion spring between two shafts."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    stiffness: Parameter = parameter("N.m/rad", low=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement


class RotationalDamper(Resistance):
    """A linear damper between two shafts."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    damping: Parameter = parameter("N.m.s/rad", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class RotationalSpringDamper(Component):
    """A compliant, damped shaft."""

    a = Port(Rotation)
    b = Port(Rotation)
    stiffness: Parameter = parameter("N.m/rad", low=0.0)
    damping: Parameter = parameter("N.m.s/rad", low=0.0)

    spring = TorsionSpring(stiffness=stiffness)
    damper = RotationalDamper(damping=damping)

    connections = (
        connect(a, spring.a, damper.a),
        connect(b, spring.b, damper.b),
    )


class ViscousFriction(Resistance):
    """Friction against the frame that grows with speed."""

    shaft = Port(Rotation)
    damping: Parameter = parameter("N.m.s/rad", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class CoulombFriction(Resistance):
    """Friction against the frame of constant torque, smoothed over a width of speed: T = T_c tanh(omega / width)."""

    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m", low=0.0)
    width: Parameter = parameter("rad/s", default=0.1, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.torque * tanh(flow / self.width)
