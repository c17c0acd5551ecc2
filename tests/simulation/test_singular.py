"""Runs whose equations lose their rank: they end with a status, or are refused, with the elements named."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel.compiler import Backend
from propermodel.diagnostics import SimulationError, parse_path
from propermodel.library.mechanics.planar import FixedPoint, FourBarLinkage, PinnedRod, PointMass
from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.library.mechanics.translation import Fixed
from tests.parts import Force, Lever, Mass
from tests.physics.systems import compiled, run, scenario


class TwoRods(pm.Component):
    """A bob on two equal rods with the same hinge."""

    bob = PointMass(mass=2.0)
    rod = PinnedRod(length=1.0)
    other = PinnedRod(length=1.0)
    hinge = Fixed()

    connections = (
        pm.connect(bob.point, rod.point, other.point),
        pm.connect(rod.excess, other.excess, hinge.flange),
    )


class Parallelogram(pm.Component):
    """Crank and rocker of one length: all bars come into one line."""

    crank = RotatingInertia(inertia=0.1)
    coupler = RotatingInertia(inertia=0.2)
    rocker = RotatingInertia(inertia=0.3)
    loop = FourBarLinkage(
        crank_length=0.2,
        coupler_length=0.5,
        rocker_length=0.2,
        base=0.5,
        start_crank=-1.0,
        start_coupler=0.0,
        start_rocker=-1.0,
    )
    base = FixedPoint()

    connections = (
        pm.connect(crank.shaft, loop.crank),
        pm.connect(coupler.shaft, loop.coupler),
        pm.connect(rocker.shaft, loop.rocker),
        pm.connect(base.point, loop.gap),
    )


class TwoMasses(pm.Component):
    """A force on two masses that a lever joins."""

    first = Mass(mass=1.0)
    second = Mass(mass=2.0)
    lever = Lever(ratio=2.0)
    force = Force(force=1.0)

    connections = (
        pm.connect(force.flange, first.flange, lever.a),
        pm.connect(lever.b, second.flange),
    )


class OneMass(pm.Component):
    """A force on a mass."""

    mass = Mass(mass=1.0)
    force = Force(force=1.0)

    connections = (pm.connect(force.flange, mass.flange),)


def ending(component: pm.Component, backend: Backend = Backend.NATIVE, **given: object) -> pm.Trajectory:
    return pm.simulate(compiled(component, backend), scenario(1.0, **given), method=pm.Method.RK4, step=1e-3)


def test_a_constraint_stated_twice_is_refused() -> None:
    with pytest.raises(SimulationError, match="its constraints depend on each other there") as caught:
        run(TwoRods(), 1.0)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "simulation/singular-mechanism"
    assert [involved.path for involved in diagnostic.involved] == ["rod.at_excess.held", "other.at_excess.held"]
    assert "stated twice" in diagnostic.help


@pytest.mark.parametrize("backend", list(Backend))
def test_bars_in_one_line_end_the_run_with_a_status(backend: Backend) -> None:
    turning = ending(Parallelogram(), backend, initial={"crank.momentum": 0.5})
    assert not turning.ending.is_complete
    assert turning.ending.time == pytest.approx(0.2, abs=2e-3)  # one radian at 5 rad/s
    assert "singular position: loop.at_gap_x.held, loop.at_gap_y.held do not hold it" in turning.ending.message
    assert turning.ending.path == parse_path("loop.at_gap_x.held")


def test_a_parameter_of_zero_is_named() -> None:
    broken = ending(OneMass(), parameters={"mass.mass": 0.0})
    assert not broken.ending.is_complete
    assert broken.ending.message.endswith("something is divided by zero, because mass.mass is 0")


def test_a_parameter_of_zero_that_leaves_no_start_is_named() -> None:
    with pytest.raises(SimulationError, match=r"what second\.momentum should store, because first\.mass is 0"):
        ending(TwoMasses(), parameters={"first.mass": 0.0})


def test_terms_that_cancel_are_named() -> None:
    # 8 kg and -2 kg at twice the velocity: no inertia is left.
    broken = ending(TwoMasses(), parameters={"first.mass": 8.0, "second.mass": -2.0})
    assert not broken.ending.is_complete
    assert "the equations of second do not determine their variables" in broken.ending.message
    assert broken.ending.message.endswith("because terms cancel")


def test_a_state_that_only_grows_is_still_advised_a_smaller_step() -> None:
    class Runaway(pm.SignalBlock):
        """Grows without bound in finite time."""

        value = pm.State("1", start=1.0)
        out = pm.Output("1")

        def outputs(self) -> pm.Updates:
            return {self.out: self.value}

        def derivatives(self) -> pm.Updates:
            return {self.value: self.value * self.value * pm.quantity(20.0, "1/s")}

    broken = ending(Runaway())
    assert broken.ending.message.endswith("no longer a finite number; try a smaller step")
