"""Dimensions of expressions, and what cannot have one."""

from __future__ import annotations

import pytest

from propermodel.diagnostics import Path
from propermodel.expressions import absolute, atan2, exp, floor, minimum, sign, sin, sqrt, where
from propermodel.expressions.core import SymbolKind, constant, lookup, symbol
from propermodel.expressions.dimensions import DimensionMismatch, dimension_of
from propermodel.expressions.units import dimension_text


def named(name: str, unit: str):
    return symbol(SymbolKind.PARAMETER, Path((name,)), unit)


FORCE, MASS, SPEED, LENGTH, ANGLE = (
    named(name, unit)
    for name, unit in (("force", "N"), ("mass", "kg"), ("speed", "m/s"), ("length", "m"), ("angle", "rad"))
)


@pytest.mark.parametrize(
    ("expr", "dimension"),
    [
        (FORCE * LENGTH, "kg.m2/s2"),
        (FORCE / MASS, "m/s2"),
        (MASS * SPEED**2 / LENGTH + FORCE, "kg.m/s2"),
        (sqrt(FORCE * LENGTH / MASS), "m/s"),
        (sin(ANGLE), "1"),
        (LENGTH * ANGLE, "m"),
        (absolute(SPEED), "m/s"),
        (sign(SPEED), "1"),
        (atan2(LENGTH, LENGTH * 2.0), "1"),
        (where(SPEED > 0.0, FORCE, 0.0), "kg.m/s2"),
        (minimum(FORCE, constant(3.0, "N")), "kg.m/s2"),
        (FORCE + 0.0 * LENGTH, "kg.m/s2"),
        (exp(SPEED / constant(2.0, "m/s")), "1"),
        (FORCE**0.5 * FORCE**0.5, "kg.m/s2"),
    ],
)
def test_dimension(expr, dimension):
    assert dimension_text(dimension_of(expr) or ()) == dimension


def test_zero_fits_any_dimension():
    assert dimension_of(constant(0.0)) is None
    assert dimension_of(constant(0.0, "m")) is None


@pytest.mark.parametrize(
    ("expr", "problem"),
    [
        (FORCE + LENGTH, "'force + length' combines kg.m/s2 and m"),
        (FORCE + 1.0, "'force + 1' combines kg.m/s2 and 1"),
        (sin(LENGTH), "the argument of 'sin(length)' is not dimensionless but m"),
        (exp(SPEED), "the argument of 'exp(speed)' is not dimensionless but m/s"),
        (atan2(LENGTH, SPEED), "'atan2(length, speed)' combines m and m/s"),
        (minimum(FORCE, LENGTH), "'min(force, length)' combines kg.m/s2 and m"),
        (where(FORCE > LENGTH, 1.0, 2.0), "'length < force' combines m and kg.m/s2"),
        (where(FORCE > 0.0, FORCE, LENGTH), "'where(0 < force, force, length)' combines kg.m/s2 and m"),
        (FORCE * (LENGTH - SPEED), "'length - speed' combines m and m/s"),
    ],
)
def test_mismatch_is_named(expr, problem):
    with pytest.raises(DimensionMismatch) as caught:
        dimension_of(expr)
    assert str(caught.value) == problem


def test_table_has_the_dimension_of_its_values():
    table = symbol(SymbolKind.TABLE, Path(("map",)), "N.m")
    assert dimension_text(dimension_of(lookup(table, SPEED)) or ()) == "kg.m2/s2"


def test_floor_keeps_the_dimension():
    assert dimension_text(dimension_of(floor(LENGTH)) or ()) == "m"


def test_other_units_for_leaves():
    assert dimension_text(dimension_of(FORCE * LENGTH, {LENGTH: "s"}) or ()) == "kg.m/s"
