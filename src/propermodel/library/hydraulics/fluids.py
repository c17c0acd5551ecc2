"""Real gases, from the free energy whose derivatives pressure and entropy are."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.expressions import Expr, exp, log
from propermodel.modelling import quantity


@dataclass(frozen=True, kw_only=True)
class BenedictWebbRubin:
    """The equation of state of Benedict, Webb and Rubin, per unit of mass (v specific volume, T temperature).

    Pressure and heat capacity as in Cengel and Boles, Thermodynamics. They follow from one free energy f(v, T), by
    p = -df/dv and s = -df/dT, so that energy, entropy and pressure agree with each other exactly:

        f_r = (B0 R T - A0 - C0/T^2) / v + (b R T - a) / (2 v^2) + a alpha / (5 v^5) + c e(v) / T^2
        e(v) = (1 - (1 + gamma/(2 v^2)) exp(-gamma/v^2)) / gamma

    beside the ideal gas of heat capacity cv0. Energy and entropy count from the ideal gas at `T0` and `v0`.
    """

    R: Expr
    A0: Expr
    B0: Expr
    C0: Expr
    a: Expr
    b: Expr
    c: Expr
    alpha: Expr
    gamma: Expr
    cv0: Expr
    T0: Expr
    v0: Expr

    def pressure(self, v: Expr, T: Expr) -> Expr:
        """Absolute pressure."""
        n = 1.0 / v
        n2 = n * n
        slope = self.B0 * self.R * T - self.A0 - self.C0 / (T * T)
        cubic = (self.b * self.R * T - self.a) * n2 * n + self.a * self.alpha * n2 * n2 * n2
        wave = self.c * n2 * n / (T * T) * (1.0 + self.gamma * n2) * exp(-self.gamma * n2)
        return self.R * T * n + slope * n2 + cubic + wave

    def pressure_slope(self, v: Expr, T: Expr) -> Expr:
        """The derivative of pressure with respect to temperature at constant volume."""
        n = 1.0 / v
        n2 = n * n
        square = (self.B0 * self.R + 2.0 * self.C0 / (T * T * T)) * n2
        wave = 2.0 * self.c * n2 * n / (T * T * T) * (1.0 + self.gamma * n2) * exp(-self.gamma * n2)
        return self.R * n + square + self.b * self.R * n2 * n - wave

    def heat_capacity(self, v: Expr, T: Expr) -> Expr:
        """Specific heat capacity at constant volume."""
        n2 = 1.0 / (v * v)
        T3 = T * T * T
        wave = 3.0 * self.c / T3 * (2.0 / self.gamma + n2) * exp(-self.gamma * n2)
        return self.cv0 + 6.0 / T3 * (self.C0 / v - self.c / self.gamma) + wave

    def exponential_part(self, v: Expr) -> Expr:
        """The function e(v) of the free energy."""
        y = self.gamma / (v * v)
        return (1.0 - (1.0 + 0.5 * y) * exp(-y)) / self.gamma

    def residual_entropy(self, v: Expr, T: Expr) -> Expr:
        """Entropy above that of the ideal gas."""
        linear = (self.B0 * self.R + 2.0 * self.C0 / (T * T * T)) / v
        return 2.0 * self.c / (T * T * T) * self.exponential_part(v) - linear - self.b * self.R / (2.0 * v * v)

    def entropy(self, v: Expr, T: Expr) -> Expr:
        """Specific entropy."""
        return self.cv0 * log(T / self.T0) + self.R * log(v / self.v0) + self.residual_entropy(v, T)

    def residual_free_energy(self, v: Expr, T: Expr) -> Expr:
        """Free energy above that of the ideal gas."""
        n = 1.0 / v
        n2 = n * n
        linear = (self.B0 * self.R * T - self.A0 - self.C0 / (T * T)) * n
        square = (self.b * self.R * T - self.a) * n2 / 2.0
        quintic = self.a * self.alpha * n2 * n2 * n / 5.0
        return linear + square + quintic + self.c / (T * T) * self.exponential_part(v)

    def inner_energy(self, v: Expr, T: Expr) -> Expr:
        """Specific inner energy."""
        residual = self.residual_free_energy(v, T) + T * self.residual_entropy(v, T)
        return self.cv0 * (T - self.T0) + residual


NITROGEN = BenedictWebbRubin(
    # Cengel and Boles, Thermodynamics, table of BWR constants (Cooper and Goldfrank 1967), at 28.0134 kg/kmol.
    R=quantity(296.80, "J/(kg.K)"),
    A0=quantity(136.005, "Pa.m6/kg2"),
    B0=quantity(1.454304e-3, "m3/kg"),
    C0=quantity(1.040331e6, "Pa.m6.K2/kg2"),
    a=quantity(0.1155410, "Pa.m9/kg3"),
    b=quantity(2.966548e-6, "m6/kg2"),
    c=quantity(3356.603, "Pa.m9.K2/kg3"),
    alpha=quantity(5.786149e-9, "m9/kg3"),
    gamma=quantity(6.753738e-6, "m6/kg2"),
    cv0=quantity(743.0, "J/(kg.K)"),
    T0=quantity(300.0, "K"),
    v0=quantity(0.88, "m3/kg"),  # about one bar; any value serves, only differences of entropy count
)
