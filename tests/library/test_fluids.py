"""The real gas: one free energy, so pressure, entropy and energy agree exactly."""

import pytest

from propermodel.diagnostics import Path
from propermodel.expressions.core import SymbolKind, symbol
from propermodel.expressions.derivatives import derivative
from propermodel.library.hydraulics import NITROGEN
from tests.library.laws import value_of

V = symbol(SymbolKind.STATE, Path(("v",)), "m3/kg")
T = symbol(SymbolKind.STATE, Path(("T",)), "K")
STATES = [(v, t) for v in (0.003, 0.005, 0.0072, 0.02, 0.1) for t in (250.0, 300.0, 420.0)]


def at(expr, state):
    return value_of(expr, v=state[0], T=state[1])


@pytest.mark.parametrize("state", STATES)
def test_entropy_grows_with_volume_as_pressure_with_temperature(state):
    of_entropy = at(derivative(NITROGEN.entropy(V, T), V), state)
    assert of_entropy == pytest.approx(at(derivative(NITROGEN.pressure(V, T), T), state), rel=1e-12)
    assert of_entropy == pytest.approx(at(NITROGEN.pressure_slope(V, T), state), rel=1e-12)


@pytest.mark.parametrize("state", STATES)
def test_entropy_grows_with_temperature_as_heat_capacity_says(state):
    heat_capacity = at(NITROGEN.heat_capacity(V, T), state)
    assert state[1] * at(derivative(NITROGEN.entropy(V, T), T), state) == pytest.approx(heat_capacity, rel=1e-12)
    assert at(derivative(NITROGEN.inner_energy(V, T), T), state) == pytest.approx(heat_capacity, rel=1e-12)


@pytest.mark.parametrize("state", STATES)
def test_inner_energy_grows_with_volume_as_the_equation_of_state_says(state):
    expected = state[1] * at(NITROGEN.pressure_slope(V, T), state) - at(NITROGEN.pressure(V, T), state)
    # The difference of two numbers of the size of the pressure.
    size = 1e-12 * at(NITROGEN.pressure(V, T), state)
    assert at(derivative(NITROGEN.inner_energy(V, T), V), state) == pytest.approx(expected, rel=1e-10, abs=size)


@pytest.mark.parametrize(
    ("density", "pressure"), [(138.667, 12.5e6), (1.1229, 1.0e5)], ids=["pre-charge of the accumulator", "one bar"]
)
def test_pressure_of_nitrogen_at_300_kelvin(density, pressure):
    # 16.64 kg in 120 L; and the ideal gas at low pressure.
    assert at(NITROGEN.pressure(V, T), (1.0 / density, 300.0)) == pytest.approx(pressure, rel=1e-3)


def test_a_dilute_gas_is_ideal():
    assert at(NITROGEN.pressure(V, T), (100.0, 300.0)) == pytest.approx(296.8 * 300.0 / 100.0, rel=1e-5)
    assert at(NITROGEN.heat_capacity(V, T), (100.0, 300.0)) == pytest.approx(743.0, rel=1e-4)
