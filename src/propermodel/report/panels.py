"""What a figure of a mission shows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Series:
    """One line of a panel: an observable, or an input of the scenario."""

    path: str
    label: str = ""
    scale: float = 1.0  # turns the value into the unit of the panel
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Panel:
    """One diagram over time; without a unit it is chosen for the reader."""

    title: str
    series: tuple[Series, ...]
    unit: str = ""
