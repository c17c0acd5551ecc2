"""Inertias, shafts and friction that turn about an axis."""

from __future__ import annotations

from propermodel.expressions import Expr, clip, cos, exp, sin, tanh
from propermodel.modelling import (
    Compliance,
    Component,
    Inertia,
    Input,
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


class Backlash(Compliance):
    """A torsion spring with play: it carries nothing until half the play has been taken up in either sense."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    stiffness: Parameter = parameter("N.m/rad", low=0.0)
    play: Parameter = parameter("rad", low=0.0, doc="from flank to flank")
    start_twist: Parameter = parameter("rad", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * self._twist(displacement)

    def energy(self, displacement: Expr) -> Expr:
        """What the flanks have stored once they touch."""
        twist = self._twist(displacement)
        return 0.5 * self.stiffness * twist * twist

    def start(self) -> Expr:
        """The twist at the start, play included."""
        return self.start_twist

    def _twist(self, displacement: Expr) -> Expr:
        half = 0.5 * self.play
        return displacement - clip(displacement, -half, half)


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


class QuadraticTorque(Resistance):
    """A fan, a propeller or a stirrer: T = T_n (omega / omega_n)^2 against the motion."""

    shaft = Port(Rotation)
    nominal_torque: Parameter = parameter("N.m", low=0.0)
    nominal_speed: Parameter = parameter("rad/s", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        share = flow / self.nominal_speed
        return self.nominal_torque * share * abs(share)


class CoulombFriction(Resistance):
    """Friction against the frame of constant torque, smoothed over a width of speed: T = T_c tanh(omega / width)."""

    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m", low=0.0)
    width: Parameter = parameter("rad/s", default=0.1, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.torque * tanh(flow / self.width)


class StribeckFriction(Resistance):
    """Bearing friction: dry, higher near rest, and viscous; its sign smoothed over a width of speed.

    T = (T_c + (T_s - T_c) exp(-(w / w_s)^2)) tanh(w / width) + d w (Armstrong-Hélouvry et al. 1994).
    """

    shaft = Port(Rotation)
    coulomb: Parameter = parameter("N.m", low=0.0)
    breakaway: Parameter = parameter("N.m", low=0.0)
    stribeck_speed: Parameter = parameter("rad/s", low=0.0)
    damping: Parameter = parameter("N.m.s/rad", default=0.0, low=0.0)
    width: Parameter = parameter("rad/s", default=0.1, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        speed = flow / self.stribeck_speed
        dry = self.coulomb + (self.breakaway - self.coulomb) * exp(-speed * speed)
        return dry * tanh(flow / self.width) + self.damping * flow


class SlippingClutch(Resistance):
    """A friction clutch that slips: T = mu r N z tanh(w / width), its normal force N a signal."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    normal_force = Input("N")
    friction: Parameter = parameter("1", default=0.3, low=0.0)
    mean_radius: Parameter = parameter("m", low=0.0)
    faces: Parameter = parameter("1", default=2.0, low=0.0)
    width: Parameter = parameter("rad/s", default=0.1, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.friction * self.mean_radius * self.faces * self.normal_force * tanh(flow / self.width)


class GravityPendulum(Compliance):
    """The weight of a body on an arm: T = m g l sin(angle), its angle counted from hanging down."""

    shaft = Port(Rotation)
    mass: Parameter = parameter("kg", low=0.0)
    length: Parameter = parameter("m", low=0.0, doc="from the axis to the centre of gravity")
    gravity: Parameter = parameter("m/s2", default=9.80665, source="standard gravity", status="published")
    start_angle: Parameter = parameter("rad", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.mass * self.gravity * self.length * sin(displacement)

    def energy(self, displacement: Expr) -> Expr:
        """What the body could do by falling to its lowest point."""
        return self.mass * self.gravity * self.length * (1.0 - cos(displacement))

    def start(self) -> Expr:
        """The angle at the start."""
        return self.start_angle
