"""A direct-current motor, a voice coil and an operational amplifier."""

from __future__ import annotations

import math

from propermodel.expressions import Expr, ExprLike
from propermodel.library.electrical.components import Inductor, Resistor
from propermodel.library.electrical.sensors import VoltageSensor
from propermodel.library.electrical.sources import VoltageSource
from propermodel.library.mechanics.rotation.components import RotatingInertia, ViscousFriction
from propermodel.modelling import (
    Component,
    Electrical,
    Gyrator,
    Input,
    Output,
    Parameter,
    Port,
    Rotation,
    SignalBlock,
    State,
    Translation,
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


class VoiceCoil(Gyrator):
    """A coil in the field of a magnet: force B l i, voltage B l v."""

    pin_a = Port(Electrical)
    pin_b = Port(Electrical)
    a = Port(Electrical, between=(pin_a, pin_b))
    b = Port(Translation)
    constant: Parameter = parameter("N/A", low=0.0, doc="flux density times length of wire")

    def modulus(self) -> Expr:
        return self.constant


class OnePoleGain(SignalBlock):
    """An open-loop gain with a single pole: dv/dt = 2 pi f_t (difference - v / gain)."""

    difference = Input("V")
    voltage = Output("V")
    gain: Parameter = parameter("1", low=0.0)
    transit_frequency: Parameter = parameter("Hz", low=0.0)
    amplified = State("V")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.voltage: self.amplified}

    def derivatives(self) -> dict[Expr, ExprLike]:
        rate = 2.0 * math.pi * self.transit_frequency
        return {self.amplified: rate * (self.difference - self.amplified / self.gain)}


class OperationalAmplifier(Component):
    """An amplifier of high gain and one pole; it takes no current at its inputs and feeds its output from a supply.

    Its bonds are activated ones: two sensors that take no power and a source that they control.
    """

    plus = Port(Electrical)
    minus = Port(Electrical)
    output = Port(Electrical)
    gain: Parameter = parameter("1", default=1e5, low=0.0)
    transit_frequency: Parameter = parameter("Hz", default=1e6, low=0.0, doc="where the open-loop gain is one")

    feel_plus = VoltageSensor()
    feel_minus = VoltageSensor()
    amplifier = OnePoleGain(gain=gain, transit_frequency=transit_frequency)
    supply = VoltageSource()

    connections = (
        connect(plus, feel_plus.pin),
        connect(minus, feel_minus.pin),
        connect(supply.pin, output),
        connect(feel_plus.voltage - feel_minus.voltage, amplifier.difference),
        connect(amplifier.voltage, supply.voltage),
    )
