"""Dry friction that sticks, and clutches that lock: their modes change at located instants."""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.expressions import Expr, ExprLike, where
from propermodel.library.mechanics.rotation.sources import FixedShaft
from propermodel.modelling import (
    Component,
    Discrete,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    connect,
    parameter,
    quantity,
    when,
)
from propermodel.modelling.events import When

STANDSTILL = quantity(1e-12, "rad/s")  # above rounding, below every speed that matters
REVERSAL = quantity(1e-6, "rad/s")  # a speed beyond it, after a change of sign, comes from an impact
NO_TORQUE = quantity(0.0, "N.m")


class LockingClutch(Resistance):
    """A friction clutch between two shafts: it slips with its capacity, locks when the slip has come to zero, lets go.

    It lets go when the torque that it holds exceeds `breakaway` times its capacity, a signal. An impact makes it slip.
    """

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    capacity = Input("N.m")
    breakaway: Parameter = parameter("1", default=1.0, low=1.0, doc="of the capacity, to begin to slip")
    mode = Discrete("1")  # 1 and -1: slipping forward and backward, 0: locked

    def effort(self, flow: Expr) -> Expr:
        return self.capacity * self.mode

    def locked(self) -> Expr:
        """While there is no slip."""
        return abs(self.mode) < 0.5

    def events(self) -> tuple[When, ...]:
        """It locks, turns round, or lets go."""
        slip, held, most = self.port.flow, self.port.effort, self.breakaway * self.capacity
        sticks = abs(self.mode) < 0.5
        is_small = abs(slip) < REVERSAL
        stop = where(is_small, 0.0, -1.0)  # a restitution of -1 leaves the slip as it is
        return (
            when((self.mode > 0.5) & (slip < -STANDSTILL), {self.mode: where(is_small, 0.0, -1.0)}, restitution=stop),
            when((self.mode < -0.5) & (slip > STANDSTILL), {self.mode: where(is_small, 0.0, 1.0)}, restitution=stop),
            when(sticks & ((slip > STANDSTILL) | ((held > most) & (slip >= -STANDSTILL))), {self.mode: 1.0}),
            when(sticks & ((slip < -STANDSTILL) | ((held < -most) & (slip <= STANDSTILL))), {self.mode: -1.0}),
        )


class Freewheel(Resistance):
    """A one-way clutch: `a` drives `b` and never runs ahead of it; `b` may run ahead of `a` without a torque.

    It locks when `a` has caught up, and lets go when it would have to pull back.
    """

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    least_slip: Parameter = parameter("rad/s", default=1e-6, low=0.0, doc="at which it locks, above rounding")
    least_torque: Parameter = parameter("N.m", default=1e-9, low=0.0, doc="at which it lets go, above rounding")
    holds = Discrete("1")  # 1: locked, 0: free

    def effort(self, flow: Expr) -> Expr:
        return NO_TORQUE

    def locked(self) -> Expr:
        """While `a` drives `b`."""
        return self.holds > 0.5

    def events(self) -> tuple[When, ...]:
        """It locks or lets go."""
        is_locked = self.holds > 0.5
        return (
            when(~is_locked & (self.port.flow > self.least_slip), {self.holds: 1.0}, restitution=0.0),
            when(is_locked & (self.port.effort < -self.least_torque), {self.holds: 0.0}),
        )


class ConstantCapacity(SignalBlock):
    """The same torque always."""

    torque: Parameter = parameter("N.m", low=0.0)
    capacity = Output("N.m")

    def outputs(self) -> Mapping[Expr, ExprLike]:
        return {self.capacity: self.torque}


class StickingFriction(Component):
    """Coulomb friction between two shafts: a constant torque while they slip, whatever holds them while they stick."""

    a = Port(Rotation)
    b = Port(Rotation)
    torque: Parameter = parameter("N.m", low=0.0, doc="while slipping")
    breakaway: Parameter = parameter("1", default=1.0, low=1.0, doc="of the torque, to begin to slip")

    contact = LockingClutch(breakaway=breakaway)
    capacity = ConstantCapacity(torque=torque)

    connections = (
        connect(a, contact.a),
        connect(b, contact.b),
        connect(capacity.capacity, contact.capacity),
    )


class Brake(Component):
    """A brake between a shaft and the frame that slips with its capacity, a signal, and holds the shaft at rest."""

    shaft = Port(Rotation)
    capacity = Input("N.m")
    breakaway: Parameter = parameter("1", default=1.0, low=1.0, doc="of the capacity, to begin to slip")

    disc = LockingClutch(breakaway=breakaway)
    frame = FixedShaft()

    connections = (
        connect(shaft, disc.a),
        connect(disc.b, frame.shaft),
        connect(capacity, disc.capacity),
    )
