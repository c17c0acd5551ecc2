"""The engine: fuel polynomial, map and injection agree with each other and with the published curves."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from propermodel.library.powertrain.engine import Combustion, InjectionController, mapped_torque, motoring_torque
from tests.library.laws import law_value, output_values

RPM = math.pi / 30.0


def injection(rpm, demand, **values):
    block = InjectionController(**values)
    return output_values(block, block.outputs(), speed=rpm * RPM, demand=demand)


def fuel_g_per_s(rpm, torque):
    return 1e3 * injection(rpm, torque)["fuel"]


@pytest.mark.parametrize(
    ("rpm", "expected"), [(1000, 0.438), (1440, 0.764), (1800, 1.107), (2200, 1.578), (2400, 1.853)]
)
def test_fuel_at_zero_torque(rpm, expected):
    assert fuel_g_per_s(rpm, 0.0) == pytest.approx(expected, abs=6e-4)


@pytest.mark.parametrize(
    ("torque", "rpm", "expected"),
    [
        *((200.0, rpm, e) for rpm, e in [(1000, 276), (1440, 267), (1800, 273), (2200, 296), (2400, 314)]),
        *((600.0, rpm, e) for rpm, e in [(1000, 235), (1440, 216), (1800, 214), (2200, 225), (2400, 237)]),
        *((1000.0, rpm, e) for rpm, e in [(1440, 214), (1800, 210), (2200, 220)]),
    ],
)
def test_specific_fuel_in_grams_per_kilowatt_hour(torque, rpm, expected):
    power = torque * rpm * RPM / 1e3
    assert 3600.0 * fuel_g_per_s(rpm, torque) / power == pytest.approx(expected, abs=0.6)


@pytest.mark.parametrize(
    ("rpm", "expected"), [(700, 65), (1000, 75), (1440, 92), (1800, 106), (2200, 124), (2400, 133)]
)
def test_motoring_torque(rpm, expected):
    assert motoring_torque(rpm) == pytest.approx(expected, abs=0.5)
    assert law_value(InjectionController().motoring_torque, speed=rpm * RPM) == pytest.approx(motoring_torque(rpm))


@pytest.mark.parametrize(
    ("rpm", "expected"), [(1000, 950), (1440, 1166), (1700, 1145), (2400, 979), (2520, 489.5), (2700, 0)]
)
def test_full_load_torque(rpm, expected):
    assert injection(rpm, 0.0)["full_load_torque"] == pytest.approx(expected, abs=0.01)


def test_rated_power():
    assert injection(2400, 0.0)["full_load_torque"] * 2400 * RPM == pytest.approx(246e3, rel=1e-3)


def test_the_published_table_is_the_polynomial():
    # engine_map.csv: torque over speed and injected mass, clipped to the full-load curve, rounded to 0.1 N m.
    with (Path(__file__).parent / "engine_map.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        rpm, mass, torque = (float(row[k]) for k in ("speed_rpm", "injected_mg_per_stroke", "brake_torque_n_m"))
        full = injection(rpm, 0.0)["full_load_torque"]
        assert min(mapped_torque(rpm, mass), full) == pytest.approx(torque, abs=0.06)


@pytest.mark.parametrize("rpm", np.linspace(720.0, 2390.0, 12))
@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.6, 0.9])
def test_the_map_gives_the_torque_that_was_asked_for(rpm, share):
    # Linear interpolation of the map costs up to 1.2 N m near zero torque, where the fuel law has a kink.
    asked = share * injection(rpm, 0.0)["full_load_torque"]
    mass = injection(rpm, asked)["injected_mass"]
    given = -law_value(Combustion().effort, speed=rpm * RPM, injected_mass=mass)
    assert given == pytest.approx(asked, abs=1.2 if share == 0.0 else 0.6)


def test_more_is_never_given_than_full_load():
    full = injection(1440, 0.0)["full_load_torque"]
    mass = injection(1440, 5000.0)["injected_mass"]
    assert mass == pytest.approx(146.0e-6, rel=1e-3)
    assert -law_value(Combustion().effort, speed=1440 * RPM, injected_mass=mass) == pytest.approx(full, abs=1.0)


def test_fuel_is_cut_in_overrun_and_the_idle_governor_is_alive():
    assert injection(1500, -1e6)["injected_mass"] == 0.0
    idle = injection(700, -1e6)["injected_mass"]
    governed = -law_value(Combustion().effort, speed=700 * RPM, injected_mass=idle)
    assert governed == pytest.approx(60.0 * (74.704 - 700 * RPM), abs=1.0)


def test_an_engine_of_twice_the_size_gives_twice_the_torque_for_twice_the_fuel():
    small, large = injection(1800, 400.0), injection(1800, 800.0, torque_scale=2.0)
    assert large["fuel"] == pytest.approx(2.0 * small["fuel"])
    assert large["full_load_torque"] == pytest.approx(2.0 * small["full_load_torque"])
    torque = law_value(Combustion(torque_scale=2.0).effort, speed=1800 * RPM, injected_mass=large["injected_mass"])
    one = law_value(Combustion().effort, speed=1800 * RPM, injected_mass=small["injected_mass"])
    assert torque == pytest.approx(2.0 * one)
