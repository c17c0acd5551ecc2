"""The mixed mission of an FMTV truck: city, highway and cross-country over 2200 s, with hills and a rough road."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from propermodel.diagnostics import ModelError, Path, nearest
from propermodel.modelling import Scenario, TableValues

FloatArray = NDArray[np.float64]

SPEED_PROFILE = Path(("driver", "speed_profile"))
GRADE = Path(("chassis", "road", "grade"))
ROLLING_RESISTANCE = Path(("chassis", "road", "rolling_resistance"))
ROUGHNESS = Path(("chassis", "road", "roughness"))

# Displacement spectrum at 0.1 cycle/m, m3 (ISO 8608:2016); "none" is a smooth road.
ROUGHNESS_CLASSES: Mapping[str, float] = {
    "none": 0.0,
    "A": 16e-6,
    "B": 64e-6,
    "C": 256e-6,
    "D": 1024e-6,
    "E": 4096e-6,
}
SECTIONS = ("city", "highway", "cross-country")
CONTACT_LENGTH = 0.25  # m, over which a tyre averages the profile
SPACING = 0.05  # m, of the roughness table
MARGIN = 60.0  # m, of road before the start and beyond the end
BLEND = 10.0  # m, before and after a change of class


@dataclass(frozen=True)
class Record:
    """A mission as recorded: one row a second."""

    time: FloatArray
    speed: FloatArray
    distance: FloatArray
    grade: FloatArray
    rolling_resistance: FloatArray
    section: tuple[str, ...]
    roughness: tuple[str, ...]


@lru_cache(maxsize=4)
def read_record(name: str) -> Record:
    """The record of a mission.

    Raises:
        ModelError: there is no mission of this name.
    """
    files = {"fmtv_mixed": "mission.csv"}
    if name not in files:
        raise ModelError.of(
            "library/unknown-mission", f"there is no mission '{name}'", help=nearest(name, files) or "fmtv_mixed"
        )
    with (FilePath(__file__).parent / "data" / files[name]).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def column(key: str) -> FloatArray:
        return np.array([float(row[key]) for row in rows])

    return Record(
        time=column("time_s"),
        speed=column("speed_m_per_s"),
        distance=column("distance_m"),
        grade=column("grade"),
        rolling_resistance=column("rolling_resistance_coefficient"),
        section=tuple(row["section"] for row in rows),
        roughness=tuple(row["iso8608_class"] for row in rows),
    )


@dataclass(frozen=True)
class RoughRoad:
    """A random profile: sum of cosines with the spectrum of ISO 8608, averaged over the contact of a tyre.

    z(x) = A(x) sum sqrt(2 (n_k / n_0)^-2 dn_k) sinc(0.25 n_k) cos(2 pi n_k x + phi_k), with 400 wave numbers from 0.04
    to 2.8 cycle/m; longer waves are hills. A changes linearly from 10 m before to 10 m after a change of class.
    """

    places: tuple[float, ...]  # of changes of class, m
    classes: tuple[str, ...]  # one more than places
    seed: int = 8608

    def phases(self) -> FloatArray:
        """The random phases."""
        return np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, 400)

    def amplitude(self, x: FloatArray) -> FloatArray:
        """The root of the spectrum, blended at changes of class."""
        roots = [np.sqrt(ROUGHNESS_CLASSES[name]) for name in self.classes]
        if not self.places:
            return np.full_like(x, roots[0])
        grid = [edge for place in self.places for edge in (place - BLEND, place + BLEND)]
        values = [root for pair in pairwise(roots) for root in pair]
        return np.interp(x, grid, values)

    def amplitude_slope(self, x: FloatArray) -> FloatArray:
        """The derivative of the amplitude along the road."""
        roots = [np.sqrt(ROUGHNESS_CLASSES[name]) for name in self.classes]
        slope = np.zeros_like(x)
        for place, (before, after) in zip(self.places, pairwise(roots), strict=True):
            slope += np.where(np.abs(x - place) < BLEND, (after - before) / (2.0 * BLEND), 0.0)
        return slope

    def waves(self) -> tuple[FloatArray, FloatArray]:
        """Wave numbers, rad/m, and the height of each wave for a unit amplitude."""
        edges = np.geomspace(0.04, 2.8, 401)
        n = np.sqrt(edges[:-1] * edges[1:])
        weights = np.sqrt(2.0 * (n / 0.1) ** -2 * np.diff(edges)) * np.sinc(CONTACT_LENGTH * n)
        return 2.0 * np.pi * n, weights

    def unit_profile(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Height and slope of the profile at equidistant places for a unit amplitude."""
        numbers, weights = self.waves()
        spacing = x[1] - x[0] if len(x) > 1 else 0.0
        width = max(1, int(np.sqrt(len(x))))
        # Place (i width + j) is turned by i and then by j: two small tables and a product instead of every cosine.
        starts = np.exp(1j * (np.outer(x[::width], numbers) + self.phases()))
        steps = np.exp(1j * np.outer(numbers, np.arange(width) * spacing))
        height = (starts * weights @ steps).real.ravel()[: len(x)]
        slope = -(starts * (weights * numbers) @ steps).imag.ravel()[: len(x)]
        return height, slope

    def height(self, x: FloatArray) -> FloatArray:
        """Height z at equidistant places."""
        return self.amplitude(x) * self.unit_profile(x)[0]

    def slope(self, x: FloatArray) -> FloatArray:
        """Slope dz/dx at equidistant places."""
        height, slope = self.unit_profile(x)
        return self.amplitude(x) * slope + self.amplitude_slope(x) * height


