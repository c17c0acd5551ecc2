"""Springs and dampers along the line between two frames."""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.expressions import Expr, sqrt
from propermodel.library.mechanics.planar.ports import Frame, Point
from propermodel.library.mechanics.rotation.sensors import NoTorque
from propermodel.modelling import (
    Compliance,
    Component,
    Input,
    KinematicTransformer,
    Parameter,
    Port,
    Resistance,
    Translation,
    connect,
    parameter,
)


class Distance(KinematicTransformer):
    """How far point `b` is from point `a`, which must not meet."""

    a = Point()
    b = Point()
    line = Port(Translation)
    x_a = Input("m")
    y_a = Input("m")
    x_b = Input("m")
    y_b = Input("m")

    def known(self) -> Mapping[Expr, Expr]:
        return {
            self.a.x.displacement: self.x_a,
            self.a.y.displacement: self.y_a,
            self.b.x.displacement: self.x_b,
            self.b.y.displacement: self.y_b,
        }

    def positions(self) -> Mapping[Expr, Expr]:
        x = self.b.x.displacement - self.a.x.displacement
        y = self.b.y.displacement - self.a.y.displacement
        return {self.line.displacement: sqrt(x * x + y * y)}


class Stretch(Compliance):
    """What a distance stores beyond a length at rest; it starts stretched as far as the distance then is."""

    port = Port(Translation)
    distance = Input("m")
    stiffness: Parameter = parameter("N/m", low=0.0)
    length: Parameter = parameter("m", low=0.0, doc="at rest")

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement

    def start(self) -> Expr:
        """The stretch at the start."""
        return self.distance - self.length


class LineDamping(Resistance):
    """A force that grows with the speed at which a distance grows."""

    port = Port(Translation)
    damping: Parameter = parameter("N.s/m", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class LineSpringDamper(Component):
    """A spring and a damper along the line between two frames, positive in tension; the frames must not meet."""

    a = Frame()
    b = Frame()
    stiffness: Parameter = parameter("N/m", low=0.0)
    length: Parameter = parameter("m", low=0.0, doc="at rest")
    damping: Parameter = parameter("N.s/m", default=0.0, low=0.0)

    between = Distance()
    spring = Stretch(stiffness=stiffness, length=length)
    damper = LineDamping(damping=damping)
    end_a = NoTorque()
    end_b = NoTorque()

    x = b.position_x - a.position_x
    y = b.position_y - a.position_y

    connections = (
        connect(a.x, between.a.x),
        connect(a.y, between.a.y),
        connect(b.x, between.b.x),
        connect(b.y, between.b.y),
        connect(a.angle, end_a.shaft),
        connect(b.angle, end_b.shaft),
        connect(between.line, spring.port, damper.port),
        connect(sqrt(x * x + y * y), spring.distance),
        connect(a.position_x, between.x_a),
        connect(a.position_y, between.y_a),
        connect(b.position_x, between.x_b),
        connect(b.position_y, between.y_b),
    )
