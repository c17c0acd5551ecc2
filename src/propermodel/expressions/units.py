"""Units as text in Modelica's spelling (`Pa.s2/m6`, `kJ/(kg.K)`); pint is loaded for what is not of the SI.

Inside, every number is in SI base units; a unit is a factor and a dimension: exponents of the SI base
quantities. A unit with an offset (degC) is refused. Angles are dimensionless.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from propermodel.diagnostics import ModelError
from propermodel.expressions.si_units import LONGEST, read_si_unit

Dimension = tuple[tuple[str, float], ...]
DIMENSIONLESS: Dimension = ()


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit: its factor to SI base units and its dimension."""

    text: str
    factor: float
    dimension: Dimension


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


# A letter sequence followed by a signed exponent: `s2` means s**2, `m-1` means m**-1.
# Numbers stand only in exponents and in fractions such as 1/s, so that reading a unit computes nothing large.
_SPELLING = re.compile(rf"[A-Za-zµμΩ%°./()\-0-9]{{1,{LONGEST}}}")
_EXPONENT = re.compile(r"([A-Za-zµΩ%]+)(-?\d+)")
_REVOLUTION = re.compile(r"\brev(?![A-Za-z])")


def _to_pint(text: str) -> str:
    spelled = _EXPONENT.sub(r"\1**(\2)", _REVOLUTION.sub("revolution", text.replace("Ohm", "ohm")))
    return spelled.replace(".", "*") or "dimensionless"


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit:
    """The unit written as `text`.

    Raises:
        ModelError: the text is not a unit, or has an offset (degC).
    """
    if text in {"", "1", "-"}:
        return Unit("", 1.0, DIMENSIONLESS)
    known = read_si_unit(text)
    if known is not None:
        return Unit(text, *known)
    registry = _registry()
    try:
        if not _SPELLING.fullmatch(text):
            raise ValueError("not in the spelling of Modelica")
        unit = registry.Unit(_to_pint(text))
        quantity = registry.Quantity(1.0, unit).to_base_units()
        if registry.Quantity(0.0, unit).to_base_units().magnitude != 0.0:
            raise ValueError("its zero is not zero; use K")
    except Exception as error:
        raise ModelError.of(
            "unit/unknown",
            f"'{text}' is not a unit{_reason(error)}",
            help="write units as N.m/rad, Pa.s2/m6, kJ/(kg.K)",
        ) from error
    powers = {str(name): float(power) for name, power in quantity.unit_items()}
    powers.pop("radian", None)
    dimension = tuple(sorted((name, power) for name, power in powers.items() if power))
    return Unit(text, float(quantity.magnitude), dimension)


def _reason(error: Exception) -> str:
    """Why a text is not a unit, where the reason is in the words of the person who wrote it."""
    return f": {error}" if type(error) is ValueError or type(error).__name__ == "UndefinedUnitError" else ""


def dimension_text(dimension: Dimension) -> str:
    """The dimension in base units, `kg.m/s2`, or `1`."""
    short = {
        "kilogram": "kg",
        "meter": "m",
        "second": "s",
        "kelvin": "K",
        "ampere": "A",
        "mole": "mol",
        "candela": "cd",
    }

    def spelled(name: str, power: float) -> str:
        return short.get(name, name) + ("" if power == 1 else f"{power:g}")

    above = [spelled(n, p) for n, p in dimension if p > 0]
    below = [spelled(n, -p) for n, p in dimension if p < 0]
    if not below:
        return ".".join(above) or "1"
    bottom = ".".join(below)
    return f"{'.'.join(above) or '1'}/{f'({bottom})' if len(below) > 1 else bottom}"


def si_text(unit: str) -> str:
    """The unit of the same quantity in SI: the unit itself where its numbers are those of SI, else in base units."""
    known = parse_unit(unit)
    return unit if known.factor == 1.0 else dimension_text(known.dimension)


def parse_quantity(text: str, unit: str) -> float:
    """The number written as `text` (`1500 kg`, or a bare number taken in `unit`), in SI.

    Raises:
        ModelError: the text is not a number with a fitting unit.
    """
    match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", text)
    if not match:
        raise ModelError.of(
            "unit/number", f"'{text}' is not a number with a unit", help=f"write for example 12.5 {unit}"
        )
    given = parse_unit(match[2]) if match[2] else parse_unit(unit)
    wanted = parse_unit(unit)
    if given.dimension != wanted.dimension:
        raise ModelError.of(
            "unit/mismatch",
            f"'{text}' has the dimension {dimension_text(given.dimension)}, not that of {unit or '1'}",
            help=f"give it in {unit or 'a bare number'}",
        )
    return float(match[1]) * given.factor
