"""A rigid body in the plane: one inertia for each degree of freedom and the gyrator of its turning frame."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, cos, sin
from propermodel.library.mechanics.rotation.components import RotatingInertia
from propermodel.library.mechanics.translation.components import Mass, Projection
from propermodel.modelling import (
    Component,
    Gyrator,
    Input,
    Output,
    Parameter,
    Port,
    Rotation,
    SignalBlock,
    Translation,
    connect,
    parameter,
)


class EulerGyrator(Gyrator):
    """What a turning frame does to a mass: m (du/dt - q w) = F_x, m (dw/dt + q u) = F_z (Karnopp et al., ch. 9).

    Forward velocity u at `a`, upward velocity w at `b`, pitch rate q nose up.
    """

    a = Port(Translation)
    b = Port(Translation)
    mass: Parameter = parameter("kg", low=0.0)
    pitch_rate = Input("rad/s")

    def modulus(self) -> Expr:
        return -self.mass * self.pitch_rate


class PlanarBody(Component):
    """A rigid body with three degrees of freedom; each is an energy element of its own."""

    forward = Port(Translation)
    vertical = Port(Translation)
    pitch = Port(Rotation)
    mass: Parameter = parameter("kg", low=0.0)
    pitch_inertia: Parameter = parameter("kg.m2", low=0.0, doc="about the centre of gravity")
    start_speed: Parameter = parameter("m/s", default=0.0)

    forward_mass = Mass(mass=mass, start_velocity=start_speed)
    vertical_mass = Mass(mass=mass)
    inertia = RotatingInertia(inertia=pitch_inertia)
    gyrator = EulerGyrator(mass=mass)

    connections = (
        connect(forward, forward_mass.flange, gyrator.a),
        connect(gyrator.b, vertical_mass.flange, vertical),
        connect(pitch, inertia.shaft),
        connect(inertia.shaft.flow, gyrator.pitch_rate),
    )


class Sines(SignalBlock):
    """Sine and cosine of an angle."""

    angle = Input("rad")
    sine = Output("1")
    cosine = Output("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.sine: sin(self.angle), self.cosine: cos(self.angle)}


class PlanarFrame(Component):
    """From velocities along the body's axes to those along and across the path, for a body pitched nose up."""

    forward = Port(Translation)
    vertical = Port(Translation)
    along = Port(Translation)
    upward = Port(Translation)
    sine = Input("1")
    cosine = Input("1")

    to_along = Projection()
    to_upward = Projection()

    connections = (
        connect(forward, to_along.first, to_upward.first),
        connect(vertical, to_along.second, to_upward.second),
        connect(to_along.along, along),
        connect(to_upward.along, upward),
        connect(cosine, to_along.first_share, to_upward.second_share),
        connect(-sine, to_along.second_share),
        connect(sine, to_upward.first_share),
    )
