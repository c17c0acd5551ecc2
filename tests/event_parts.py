"""Components with events that the tests of several rooms run."""

from __future__ import annotations

from propermodel import (
    Compliance,
    Component,
    Discrete,
    EffortSource,
    Expr,
    Inertia,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    SignalBlock,
    State,
    Translation,
    connect,
    parameter,
    quantity,
    when,
    where,
)
from tests.parts import Fixed, Mass, Velocity


class Weight(EffortSource):
    """Pulls down what is connected to it."""

    flange = Port(Translation)
    force: Parameter = parameter("N", default=20.0)

    def effort(self) -> Expr:
        return self.force


class Height(SignalBlock):
    speed = Input("m/s")
    height = Output("m")
    x = State("m", start=1.0)

    def outputs(self):
        return {self.height: self.x}

    def derivatives(self):
        return {self.x: self.speed}


class Ball(Inertia):
    """A ball that leaves the floor with a share of the speed with which it came."""

    flange = Port(Translation)
    height = Input("m")
    mass: Parameter = parameter("kg", default=2.0)
    restitution: Parameter = parameter("", default=0.8)

    def flow(self, momentum: Expr) -> Expr:
        return momentum / self.mass

    def events(self):
        hits = (self.height < 0.0) & (self.flange.flow < 0.0)
        return (when(hits, {self.flange.momentum: -self.restitution * self.flange.momentum}),)


class BouncingBall(Component):
    """A ball of 2 kg under 20 N that falls from 1 m."""

    ball = Ball()
    weight = Weight()
    height = Height()

    connections = (
        connect(ball.flange, weight.flange),
        connect(ball.flange.flow, height.speed),
        connect(height.height, ball.height),
    )


class Room(SignalBlock):
    """A room that a heater with two thresholds heats: x' = (2 u - x) / T."""

    hot: Parameter = parameter("", default=1.1)
    cold: Parameter = parameter("", default=0.9)
    lag: Parameter = parameter("s", default=1.0)
    level = Output("")
    is_on = Discrete("", start=1.0)
    x = State("", start=0.5)

    def outputs(self):
        return {self.level: self.x}

    def derivatives(self):
        return {self.x: (2.0 * self.is_on - self.x) / self.lag}

    def events(self):
        return (when(self.x > self.hot, {self.is_on: 0.0}), when(self.x < self.cold, {self.is_on: 1.0}))


class Heated(Component):
    room = Room()


class TwoStageDamper(Resistance):
    """A damper that takes its second coefficient for good when the speed has fallen below a threshold."""

    flange = Port(Translation)
    first: Parameter = parameter("N.s/m", default=1.0)
    second: Parameter = parameter("N.s/m", default=4.0)
    threshold: Parameter = parameter("m/s", default=0.5)
    stage = Discrete("", start=1.0)

    def effort(self, flow: Expr) -> Expr:
        return where(self.stage > 1.5, self.second, self.first) * flow

    def events(self):
        return (when(self.flange.flow < self.threshold, {self.stage: 2.0}),)


class SlowingMass(Component):
    mass = Mass(mass=1.0)
    damper = TwoStageDamper()

    connections = (connect(mass.flange, damper.flange),)


class Ratchet(Compliance):
    """A spring that jumps a tooth, to rest, when it is stretched by one."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m", default=8.0)
    tooth: Parameter = parameter("m", default=0.5)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement

    def events(self):
        return (when(self.port.displacement >= self.tooth, {self.port.displacement: quantity(0.0, "m")}),)


class Winding(Component):
    """A ratchet that is drawn at 1 m/s."""

    drive = Velocity(velocity=1.0)
    ratchet = Ratchet()
    wall = Fixed()

    connections = (connect(drive.flange, ratchet.a), connect(ratchet.b, wall.flange))
