"""Vessels of one port: open tanks with a level, and gas-charged accumulators of an ideal gas."""

from __future__ import annotations

from propermodel.expressions import Expr, exp, log
from propermodel.modelling import Compliance, Hydraulic, Parameter, Port, parameter


class LevelTank(Compliance):
    """An upright open tank: the pressure at its bottom is rho g times its level."""

    port = Port(Hydraulic)
    area: Parameter = parameter("m2", low=0.0)
    density: Parameter = parameter("kg/m3", default=1000.0, low=0.0)
    gravity: Parameter = parameter("m/s2", default=9.80665, source="standard gravity", status="published")
    start_level: Parameter = parameter("m", default=0.0, low=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.density * self.gravity / self.area * displacement

    def start(self) -> Expr:
        """The volume at the start."""
        return self.area * self.start_level


class GasAccumulator(Compliance):
    """Oil against a fixed charge of gas that is compressed with a polytropic exponent n: p = p_0 (V_0 / V)^n.

    Heat is no port of it: n says how much the gas exchanges (`GasVessel` has the wall as a port). It is empty below the
    pre-charge pressure, and the run ends there.
    """

    port = Port(Hydraulic)
    gas_volume: Parameter = parameter("m3", low=0.0, doc="without oil")
    precharge: Parameter = parameter("Pa", low=0.0, doc="absolute, without oil")
    exponent: Parameter = parameter("1", default=1.4, low=1.0001)
    ambient_pressure: Parameter = parameter(
        "Pa", default=101325.0, low=0.0, source="standard atmosphere", status="published"
    )
    start_oil: Parameter = parameter("m3", default=0.0, low=0.0)

    def compression(self, displacement: Expr, exponent: Expr) -> Expr:
        """Gas volume without oil over the present one, to a power."""
        return exp(exponent * log(self.gas_volume / (self.gas_volume - displacement)))

    def effort(self, displacement: Expr) -> Expr:
        return self.precharge * self.compression(displacement, self.exponent) - self.ambient_pressure

    def energy(self, displacement: Expr) -> Expr:
        """The integral of gauge pressure over the oil taken in."""
        n = self.exponent
        work = self.precharge * self.gas_volume / (n - 1.0) * (self.compression(displacement, n - 1.0) - 1.0)
        return work - self.ambient_pressure * displacement

    def start(self) -> Expr:
        """The oil at the start."""
        return self.start_oil

    def limits(self) -> tuple[Expr, Expr]:
        """From empty to no gas left."""
        return 0.0 * self.gas_volume, self.gas_volume
