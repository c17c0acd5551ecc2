"""Units in Modelica's spelling against known factors and dimensions."""

from __future__ import annotations

import math

import pytest

from propermodel.diagnostics import ModelError
from propermodel.expressions import units
from propermodel.expressions.si_units import SYMBOLS, read_si_unit
from propermodel.expressions.units import dimension_text, parse_quantity, parse_unit


@pytest.mark.parametrize(
    ("text", "factor", "dimension"),
    [
        ("", 1.0, "1"),
        ("1", 1.0, "1"),
        ("rad", 1.0, "1"),
        ("deg", math.pi / 180, "1"),
        ("%", 0.01, "1"),
        ("N", 1.0, "kg.m/s2"),
        ("N.m/rad", 1.0, "kg.m2/s2"),
        ("Pa.s2/m6", 1.0, "kg/m7"),
        ("kJ/(kg.K)", 1000.0, "m2/(K.s2)"),
        ("m3/s", 1.0, "m3/s"),
        ("l/min", 1e-3 / 60, "m3/s"),
        ("bar", 1e5, "kg/(m.s2)"),
        ("rpm", 2 * math.pi / 60, "1/s"),
        ("rev/min", 2 * math.pi / 60, "1/s"),
        ("km/h", 1 / 3.6, "m/s"),
        ("g/(kW.h)", 1e-3 / 3.6e6, "s2/m2"),
        ("Ohm", 1.0, "kg.m2/(A2.s3)"),
        ("kOhm", 1000.0, "kg.m2/(A2.s3)"),
        ("m-1", 1.0, "1/m"),
        ("1/s", 1.0, "1/s"),
        ("K", 1.0, "K"),
    ],
)
def test_factor_and_dimension(text, factor, dimension):
    unit = parse_unit(text)
    assert unit.factor == pytest.approx(factor, rel=1e-12)
    assert dimension_text(unit.dimension) == dimension


COMPOSED = ("kJ/(kg.K)", "g/(kW.h)", "cm3/rev", "Pa.s2/m6", "m-1", "1/s", "mm2.MPa-3/(deg.us2)", "l/min", "m30")


@pytest.mark.parametrize("text", [*SYMBOLS, *COMPOSED])
def test_units_read_without_pint_are_those_of_pint(text):
    factor, dimension = read_si_unit(text)
    pint_quantity = units._registry().Quantity(1.0, units._to_pint(text)).to_base_units()
    assert factor == pytest.approx(pint_quantity.magnitude, rel=1e-14)
    powers = {name: power for name, power in pint_quantity.unit_items() if name != "radian"}
    assert dict(dimension) == powers


@pytest.mark.parametrize(("text", "factor"), [("cm3", 1e-6), ("mm2", 1e-6), ("l/min", 1 / 6e4), ("kJ/(kg.K)", 1e3)])
def test_factors_are_rounded_once(text, factor):
    assert parse_unit(text).factor == factor


@pytest.mark.parametrize("text", ["psi", "ft.lbf", "mile/h", "(m/s)/K", "N.m/rad/s", "m/(s)2"])
def test_other_units_are_left_to_pint(text):
    assert read_si_unit(text) is None


def test_a_unit_of_pint_is_read():
    assert parse_unit("ft.lbf").factor == pytest.approx(1.3558179483314004, rel=1e-12)


@pytest.mark.parametrize("text", ["foo", "N m", "N*m", "m^2", "9**9**9", "((m", "m;import os", "degC", "m" * 80])
def test_what_is_not_a_unit_is_said_to_be_none(text):
    with pytest.raises(ModelError) as caught:
        parse_unit(text)
    (fault,) = caught.value.diagnostics
    assert fault.code == "unit/unknown"
    assert fault.message.startswith(f"'{text}' is not a unit")
    assert fault.help == "write units as N.m/rad, Pa.s2/m6, kJ/(kg.K)"


def test_offset_units_are_refused():
    with pytest.raises(ModelError, match="its zero is not zero; use K"):
        parse_unit("degC")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1500 kg", "kg", 1500.0),
        ("1.5e3kg", "kg", 1500.0),
        ("20 kN/m", "N/m", 20000.0),
        ("-3", "kN", -3000.0),
        (".5 bar", "Pa", 50000.0),
        ("90 deg", "rad", math.pi / 2),
    ],
)
def test_quantity(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value)


def test_quantity_of_another_dimension():
    with pytest.raises(ModelError) as caught:
        parse_quantity("3 m", "kg")
    assert str(caught.value) == (
        "error[unit/mismatch]: '3 m' has the dimension m, not that of kg\n  help: give it in kg"
    )


def test_quantity_that_is_no_number():
    with pytest.raises(ModelError) as caught:
        parse_quantity("heavy", "kg")
    assert str(caught.value) == (
        "error[unit/number]: 'heavy' is not a number with a unit\n  help: write for example 12.5 kg"
    )
