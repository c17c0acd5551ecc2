"""The units that readers of diagrams are used to: bar, rpm, km/h."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.codegen.machine import FloatArray

# Display unit for a unit inside, its factor, and from which size on it is used.
_DISPLAY = {
    "Pa": ("bar", 1e-5, 1e4),
    "rad/s": ("rpm", 9.549296585513721, 10.0),
    "m/s": ("km/h", 3.6, 5.0),
    "N": ("kN", 1e-3, 2e3),
    "N.m": ("kN.m", 1e-3, 5e3),
    "W": ("kW", 1e-3, 2e3),
    "J": ("kJ", 1e-3, 2e3),
    "m": ("mm", 1e3, 0.0),
    "kg/s": ("g/s", 1e3, 0.0),
}
_LARGEST_IN_MM = 1.0


@dataclass(frozen=True, slots=True)
class Display:
    """A unit for the reader and the factor to it."""

    unit: str
    factor: float


def display_for(unit: str, size: float) -> Display:
    """The unit in which a variable of this size is shown: bar, rpm, km/h where those are usual."""
    if unit in _DISPLAY:
        text, factor, least = _DISPLAY[unit]
        if size >= least and not (unit == "m" and size > _LARGEST_IN_MM):
            return Display(text, factor)
    return Display(unit, 1.0)


def display_of(unit: str, values: FloatArray) -> Display:
    """The display unit for a column."""
    return display_for(unit, float(abs(values).max()) if len(values) else 0.0)
