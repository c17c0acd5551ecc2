"""Rigid bodies of mechanisms: masses, and bars without mass between frames."""

from __future__ import annotations

from propermodel.expressions import Expr, cos, sin
from propermodel.library.mechanics.planar.ports import Frame
from propermodel.library.mechanics.rotation.components import RotatingInertia
from propermodel.library.mechanics.translation.components import Lever
from propermodel.library.mechanics.translation.sources import Weight
from propermodel.modelling import Component, Inertia, Parameter, Port, Preference, Translation, connect, parameter


class CarriedMass(Inertia):
    """A mass that joints and bars carry: it depends on what turns wherever it can.

    Solved the other way round, the speed of a bar would follow from that of a mass across an arm, which vanishes.
    """

    preference = Preference.DERIVATIVE
    flange = Port(Translation)
    mass: Parameter = parameter("kg", low=0.0)
    start_velocity: Parameter = parameter("m/s", default=0.0)

    def momentum(self, flow: Expr) -> Expr:
        return self.mass * flow

    def start(self) -> Expr:
        """The momentum at the start."""
        return self.mass * self.start_velocity


class Body(Component):
    """Mass and inertia at a frame, its centre of gravity, under its weight, y upward.

    Velocities at the start are those that the joints allow; a scenario may give a momentum, and the others follow.
    """

    frame = Frame()
    mass: Parameter = parameter("kg", low=0.0)
    rotational_inertia: Parameter = parameter("kg.m2", low=0.0, doc="about the centre of gravity")
    gravity: Parameter = parameter("m/s2", default=9.80665, source="standard gravity", status="published")
    start_velocity_x: Parameter = parameter("m/s", default=0.0)
    start_velocity_y: Parameter = parameter("m/s", default=0.0)
    start_angular_velocity: Parameter = parameter("rad/s", default=0.0)

    inertia = RotatingInertia(inertia=rotational_inertia, start_speed=start_angular_velocity)
    along = CarriedMass(mass=mass, start_velocity=start_velocity_x)
    upward = CarriedMass(mass=mass, start_velocity=start_velocity_y)
    weight = Weight(mass=mass, gravity=gravity)

    connections = (
        connect(frame.x, along.flange),
        connect(frame.y, upward.flange, weight.flange),
        connect(frame.angle, inertia.shaft),
    )


class FixedTranslation(Component):
    """A rigid bar without mass: frame `b` is at (x, y) as seen from frame `a`."""

    a = Frame()
    b = Frame.giving()
    x: Parameter = parameter("m")
    y: Parameter = parameter("m", default=0.0)

    along = Lever()
    upward = Lever()

    offset_x = x * cos(a.orientation) - y * sin(a.orientation)
    offset_y = x * sin(a.orientation) + y * cos(a.orientation)

    connections = (
        connect(a.x, along.base),
        connect(along.point, b.x),
        connect(a.y, upward.base),
        connect(upward.point, b.y),
        connect(a.angle, b.angle, along.rotation, upward.rotation),
        connect(-offset_y, along.arm),
        connect(offset_x, upward.arm),
        connect(a.position_x + offset_x, b.position_x),
        connect(a.position_y + offset_y, b.position_y),
        connect(a.orientation, b.orientation),
    )
