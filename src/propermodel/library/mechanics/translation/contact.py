"""Rigid contact: impacts with restitution, and rest."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    Discrete,
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
)
from propermodel.modelling.events import When

STANDSTILL = quantity(1e-12, "m/s")  # above rounding, below every speed that matters


class RigidContact(Resistance):
    """Two flanges that cannot pass through each other: they bounce off, or rest on each other until they are pulled.

    Newton's law of restitution: they separate with `restitution` times the speed of approach. At most `rest_speed`
    leaves them at rest.
    """

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    gap = Input("m")
    restitution: Parameter = parameter("1", low=0.0, high=1.0)
    rest_speed: Parameter = parameter("m/s", low=0.0)
    resting = Discrete("1")

    def effort(self, flow: Expr) -> Expr:
        return quantity(0.0, "N")

    def locked(self) -> Expr:
        """While they rest on each other."""
        return self.resting > 0.5

    def events(self) -> tuple[When, ...]:
        """They bounce, come to rest, or part."""
        speed, is_resting = self.port.flow, self.resting > 0.5
        meets = ((self.gap < 0.0) | is_resting) & (speed > STANDSTILL)
        is_pulled = (self.port.effort < 0.0) | (speed < -STANDSTILL)
        return (
            when(meets & (speed > self.rest_speed), {self.resting: 0.0}, restitution=self.restitution),
            when(meets & (speed <= self.rest_speed), {self.resting: 1.0}, restitution=0.0),
            when(is_resting & is_pulled, {self.resting: 0.0}),
        )


class Separation(SignalBlock):
    """The gap that closes with the speed of approach."""

    approach = Input("m/s")
    gap = Output("m")
    start: Parameter = parameter("m")
    width = State("m", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.gap: self.width}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.width: -self.approach}


class Impact(Component):
    """A rigid stop between two flanges: a gap, and bodies that bounce when it has closed.

    The gap closes as flange `a` moves in the positive direction towards flange `b`.
    """

    a = Port(Translation)
    b = Port(Translation)
    start_gap: Parameter = parameter("m", default=0.0, low=0.0)
    restitution: Parameter = parameter("1", default=0.5, low=0.0, high=1.0)
    rest_speed: Parameter = parameter("m/s", default=1e-3, low=0.0, doc="approach below which they rest")
    gap = Output("m")

    contact = RigidContact(restitution=restitution, rest_speed=rest_speed)
    separation = Separation(start=start_gap)

    connections = (
        connect(a, contact.a),
        connect(b, contact.b),
        connect(contact.port.flow, separation.approach),
        connect(separation.gap, contact.gap, gap),
    )
