"""Two trucks: one in a world frame, where hills come through the tyres, and one with a short emergency stop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.datum import measure_about
from propermodel.compiler import Method, compile_model
from propermodel.diagnostics import StructureError, parse_path
from propermodel.library.vehicle.mission import GRADE, SPEED_PROFILE, mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.library.vehicle.world_frame import HybridTruckInWorldFrame
from propermodel.modelling import Scenario, ZeroEffort, ZeroFlow, elaborate
from propermodel.modelling.model import TableValues
from propermodel.simulation.simulate import simulate
from tests.reduction.failure_modes.plain import plain_mora, rows_of

FUEL = "engine.fuel_meter.mass"
AXLES = ("front_axle", "rear_front_axle", "rear_rear_axle")


def table(*points: tuple[float, float]) -> TableValues:
    places, values = zip(*points, strict=True)
    return TableValues((places,), values)


def drive(model, scenario: Scenario):
    run = simulate(model, scenario, method=Method.SEMI_IMPLICIT, step=2e-4, record_every=0.05)
    assert run.ending.is_complete
    return run


# -- hills through the tyres -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hill():
    start = mission("fmtv_mixed", until=20.0)
    return replace(start, tables={**start.tables, GRADE: table((-1e3, 0.0), (15.0, 0.0), (30.0, 0.06), (1e6, 0.06))})


@pytest.fixture(scope="module")
def truck():
    return compile_model(elaborate(HybridTruckInWorldFrame()))


@pytest.fixture(scope="module")
def uphill(truck, hill):
    return drive(truck, hill)


@pytest.fixture(scope="module")
def reference():
    return compile_model(elaborate(HybridTruck()))


def test_springs_that_carry_the_truck_rank_as_where_weight_and_preload_are_left_out(truck, reference, hill):
    level = replace(hill, tables={**hill.tables, GRADE: table((-1e3, 0.0), (1e6, 0.0))})
    models = (reference, truck, measure_about(truck, level, of=["chassis"]))
    expected, loaded, found = (rank_activity(drive(model, level)) for model in models)
    springs = [parse_path(f"chassis.{axle}.{spring}") for axle in AXLES for spring in ("spring", "tyre.spring")]
    order = {row.path: place for place, row in enumerate(expected.rows)}
    for place, row in enumerate(found.rows):
        assert row.index == pytest.approx(expected.row(row.path).index, rel=0.1)
        assert abs(place - order[row.path]) <= 3  # some are near ties
    for spring in springs:
        assert loaded.row(spring).index > 10.0 * expected.row(spring).index


def test_both_frames_tell_the_same_of_a_hill(uphill, reference, hill):
    along_path = drive(reference, hill)
    assert uphill.at_end(FUEL) == pytest.approx(along_path.at_end(FUEL), rel=0.01)
    assert uphill.at_end("chassis.speed") == pytest.approx(along_path.at_end("chassis.speed"), rel=0.02)


def test_vertical_elements_rank_low_but_hold_the_slope(truck, uphill, hill):
    ranking = rank_activity(uphill)
    held = ["chassis.body.vertical_mass", *(f"chassis.{axle}.vertical_mass" for axle in AXLES)]
    assert sum(ranking.row(parse_path(row)).index for row in held) < 0.002
    assert set(held) <= rows_of(plain_mora(uphill))
    # Without vertical motion, as the study left it, the truck stands before its hill.
    lost = drive(compile_model(truck.model.without([ZeroFlow(parse_path("chassis.body.vertical_mass.flange"))])), hill)
    assert lost.at_end(FUEL) > 1.3 * uphill.at_end(FUEL)
    # Massless it still leads the slope to the engine.
    massless = [ZeroEffort(parse_path(f"chassis.{axle}.vertical_mass.flange")) for axle in AXLES]
    kept = drive(compile_model(truck.model.without(massless)), hill)
    assert kept.at_end(FUEL) == pytest.approx(uphill.at_end(FUEL), rel=0.005)
    assert np.allclose(kept["chassis.speed"], uphill["chassis.speed"], atol=0.05)


def test_three_rigid_axles_on_one_body_are_refused_by_name(truck):
    rigid = [ZeroFlow(parse_path(f"chassis.{a}.{part}.port")) for a in AXLES for part in ("spring", "tyre.spring")]
    with pytest.raises(StructureError) as caught:
        compile_model(truck.model.without(rigid))
    assert "chassis." in str(caught.value)


def test_rigid_tyres_on_soft_springs_are_not(truck, uphill, hill):
    rigid = [ZeroFlow(parse_path(f"chassis.{axle}.tyre.spring.port")) for axle in AXLES]
    kept = drive(compile_model(truck.model.without(rigid)), hill)
    assert kept.at_end(FUEL) == pytest.approx(uphill.at_end(FUEL), rel=0.005)


# -- a short stop in a long mission ------------------------------------------------------------------------------------


def test_the_brakes_of_a_short_stop_are_kept_by_its_window():
    seconds = np.arange(0.0, 121.0)
    wanted = np.interp(seconds, (2.0, 25.0, 50.0, 74.0, 78.0, 79.0), (0.0, 12.0, 12.0, 4.0, 4.0, 0.0))
    speeds = TableValues((tuple(seconds.tolist()),), tuple(wanted.tolist()))
    drive_and_stop = replace(mission("fmtv_mixed", until=82.0), name="stop")
    scenario = replace(drive_and_stop, tables={**drive_and_stop.tables, SPEED_PROFILE: speeds})
    model = compile_model(elaborate(HybridTruck()))
    full = drive(model, scenario)
    brakes = {f"chassis.{axle}.brake" for axle in AXLES}
    whole, stop, cruise = (rank_activity(full, window=window) for window in (None, (77.0, 82.0), (26.0, 49.0)))
    kept = [{str(row.path) for row in ranking.kept_by(0.85)} for ranking in (whole, stop, cruise)]
    assert not brakes & kept[0]  # diluted: 3 % of the mission's activity
    assert brakes <= kept[1]  # a third of the stop's: the union over windows keeps them
    assert not brakes & kept[2]
    lost = [removal for removal in plain_mora(full, 0.85) if str(removal.bond.parent) in linings_of(brakes)]
    rolling = drive(compile_model(model.model.without(lost)), scenario)
    place = "chassis.odometer.position"
    assert np.max(rolling["chassis.speed"] - full["chassis.speed"]) > 1.5
    assert rolling.at_end(place) > full.at_end(place) + 3.0  # it stops metres later


def linings_of(brakes: set[str]) -> set[str]:
    """What the rows of brakes consist of."""
    return {f"{brake}.{part}" for brake in brakes for part in ("lining", "viscous")}
