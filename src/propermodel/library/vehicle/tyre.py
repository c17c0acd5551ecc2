"""A truck tyre on the pitch plane: vertical spring and damper, slip force and rolling resistance."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, maximum, sqrt, tanh
from propermodel.library.mechanics.rotation import RollingWheel
from propermodel.library.mechanics.translation import Damper, Spring
from propermodel.modelling import (
    Component,
    FlowSource,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    Translation,
    connect,
    parameter,
)

CHRONO = "Project Chrono MTV, 395/85R20 tyre"


class RoughRoad(FlowSource):
    """The vertical velocity of a rough road under a tyre: slope of the profile times speed along the path."""

    ground = Port(Translation)
    slope = Input("1")
    speed = Input("m/s")

    def flow(self) -> Expr:
        return self.slope * self.speed


class NormalLoad(SignalBlock):
    """Static load plus deviation; a tyre cannot pull."""

    deviation = Input("N")
    load = Output("N")
    static_load: Parameter = parameter("N", low=0.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.load: maximum(self.static_load + self.deviation, 0.0)}


class SlipForce(Resistance):
    """Traction in proportion to slip, up to the friction limit: F = clip(C N slip, -mu N, mu N).

    The slip speed between rim `a` and hub `b` is divided by the hub speed, sqrt(v^2 + v_0^2) with a floor v_0.
    """

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    load = Input("N")
    speed = Input("m/s")
    stiffness: Parameter = parameter(
        "1", default=17.7, low=0.0, source=CHRONO + ", slip stiffness over load", status="derived"
    )
    friction: Parameter = parameter("1", default=0.8, low=0.0, source=CHRONO, status="published")
    speed_floor: Parameter = parameter("m/s", default=1.0, low=0.0, status="estimated")

    def effort(self, flow: Expr) -> Expr:
        slip = flow / sqrt(self.speed * self.speed + self.speed_floor * self.speed_floor)
        limit = self.friction * self.load
        return clip(self.stiffness * self.load * slip, -limit, limit)


class RollingResistance(Resistance):
    """Rolling resistance at the wheel, T = f_r N R tanh(omega R / v_0)."""

    shaft = Port(Rotation)
    load = Input("N")
    coefficient = Input("1")
    radius: Parameter = parameter("m", low=0.0)
    width: Parameter = parameter("m/s", default=0.1, low=0.0, status="estimated", doc="of the sign of speed")

    def effort(self, flow: Expr) -> Expr:
        return self.coefficient * self.load * self.radius * tanh(flow * self.radius / self.width)


class Tyre(Component):
    """Both tyres of an axle, 395/85R20, from the road to the hub and the wheel."""

    wheel = Port(Rotation)
    along = Port(Translation)
    upward = Port(Translation)
    road_slope = Input("1")
    rolling_coefficient = Input("1")
    normal_load = Output("N")
    static_load: Parameter = parameter("N", low=0.0)
    radius: Parameter = parameter("m", low=0.0, doc="effective rolling radius, in speed and torque")
    stiffness: Parameter = parameter(
        "N/m", default=1.598e6, low=0.0, source=CHRONO + ": rated load over 16 % of 0.336 m", status="derived"
    )
    damping: Parameter = parameter(
        "N.s/m", default=1.88e3, low=0.0, source=CHRONO + ": 2 xi sqrt(k m), xi = 0.05", status="derived"
    )

    road = RoughRoad()
    spring = Spring(stiffness=stiffness)
    damper = Damper(damping=damping)
    contact = RollingWheel(radius=radius)
    slip = SlipForce()
    rolling = RollingResistance(radius=radius)
    load = NormalLoad(static_load=static_load)

    connections = (
        connect(road.ground, spring.a, damper.a),
        connect(spring.b, damper.b, upward),
        connect(wheel, contact.a, rolling.shaft),
        connect(contact.b, slip.a),
        connect(slip.b, along),
        connect(road_slope, road.slope),
        connect(along.flow, road.speed, slip.speed),
        connect(spring.port.effort + damper.port.effort, load.deviation),
        connect(load.load, slip.load, rolling.load, normal_load),
        connect(rolling_coefficient, rolling.coefficient),
    )
