"""Starts on kinematic constraints: what changes, what stays, and what is said about it."""

from __future__ import annotations

import math

import pytest

import propermodel as pm
from propermodel.diagnostics import SimulationError
from tests.physics.mechanisms import CartesianPendulum, FourBar
from tests.physics.systems import run


def test_scenario_keeps_its_angle_and_the_others_close_the_loop() -> None:
    start = run(FourBar(), 1e-3, initial={"loop.displacement.crank": 1.2})
    at = {name: start.at_start(f"loop.displacement.{name}") for name in ("crank", "coupler", "rocker")}
    assert at["crank"] == 1.2
    across = 0.2 * math.sin(1.2) + 0.5 * math.sin(at["coupler"]) - 0.4 * math.sin(at["rocker"])
    along = 0.2 * math.cos(1.2) + 0.5 * math.cos(at["coupler"]) - 0.4 * math.cos(at["rocker"]) - 0.5
    assert abs(across) < 1e-12
    assert abs(along) < 1e-12
    (note,) = start.notes
    assert note.startswith("the kinematic loops closed by loop.at_gap_x.held, loop.at_gap_y.held were open: ")
    assert f"loop.displacement.rocker {at['rocker']:.6g} instead of 1 rad" in note
    assert "crank" not in note


def test_positions_that_contradict_each_other_all_give_way() -> None:
    start = run(CartesianPendulum(), 1e-3, initial={"rod.displacement.point_x": 3.0, "rod.displacement.point_y": 4.0})
    # The nearest point at the distance of the rod.
    assert start.at_start("rod.displacement.point_x") == pytest.approx(0.6)
    assert start.at_start("rod.displacement.point_y") == pytest.approx(0.8)
    assert "rod.displacement.point_x 0.6 instead of 3 m, rod.displacement.point_y 0.8 instead of 4 m" in start.notes[0]


def test_momentum_along_the_rod_is_lost_as_in_an_impact() -> None:
    start = run(CartesianPendulum(), 1e-3, initial={"bob.along.momentum": 2.0, "bob.upward.momentum": 6.0})
    assert start.at_start("bob.along.momentum") == pytest.approx(0.0, abs=1e-12)
    assert start.at_start("bob.upward.momentum") == pytest.approx(6.0)
    (note,) = start.notes
    assert "bob.along.momentum 0 instead of 2 N.s" in note
    assert note.endswith("1 J are lost")  # p^2 / 2 m with 2 N.s and 2 kg


def test_momenta_follow_the_one_that_the_scenario_gives() -> None:
    start = run(FourBar(), 1e-3, initial={"loop.displacement.crank": 1.2, "crank.momentum": 0.3})
    assert start.at_start("crank.shaft.flow") == 3.0
    p, q, r = (start.at_start(f"loop.displacement.{name}") for name in ("crank", "coupler", "rocker"))
    # The instantaneous ratio of a four-bar linkage: rocker to crank.
    ratio = 0.2 * math.sin(p - q) / (0.4 * math.sin(r - q))
    assert start.at_start("rocker.shaft.flow") == pytest.approx(3.0 * ratio)
    assert "follow from what the scenario gives" in start.notes[1]
    assert "J are added" in start.notes[1]


def test_a_start_on_the_constraint_changes_nothing() -> None:
    start = run(CartesianPendulum(), 1e-3, initial={"bob.upward.momentum": 6.0})
    assert start.notes == ()


def test_a_loop_that_cannot_close_is_refused() -> None:
    with pytest.raises(SimulationError, match="no displacements near the given ones close") as caught:
        run(FourBar(), 1e-3, parameters={"loop.base": 3.0})
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "simulation/open-loop"
    assert [involved.path for involved in diagnostic.involved] == ["loop.at_gap_x.held", "loop.at_gap_y.held"]
    assert "check the lengths" in diagnostic.help


def test_energy_of_a_run_begins_after_the_projection() -> None:
    swing = run(CartesianPendulum(), 1.0, initial={"bob.along.momentum": 2.0, "bob.upward.momentum": 6.0})
    assert pm.energy_balance(swing).relative_residual < 1e-8
