"""Resistors, capacitors, inductors, diodes and transformers between pins."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, exp, minimum
from propermodel.modelling import (
    Compliance,
    Electrical,
    Inertia,
    Input,
    MultiportInertia,
    Parameter,
    Port,
    Resistance,
    State,
    Transformer,
    parameter,
)


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


class VariableResistor(Resistance):
    """An ohmic resistor whose resistance is a signal."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    resistance = Input("Ohm")

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow


class Diode(Resistance):
    """Shockley's diode beside a leakage: i = I_s (exp(v / n V_t) - 1) + G v.

    Above `knee` the exponential goes on as its tangent, so that a wild guess of a solver cannot overflow.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    saturation_current: Parameter = parameter("A", default=1e-9, low=0.0)
    thermal_voltage: Parameter = parameter("V", default=0.02585, low=0.0, doc="times the ideality factor")
    leakage: Parameter = parameter("1/Ohm", default=1e-9, low=0.0)
    knee: Parameter = parameter("V", default=0.8)

    def flow(self, effort: Expr) -> Expr:
        shape = exp(minimum(effort, self.knee) / self.thermal_voltage)
        beyond = (effort - minimum(effort, self.knee)) / self.thermal_voltage
        return self.saturation_current * (shape * (1.0 + beyond) - 1.0) + self.leakage * effort


class IdealTransformer(Transformer):
    """Two windings without loss or leakage: `ratio` is the turns of the primary over those of the secondary."""

    primary_a = Port(Electrical)
    primary_b = Port(Electrical)
    secondary_a = Port(Electrical)
    secondary_b = Port(Electrical)
    a = Port(Electrical, between=(primary_a, primary_b))
    b = Port(Electrical, between=(secondary_a, secondary_b))
    ratio: Parameter = parameter("1", low=0.0)

    def modulus(self) -> Expr:
        return self.ratio


class CoupledInductors(MultiportInertia):
    """Two coils that share flux: lambda_1 = L_1 i_1 + M i_2, lambda_2 = M i_1 + L_2 i_2, M = k sqrt(L_1 L_2).

    A field with one flux linkage for each port; its currents are the gradient of its energy, so it is reciprocal. With
    k = 1 the inductances have no inverse: use an `IdealTransformer` and one `Inductor`.
    """

    primary_a = Port(Electrical)
    primary_b = Port(Electrical)
    secondary_a = Port(Electrical)
    secondary_b = Port(Electrical)
    primary = Port(Electrical, between=(primary_a, primary_b))
    secondary = Port(Electrical, between=(secondary_a, secondary_b))
    primary_inductance: Parameter = parameter("H", low=0.0)
    secondary_inductance: Parameter = parameter("H", low=0.0)
    mutual_inductance: Parameter = parameter("H")
    primary_flux = State("V.s")
    secondary_flux = State("V.s")

    def momenta(self) -> dict[Expr, ExprLike]:
        """The flux linkages are the coordinates."""
        return {self.primary.momentum: self.primary_flux, self.secondary.momentum: self.secondary_flux}

    def energy(self) -> Expr:
        """Half of flux times inverse inductances times flux."""
        first, second, mutual = self.primary_inductance, self.secondary_inductance, self.mutual_inductance
        determinant = first * second - mutual * mutual
        p, s = self.primary_flux, self.secondary_flux
        return 0.5 * (second * p * p - 2.0 * mutual * p * s + first * s * s) / determinant
