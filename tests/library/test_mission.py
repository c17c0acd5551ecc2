"""The mission: its road is reproducible to the last digit that was published."""

import numpy as np
import pytest

from propermodel.diagnostics import ModelError
from propermodel.library.vehicle.mission import (
    GRADE,
    ROLLING_RESISTANCE,
    ROUGHNESS,
    SPEED_PROFILE,
    RoughRoad,
    mission,
    read_record,
    rough_road,
)


@pytest.fixture(scope="module")
def road() -> RoughRoad:
    return rough_road(read_record("fmtv_mixed"))


def places(start, stop):
    return start + 0.05 * np.arange(round((stop - start) / 0.05))


def test_phases(road):
    assert road.phases()[:3] == pytest.approx([2.264846, 5.941301, 0.725576], abs=5e-7)


@pytest.mark.parametrize(
    ("x", "height", "slope"),
    [
        (0.0, 2.326561e-3, -8.521679e-4),
        (10000.0, 1.668145e-3, 4.950666e-3),
        (20000.0, -4.059816e-3, -1.093325e-2),
    ],
)
def test_height_and_slope(road, x, height, slope):
    assert road.height(np.array([x]))[0] == pytest.approx(height, abs=5e-10)
    assert road.slope(np.array([x]))[0] == pytest.approx(slope, abs=5e-9)


@pytest.mark.parametrize(
    ("start", "stop", "height", "slope"),
    [
        (0.0, 4558.0, 3.93906e-3, 6.58007e-3),
        (4579.0, 17434.0, 1.96365e-3, 3.29132e-3),
        (17455.0, 22941.0, 7.86401e-3, 1.31679e-2),
    ],
    ids=["class B", "class A", "class C"],
)
def test_roughness_of_the_sections(road, start, stop, height, slope):
    x = places(start, stop)
    assert np.sqrt(np.mean(road.height(x) ** 2)) == pytest.approx(height, rel=2e-6)
    assert np.sqrt(np.mean(road.slope(x) ** 2)) == pytest.approx(slope, rel=4e-6)


def test_slope_is_the_derivative_of_height_also_where_the_class_changes(road):
    x = 4568.9 - 15.0 + 1e-3 * np.arange(30000)
    rise = np.diff(road.height(x)) / 1e-3
    # The change of amplitude begins and ends with a kink of some 4e-5 in slope.
    assert np.max(np.abs(rise - 0.5 * (road.slope(x)[1:] + road.slope(x)[:-1]))) < 5e-5


def test_classes_change_where_the_sections_do(road):
    assert road.classes == ("B", "A", "C")
    assert road.places == pytest.approx((4568.90, 17444.22))


def test_the_mission_has_everything_a_truck_asks_of_a_road():
    scenario = mission("fmtv_mixed")
    assert (scenario.start, scenario.stop) == (0.0, 2200.0)
    assert set(scenario.tables) == {SPEED_PROFILE, GRADE, ROLLING_RESISTANCE, ROUGHNESS}
    (x,) = scenario.tables[ROUGHNESS].grids
    # Tyres are from 2.05 m behind the centre of gravity to 2.75 m ahead.
    assert x[0] < -2.05
    assert x[-1] > 22941.0 + 2.75


def test_speed_grade_and_rolling_resistance_are_those_of_the_record():
    scenario = mission("fmtv_mixed")
    speed, grade, rolling = (scenario.tables[p] for p in (SPEED_PROFILE, GRADE, ROLLING_RESISTANCE))
    assert max(speed.values) == pytest.approx(21.25, abs=0.01)
    assert np.interp(0.0, grade.grids[0], grade.values) == pytest.approx(0.00443)
    assert (min(grade.values), max(grade.values)) == pytest.approx((-0.107, 0.115), abs=6e-4)
    assert np.interp([17444.0, 17444.22], rolling.grids[0], rolling.values) == pytest.approx([0.012, 0.030])


def test_another_class_for_a_section():
    scenario = mission("fmtv_mixed", roughness={"cross-country": "E"}, until=100.0)
    assert scenario.stop == 100.0
    reference = mission("fmtv_mixed").tables[ROUGHNESS]
    (x,) = reference.grids
    end = np.array(x) > 18000.0
    ratio = np.array(scenario.tables[ROUGHNESS].values)[end] / np.array(reference.values)[end]
    assert ratio == pytest.approx(np.full(end.sum(), 4.0))


def test_a_smooth_road():
    smooth = dict.fromkeys(("city", "highway", "cross-country"), "none")
    assert set(mission("fmtv_mixed", roughness=smooth).tables[ROUGHNESS].values) == {0.0}


def test_misspellings_are_named():
    with pytest.raises(ModelError, match="no mission 'fmtv_mixd'"):
        mission("fmtv_mixd")
    with pytest.raises(ModelError, match="a section is one of city, highway, cross-country"):
        mission("fmtv_mixed", roughness={"motorway": "A"})
    with pytest.raises(ModelError, match="lasts 2200 s; it cannot end at 3000 s"):
        mission("fmtv_mixed", until=3000.0)
