"""Resistors, capacitors and inductors between two pins."""

from __future__ import annotations

from propermodel.expressions import Expr
from propermodel.modelling import Compliance, Electrical, Inertia, Parameter, Port, Resistance, parameter


class Resistor(Resistance):
    """An ohmic resistor."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    resistance: Parameter = parameter("Ohm", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow


class Capacitor(Compliance):
    """A linear capacitor."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    capacitance: Parameter = parameter("F", low=0.0)
    start_voltage: Parameter = parameter("V", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacitance

    def start(self) -> Expr:
        """The charge at the start."""
        return self.capacitance * self.start_voltage


class Inductor(Inertia):
    """A linear inductor."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    inductance: Parameter = parameter("H", low=0.0)
    start_current: Parameter = parameter("A", default=0.0)

    def momentum(self, flow: Expr) -> Expr:
        return self.inductance * flow

    def start(self) -> Expr:
        """The flux linkage at the start."""
        return self.inductance * self.start_current
