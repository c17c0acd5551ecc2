"""Resistors, capacitors, inductors, diodes, transformers and gyrators between pins."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, exp, minimum
from propermodel.modelling import (
    Compliance,
    Component,
    Electrical,
    Gyrator,
    Inertia,
    Input,
    MultiportInertia,
    Parameter,
    Port,
    Resistance,
    State,
    Transformer,
    connect,
    parameter,
)


def exponential(voltage: Expr, scale: Expr, knee: Expr) -> Expr:
    """exp(voltage / scale), going on as its tangent above `knee`."""
    within = minimum(voltage, knee)
    return exp(within / scale) * (1.0 + (voltage - within) / scale)


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


class Conductor(Resistance):
    """An ohmic resistor by its conductance, which may be zero."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    conductance: Parameter = parameter("1/Ohm", low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * effort


class SaturatingInductor(Inertia):
    """A coil whose iron saturates: i = lambda / L (1 + (lambda / lambda_s)^2).

    At the flux linkage `saturation` it takes twice the current of a linear coil.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    inductance: Parameter = parameter("H", low=0.0, doc="at small currents")
    saturation: Parameter = parameter("V.s", low=0.0)
    start_flux: Parameter = parameter("V.s", default=0.0)

    def flow(self, momentum: Expr) -> Expr:
        share = momentum / self.saturation
        return momentum / self.inductance * (1.0 + share * share)

    def energy(self, momentum: Expr) -> Expr:
        """The integral of current over flux linkage."""
        share = momentum / self.saturation
        return 0.5 * momentum * momentum / self.inductance * (1.0 + 0.5 * share * share)

    def start(self) -> Expr:
        """The flux linkage at the start."""
        return self.start_flux


class VariableResistor(Resistance):
    """An ohmic resistor whose resistance is a signal."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    resistance = Input("Ohm")

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow


class VariableCapacitor(Compliance):
    """A capacitor whose capacitance is a signal; what changes it works on the field, which the energy balance names."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    capacitance = Input("F")
    start_charge: Parameter = parameter("C", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacitance

    def start(self) -> Expr:
        """The charge at the start."""
        return self.start_charge


class VariableInductor(Inertia):
    """A coil whose inductance is a signal; what changes it works on the field, which the energy balance names."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    inductance = Input("H")
    start_flux: Parameter = parameter("V.s", default=0.0)

    def flow(self, momentum: Expr) -> Expr:
        return momentum / self.inductance

    def start(self) -> Expr:
        """The flux linkage at the start."""
        return self.start_flux


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
        forward = exponential(effort, self.thermal_voltage, self.knee) - 1.0
        return self.saturation_current * forward + self.leakage * effort


class ZenerDiode(Resistance):
    """Two exponentials: forward as a Shockley diode, backward beyond the breakdown voltage.

    i = I_s (exp(v / n V_t) - 1) - I_s exp(-(v + V_b) / n V_t) + G v; both go on as their tangents beyond `knee`.
    """

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    breakdown_voltage: Parameter = parameter("V", low=0.0)
    saturation_current: Parameter = parameter("A", default=1e-9, low=0.0)
    thermal_voltage: Parameter = parameter("V", default=0.02585, low=0.0, doc="times the ideality factor")
    leakage: Parameter = parameter("1/Ohm", default=1e-9, low=0.0)
    knee: Parameter = parameter("V", default=0.8)

    def flow(self, effort: Expr) -> Expr:
        forward = exponential(effort, self.thermal_voltage, self.knee) - 1.0
        backward = exponential(-effort - self.breakdown_voltage, self.thermal_voltage, self.knee)
        return self.saturation_current * (forward - backward) + self.leakage * effort


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


class IdealGyrator(Gyrator):
    """Two pairs of pins: each voltage is `resistance` times the current at the other pair (Tellegen 1948)."""

    primary_a = Port(Electrical)
    primary_b = Port(Electrical)
    secondary_a = Port(Electrical)
    secondary_b = Port(Electrical)
    a = Port(Electrical, between=(primary_a, primary_b))
    b = Port(Electrical, between=(secondary_a, secondary_b))
    resistance: Parameter = parameter("Ohm", low=0.0)

    def modulus(self) -> Expr:
        return self.resistance


class Potentiometer(Component):
    """A resistor with a sliding contact; `position` is a signal from 0 (wiper at `a`) to 1 (at `b`)."""

    a = Port(Electrical)
    b = Port(Electrical)
    wiper = Port(Electrical)
    position = Input("1")
    resistance: Parameter = parameter("Ohm", low=0.0, doc="from end to end")

    to_a = VariableResistor()
    to_b = VariableResistor()

    connections = (
        connect(a, to_a.a),
        connect(to_a.b, wiper, to_b.a),
        connect(to_b.b, b),
        connect(resistance * position, to_a.resistance),
        connect(resistance * (1.0 - position), to_b.resistance),
    )


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
