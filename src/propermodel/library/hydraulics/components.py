"""Lines, orifices, valves, chambers, tanks and gas-charged vessels."""

from __future__ import annotations

from typing import ClassVar

from propermodel.expressions import Expr, ExprLike, log, sign, sqrt
from propermodel.library.hydraulics.fluids import NITROGEN, BenedictWebbRubin
from propermodel.modelling import (
    Compliance,
    Hydraulic,
    MultiportCompliance,
    Parameter,
    Port,
    Resistance,
    State,
    Thermal,
    parameter,
)


class LineResistance(Resistance):
    """Turbulent loss of a line between two ports: dp = R Q |Q|."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    resistance: Parameter = parameter("Pa.s2/m6", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.resistance * flow * abs(flow)

    def flow(self, effort: Expr) -> Expr:
        return sign(effort) * sqrt(abs(effort) / self.resistance)


class Orifice(Resistance):
    """A sharp orifice, Q = C_d A sqrt(2 |dp| / rho) (Merritt, Hydraulic Control Systems, ch. 3)."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    area: Parameter = parameter("m2", low=0.0)
    discharge: Parameter = parameter("1", default=0.61, low=0.0)
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        speed = flow / (self.discharge * self.area)
        return 0.5 * self.density * speed * abs(speed)

    def flow(self, effort: Expr) -> Expr:
        return sign(effort) * self.discharge * self.area * sqrt(2.0 * abs(effort) / self.density)


class Leakage(Resistance):
    """Laminar leakage between two ports."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    conductance: Parameter = parameter("m3/(s.Pa)", low=0.0)

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * effort


class OilChamber(Compliance):
    """Compressible oil in a stiff chamber: dp = (beta / V) dV."""

    port = Port(Hydraulic)
    volume: Parameter = parameter("m3", low=0.0)
    bulk_modulus: Parameter = parameter("Pa", default=1.7e9, low=0.0)
    start_pressure: Parameter = parameter("Pa", default=0.0, doc="gauge")

    def effort(self, displacement: Expr) -> Expr:
        return self.bulk_modulus / self.volume * displacement

    def start(self) -> Expr:
        """The oil pressed in at the start."""
        return self.start_pressure * self.volume / self.bulk_modulus


class GasVessel(MultiportCompliance):
    """Oil against a charge of real gas: a field that stores work at its oil port and heat at its wall.

    Pressure and temperature count from ambient, so the stored energy is what the gas could still do (availability):

        dE = (p - p_a) dV_oil + (T - T_a) dS,   E = m u + p_a V_gas - T_a m s + constant
    """

    gas: ClassVar[BenedictWebbRubin] = NITROGEN

    oil = Port(Hydraulic)
    wall = Port(Thermal)
    volume: Parameter = parameter("m3", low=0.0, doc="gas volume without oil")
    gas_mass: Parameter = parameter("kg", low=0.0)
    start_oil: Parameter = parameter("m3", default=0.0, low=0.0)
    start_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    ambient_pressure: Parameter = parameter(
        "Pa", default=101325.0, low=0.0, source="standard atmosphere", status="published"
    )
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    liner_heat_capacity: Parameter = parameter(
        "J/K", default=0.0, low=0.0, doc="foam that follows the gas temperature (Otis and Pourmovahed 1985)"
    )
    oil_volume = State("m3", start=start_oil)
    temperature = State("K", start=start_temperature)

    def specific_volume(self) -> Expr:
        """Gas volume per mass of gas."""
        return (self.volume - self.oil_volume) / self.gas_mass

    def entropy(self) -> Expr:
        """Entropy of gas and liner."""
        gas = self.gas_mass * self.gas.entropy(self.specific_volume(), self.temperature)
        return gas + self.liner_heat_capacity * log(self.temperature / self.gas.T0)

    def displacements(self) -> dict[Expr, ExprLike]:
        """Oil volume, and entropy."""
        return {self.oil.displacement: self.oil_volume, self.wall.displacement: self.entropy()}

    def efforts(self) -> dict[Expr, ExprLike]:
        """Gauge pressure, and temperature above ambient."""
        pressure = self.gas.pressure(self.specific_volume(), self.temperature)
        return {
            self.oil.effort: pressure - self.ambient_pressure,
            self.wall.effort: self.temperature - self.ambient_temperature,
        }

    def energy(self) -> Expr:
        """What the gas could still do against ambient, up to a constant."""
        inner = self.gas_mass * self.gas.inner_energy(self.specific_volume(), self.temperature)
        inner = inner + self.liner_heat_capacity * (self.temperature - self.gas.T0)
        displaced = self.ambient_pressure * (self.volume - self.oil_volume)
        return inner + displaced - self.ambient_temperature * self.entropy()