def rough_road(record: Record, classes: Mapping[str, str] | None = None) -> RoughRoad:
    """The rough road of a record; `classes` gives a section another class, `{"cross-country": "E"}`."""
    named = classes or {}
    for section, name in named.items():
        if section not in SECTIONS or name not in ROUGHNESS_CLASSES:
            raise ModelError.of(
                "library/roughness",
                f"the roughness '{section}': '{name}' cannot be given",
                help=f"a section is one of {', '.join(SECTIONS)} and a class one of {', '.join(ROUGHNESS_CLASSES)}",
            )
    of_row = [named.get(s, c) for s, c in zip(record.section, record.roughness, strict=True)]
    changes = [i for i in range(1, len(of_row)) if record.section[i] != record.section[i - 1]]
    kept = [i for i in changes if of_row[i] != of_row[i - 1]]
    return RoughRoad(
        places=tuple(float(record.distance[i]) for i in kept),
        classes=(of_row[0], *(of_row[i] for i in kept)),
    )


@lru_cache(maxsize=8)
def roughness_table(road: RoughRoad, end: float) -> TableValues:
    """The slope of a rough road every 0.05 m, from a margin before the start to a margin beyond the end."""
    x = SPACING * np.arange(round(-MARGIN / SPACING), round((end + MARGIN) / SPACING) + 1, dtype=np.float64)
    return TableValues((tuple(x.tolist()),), tuple(road.slope(x).tolist()))


def _table(x: FloatArray, y: FloatArray) -> TableValues:
    return TableValues((tuple(x.tolist()),), tuple(y.tolist()))


def _grade_table(record: Record) -> TableValues:
    """Grade over the rows where the distance grows."""
    grows = np.concatenate([[True], np.diff(np.maximum.accumulate(record.distance)) > 0.0])
    x, y = record.distance[grows], record.grade[grows]
    return _table(np.array([x[0] - MARGIN, *x, x[-1] + MARGIN]), np.array([y[0], *y, y[-1]]))


def _rolling_table(record: Record) -> TableValues:
    """Steps of rolling resistance: that of the last row at or before a place."""
    changes = np.flatnonzero(np.diff(record.rolling_resistance)) + 1
    x, y = [-MARGIN], [float(record.rolling_resistance[0])]
    for i in changes:
        place = float(record.distance[i])
        x.extend((place - 1e-6, place))
        y.extend((y[-1], float(record.rolling_resistance[i])))
    x.append(float(record.distance[-1]) + MARGIN)
    y.append(y[-1])
    return _table(np.array(x), np.array(y))


def mission(name: str, *, roughness: Mapping[str, str] | None = None, until: float | None = None) -> Scenario:
    """A mission for `HybridTruck` and `ConventionalTruck`.

    Args:
        name: `fmtv_mixed`: city on class B, highway on class A, cross-country on class C (ISO 8608).
        roughness: Another roughness class for a section, `{"cross-country": "E"}`; `none` is smooth.
        until: An earlier end, s.

    Raises:
        ModelError: the mission, a section or a class does not exist, or the end lies outside the record.
    """
    record = read_record(name)
    stop = float(record.time[-1]) if until is None else until
    if not 0.0 < stop <= record.time[-1]:
        raise ModelError.of(
            "library/mission-end",
            f"the mission '{name}' lasts {record.time[-1]:g} s; it cannot end at {stop:g} s",
            help=f"give until= a time between 0 and {record.time[-1]:g} s",
        )
    road = rough_road(record, roughness)
    return Scenario(
        name=name,
        start=0.0,
        stop=stop,
        tables={
            SPEED_PROFILE: _table(record.time, record.speed),
            GRADE: _grade_table(record),
            ROLLING_RESISTANCE: _rolling_table(record),
            ROUGHNESS: roughness_table(road, float(record.distance[-1])),
        },
        description="city, highway and cross-country; roughness of class "
        + ", ".join(f"{c} from {p:g} m" for c, p in zip(road.classes, (0.0, *road.places), strict=True)),
    )
