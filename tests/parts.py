"""Small components that the tests of several rooms build models from."""

from __future__ import annotations

from propermodel.expressions.core import Expr
from propermodel.modelling import (
    Compliance,
    Component,
    EffortSource,
    Electrical,
    FlowSource,
    Gyrator,
    Hydraulic,
    Inertia,
    Parameter,
    Port,
    Resistance,
    Rotation,
    Transformer,
    Translation,
    connect,
    parameter,
)

# -- translation ----------------------------------------------------------------------------------------


class Spring(Compliance):
    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m")

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement


class Damper(Resistance):
    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class Mass(Inertia):
    flange = Port(Translation)
    mass: Parameter = parameter("kg")

    def momentum(self, flow: Expr) -> Expr:
        return self.mass * flow


class Force(EffortSource):
    """Pushes with a constant force: power leaves it."""

    flange = Port(Translation)
    force: Parameter = parameter("N")

    def effort(self) -> Expr:
        return self.force


class Velocity(FlowSource):
    flange = Port(Translation)
    velocity: Parameter = parameter("m/s")

    def flow(self) -> Expr:
        return self.velocity


class Fixed(FlowSource):
    flange = Port(Translation)

    def flow(self) -> float:
        return 0.0


class Lever(Transformer):
    """v_b = ratio v_a."""

    a = Port(Translation)
    b = Port(Translation)
    ratio: Parameter = parameter("1")

    def modulus(self) -> Expr:
        return self.ratio


class SpringDamper(Component):
    a = Port(Translation)
    b = Port(Translation)
    stiffness: Parameter = parameter("N/m")
    damping: Parameter = parameter("N.s/m")

    spring = Spring(stiffness=stiffness)
    damper = Damper(damping=damping)

    connections = (connect(a, spring.a, damper.a), connect(b, spring.b, damper.b))


# -- rotation -------------------------------------------------------------------------------------------


class Flywheel(Inertia):
    shaft = Port(Rotation)
    inertia: Parameter = parameter("kg.m2")

    def momentum(self, flow: Expr) -> Expr:
        return self.inertia * flow


class Bearing(Resistance):
    shaft = Port(Rotation)
    friction: Parameter = parameter("N.m.s/rad")

    def effort(self, flow: Expr) -> Expr:
        return self.friction * flow


class Torque(EffortSource):
    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m")

    def effort(self) -> Expr:
        return self.torque


class Gear(Transformer):
    """Shaft b turns `ratio` times as fast as shaft a."""

    a = Port(Rotation)
    b = Port(Rotation)
    ratio: Parameter = parameter("1")

    def modulus(self) -> Expr:
        return self.ratio


# -- electrical and hydraulic -----------------------------------------------------------------------------


class Capacitor(Compliance):
    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    capacitance: Parameter = parameter("F")

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacitance


class Resistor(Resistance):
    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    resistance: Parameter = parameter("Ohm")

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow


class Coil(Inertia):
    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    inductance: Parameter = parameter("H")

    def momentum(self, flow: Expr) -> Expr:
        return self.inductance * flow


class Voltage(EffortSource):
    """The voltage of `a` against `b`."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    voltage: Parameter = parameter("V")

    def effort(self) -> Expr:
        return self.voltage


class Ground(EffortSource):
    pin = Port(Electrical)

    def effort(self) -> float:
        return 0.0


class Motor(Gyrator):
    a = Port(Electrical)
    b = Port(Rotation)
    constant: Parameter = parameter("V.s/rad")

    def modulus(self) -> Expr:
        return self.constant


class Tank(Compliance):
    port = Port(Hydraulic)
    capacity: Parameter = parameter("m3/Pa")

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacity


class Pipe(Resistance):
    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    loss: Parameter = parameter("Pa.s/m3")

    def effort(self, flow: Expr) -> Expr:
        return self.loss * flow


class Line(Inertia):
    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    inertance: Parameter = parameter("kg/m4")

    def momentum(self, flow: Expr) -> Expr:
        return self.inertance * flow
