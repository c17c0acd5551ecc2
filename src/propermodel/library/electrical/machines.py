"""A direct-current motor."""

from __future__ import annotations

from propermodel.expressions import Expr
from propermodel.library.electrical.components import Inductor, Resistor
from propermodel.library.mechanics.rotation.components import RotatingInertia, ViscousFriction
from propermodel.modelling import (
    Component,
    Electrical,
    Gyrator,
    Parameter,
    Port,
    Rotation,
    connect,
    parameter,
)


class ElectromechanicalConversion(Gyrator):
    """Voltage k omega, torque k i, with one constant for both because power is kept."""

    a = Port(Electrical)
    b = Port(Rotation)
    constant: Parameter = parameter("N.m/A", low=0.0)

    def modulus(self) -> Expr:
        return self.constant


class DCMotor(Component):
    """A permanent-magnet motor, its other pin on ground: winding, conversion, rotor and bearing friction."""

    pin = Port(Electrical)
    shaft = Port(Rotation)
    resistance: Parameter = parameter("Ohm", low=0.0)
    inductance: Parameter = parameter("H", low=0.0)
    constant: Parameter = parameter("N.m/A", low=0.0)
    inertia: Parameter = parameter("kg.m2", low=0.0)
    friction: Parameter = parameter("N.m.s/rad", default=0.0, low=0.0)

    winding = Resistor(resistance=resistance)
    coil = Inductor(inductance=inductance)
    conversion = ElectromechanicalConversion(constant=constant)
    rotor = RotatingInertia(inertia=inertia)
    bearing = ViscousFriction(damping=friction)

    connections = (
        connect(pin, winding.a),
        connect(winding.b, coil.a),
        connect(coil.b, conversion.a),
        connect(conversion.b, rotor.shaft, bearing.shaft, shaft),
    )
