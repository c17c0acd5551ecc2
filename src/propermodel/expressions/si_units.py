"""The units of the SI and their usual companions, read exactly and without loading a registry of all units.

The spelling is that of Modelica: a product, divided by one unit or by a product in parentheses. What is written
otherwise, or with other units, is left to the registry.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

_BASE = ("kilogram", "meter", "second", "ampere", "kelvin", "mole")
_SMALL = {"p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "c": -2, "d": -1}
_LARGE = {"h": 2, "k": 3, "M": 6, "G": 9, "T": 12}
_PREFIXES = {"": 0} | _SMALL | _LARGE  # powers of ten


@dataclass(frozen=True, slots=True)
class _Symbol:
    """A unit of one word: `above / below * pi**pi_power` times base units with these exponents, in the order above."""

    powers: tuple[int, ...]
    above: int = 1
    below: int = 1
    pi_power: int = 0


_PREFIXED = {
    "g": _Symbol((1,), below=1000),
    "m": _Symbol((0, 1)),
    "s": _Symbol((0, 0, 1)),
    "A": _Symbol((0, 0, 0, 1)),
    "K": _Symbol((0, 0, 0, 0, 1)),
    "mol": _Symbol((0, 0, 0, 0, 0, 1)),
    "rad": _Symbol(()),
    "Hz": _Symbol((0, 0, -1)),
    "N": _Symbol((1, 1, -2)),
    "Pa": _Symbol((1, -1, -2)),
    "J": _Symbol((1, 2, -2)),
    "W": _Symbol((1, 2, -3)),
    "C": _Symbol((0, 0, 1, 1)),
    "V": _Symbol((1, 2, -3, -1)),
    "Ohm": _Symbol((1, 2, -3, -2)),
    "S": _Symbol((-1, -2, 3, 2)),
    "F": _Symbol((-1, -2, 4, 2)),
    "H": _Symbol((1, 2, -2, -2)),
    "Wb": _Symbol((1, 2, -2, -1)),
    "T": _Symbol((1, 0, -2, -1)),
    "l": _Symbol((0, 3), below=1000),
    "L": _Symbol((0, 3), below=1000),
}
_WHOLE = {
    "bar": _Symbol((1, -1, -2), above=100_000),
    "mbar": _Symbol((1, -1, -2), above=100),
    "t": _Symbol((1,), above=1000),
    "min": _Symbol((0, 0, 1), above=60),
    "h": _Symbol((0, 0, 1), above=3600),
    "deg": _Symbol((), below=180, pi_power=1),
    "rev": _Symbol((), above=2, pi_power=1),
    "rpm": _Symbol((0, 0, -1), above=2, below=60, pi_power=1),
    "%": _Symbol((), below=100),
}


def _all_symbols() -> dict[str, _Symbol]:
    found: dict[str, _Symbol] = {}
    for name, unit in _PREFIXED.items():
        for prefix, ten in _PREFIXES.items():
            above, below = unit.above * 10 ** max(ten, 0), unit.below * 10 ** max(-ten, 0)
            found[prefix + name] = _Symbol(unit.powers, above, below)
    return found | _WHOLE  # `min` is the minute; there are no inches here to be taken by thousandths


LONGEST = 64  # characters of a unit
SYMBOLS = _all_symbols()

_FACTOR = r"[A-Za-zµμ%]+(?:-?[0-9]{1,2})?"
_PRODUCT = rf"{_FACTOR}(?:\.{_FACTOR})*"
_TEXT = re.compile(rf"(?P<above>1|{_PRODUCT})(?:/(?:(?P<one>{_FACTOR})|\((?P<below>{_PRODUCT})\)))?")
_EXPONENT = re.compile(r"-?[0-9]+$")


def read_si_unit(text: str) -> tuple[float, tuple[tuple[str, float], ...]] | None:
    """The factor to base units, correctly rounded, and the sorted exponents of the base units; None: not of these."""
    match = _TEXT.fullmatch(text)
    if not match or len(text) > LONGEST:
        return None
    above, below, pi_power = 1, 1, 0
    powers = dict.fromkeys(_BASE, 0)
    for product, sign in ((match["above"], 1), (match["one"] or match["below"] or "1", -1)):
        for factor in product.split(".") if product != "1" else ():
            exponent = _EXPONENT.search(factor)
            unit = SYMBOLS.get(factor[: exponent.start()] if exponent else factor)
            if unit is None:
                return None
            power = sign * (int(exponent[0]) if exponent else 1)
            up, down = (unit.above, unit.below) if power > 0 else (unit.below, unit.above)
            above, below = above * up ** abs(power), below * down ** abs(power)
            pi_power += power * unit.pi_power
            for base, base_power in zip(_BASE, unit.powers, strict=False):
                powers[base] += power * base_power
    try:
        scale = above / below * math.pi**pi_power
    except OverflowError:
        return None
    return scale, tuple(sorted((base, float(power)) for base, power in powers.items() if power))
