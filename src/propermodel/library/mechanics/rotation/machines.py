"""Gears, differentials and wheels, ideal and lossy.

A lossy gear is an ideal one with a resistance on its output shaft. The torque of that resistance is the share 1 - e
of the torque passed, so the output torque is the ideal torque times e, whichever way power flows.
"""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, minimum, where
from propermodel.library.mechanics.translation.components import SpringDamper
from propermodel.modelling import (
    Component,
    Input,
    Parameter,
    Port,
    Resistance,
    Rotation,
    Transformer,
    Translation,
    ZeroJunction,
    bond,
    connect,
    parameter,
)


def passing_efficiency(power: Expr, efficiency: Expr, width: Expr) -> Expr:
    """Output torque over ideal torque: eta forward, 1/eta backward, blended through zero power over a width.

    Args:
        power: Power that enters in the driving direction.
        efficiency: Torque efficiency eta.
        width: Power below which the loss fades out, so that nothing jumps at reversal.
    """
    forward = 1.0 - minimum(power / width, 1.0) * (1.0 - efficiency)
    backward = 1.0 / (1.0 - minimum(-power / width, 1.0) * (1.0 - efficiency))
    return where(power >= 0.0, forward, backward)


class Gear(Transformer):
    """An ideal gear: the ratio is input speed over output speed."""

    a = Port(Rotation)
    b = Port(Rotation)
    ratio: Parameter = parameter("1", low=0.0)

    def modulus(self) -> ExprLike:
        return 1.0 / self.ratio


class ModulatedGear(Transformer):
    """An ideal gear whose ratio may change while it runs."""

    a = Port(Rotation)
    b = Port(Rotation)
    ratio = Input("1")

    def modulus(self) -> ExprLike:
        return 1.0 / self.ratio


class TorqueDrivenLoss(Resistance):
    """The loss of a gear by the torque that drives it: (1 - e) times the ideal output torque."""

    shaft = Port(Rotation)
    torque = Input("N.m")
    efficiency = Input("1")
    width: Parameter = parameter(
        "W", default=100.0, low=0.0, status="estimated", doc="power over which the loss fades in"
    )

    def effort(self, flow: Expr) -> Expr:
        return (1.0 - passing_efficiency(self.torque * flow, self.efficiency, self.width)) * self.torque


class TorqueGivenLoss(Resistance):
    """The loss of a gear by the torque that it gives: (1/e - 1) times the real output torque."""

    shaft = Port(Rotation)
    torque = Input("N.m")
    efficiency = Input("1")
    width: Parameter = parameter(
        "W", default=100.0, low=0.0, status="estimated", doc="power over which the loss fades in"
    )

    def effort(self, flow: Expr) -> Expr:
        return (1.0 / passing_efficiency(self.torque * flow, self.efficiency, self.width) - 1.0) * self.torque


class LossyGear(Component):
    """A gear that is ideal in speed and lossy in torque."""

    a = Port(Rotation)
    b = Port(Rotation)
    ratio: Parameter = parameter("1", default=1.0, low=0.0)
    efficiency: Parameter = parameter("1", low=0.0, high=1.0)

    gear = Gear(ratio=ratio)
    loss = TorqueDrivenLoss()

    connections = (
        connect(a, gear.a),
        connect(gear.b, loss.shaft, b),
        connect(gear.b.effort, loss.torque),
        connect(efficiency, loss.efficiency),
    )


class TorqueShare(Transformer):
    """A share of a torque, T_b = share * T_a."""

    a = Port(Rotation)
    b = Port(Rotation)
    share: Parameter = parameter("1", low=0.0, high=1.0)

    def modulus(self) -> ExprLike:
        return 1.0 / self.share


class Differential(Component):
    """An ideal differential: fixed shares of the torque, and the mean of the speeds weighed by them."""

    drive = Port(Rotation)
    left = Port(Rotation)
    right = Port(Rotation)
    share: Parameter = parameter("1", default=0.5, low=0.0, high=1.0, doc="share of the torque on `left`")

    to_left = TorqueShare(share=share)
    to_right = TorqueShare(share=1.0 - share)
    split = ZeroJunction()

    connections = (
        bond(drive, split),
        bond(split, to_left.a),
        bond(split, to_right.a),
        connect(to_left.b, left),
        connect(to_right.b, right),
    )


class RollingWheel(Transformer):
    """Rotation into translation at a radius: v = radius * omega."""

    a = Port(Rotation)
    b = Port(Translation)
    radius: Parameter = parameter("m", low=0.0)

    def modulus(self) -> Expr:
        return self.radius


class PlanetaryGear(Component):
    """An ideal planetary gear: w_carrier (1 + ratio) = w_sun + ratio w_ring.

    The `ratio` is the teeth of the ring over those of the sun (Willis' equation).
    """

    sun = Port(Rotation)
    carrier = Port(Rotation)
    ring = Port(Rotation)
    ratio: Parameter = parameter("1", low=1.0)

    of_sun = Gear(ratio=1.0 + ratio)
    of_ring = Gear(ratio=(1.0 + ratio) / ratio)
    total = ZeroJunction()

    connections = (
        connect(sun, of_sun.a),
        connect(ring, of_ring.a),
        bond(of_sun.b, total),
        bond(of_ring.b, total),
        bond(total, carrier),
    )


class BeltDrive(Component):
    """Two pulleys and a belt that stretches and does not slip."""

    a = Port(Rotation)
    b = Port(Rotation)
    radius_a: Parameter = parameter("m", low=0.0)
    radius_b: Parameter = parameter("m", low=0.0)
    stiffness: Parameter = parameter("N/m", low=0.0, doc="of both strands together")
    damping: Parameter = parameter("N.s/m", low=0.0)

    pulley_a = RollingWheel(radius=radius_a)
    pulley_b = RollingWheel(radius=radius_b)
    belt = SpringDamper(stiffness=stiffness, damping=damping)

    connections = (
        connect(a, pulley_a.a),
        connect(pulley_a.b, belt.a),
        connect(belt.b, pulley_b.b),
        connect(pulley_b.a, b),
    )
