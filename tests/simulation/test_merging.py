"""Storage that is joined keeps at the start what it was declared to hold together."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from propermodel.analysis.balance import energy_balance
from propermodel.diagnostics import SimulationError
from propermodel.expressions import Expr, sqrt, time
from propermodel.library.mechanics.translation import Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    Inertia,
    Parameter,
    Port,
    Transformer,
    Translation,
    connect,
    elaborate,
    parameter,
    table,
)
from tests.parts import Capacitor, Ground, Lever, Resistor
from tests.physics.systems import Moving, run, system
from tests.reduction.test_limits import between, no_effort, no_flow


def welded(**starts: float) -> Component:
    one, two = Mass(mass=2.0, start_velocity=1.0), Mass(mass=3.0, **starts)
    return system(connect(one.flange, two.flange), one=one, two=two)


def levered(lever: Component) -> Component:
    one, two = Mass(mass=2.0, start_velocity=1.0), Mass(mass=3.0, start_velocity=-1.0)
    return system(connect(one.flange, lever.a), connect(lever.b, two.flange), one=one, lever=lever, two=two)


def test_masses_locked_together_by_a_removal_keep_their_momentum():
    reduced = run(elaborate(between(range(4))).without(no_flow("p0.port")), 0.5)
    common = 2.0 * 1.0 / 5.0
    assert reduced.at_start("left.flange.flow") == pytest.approx(common)
    assert reduced.at_start("right.flange.flow") == pytest.approx(common)


def test_a_stiff_joint_leads_to_the_same_start():
    # 1e9 N/m joins the masses within microseconds; what their damper takes is the energy of the impact.
    soft = run(between(range(4)), 2e-3, step=1e-7, parameters={"p0.stiffness": 1e9, "p1.damping": 5e4})
    rigid = run(elaborate(between(range(4))).without(no_flow("p0.port")), 2e-3)
    for side in ("left", "right"):
        assert soft.at_end(f"{side}.flange.flow") == pytest.approx(rigid.at_end(f"{side}.flange.flow"), rel=1e-4)


def test_welded_masses_start_with_their_common_momentum():
    r = run(welded(), 0.1)
    assert r.at_start("one.flange.flow") == pytest.approx(0.4)
    assert r.at_start("one.momentum") + r.at_start("two.flange.momentum") == pytest.approx(2.0)


def test_what_the_meeting_of_masses_costs_is_said():
    (note,) = run(welded(), 0.1).notes
    lost = 0.5 * 2.0 * 1.0**2 - 0.5 * 5.0 * 0.4**2
    assert f"{lost:g} J are lost" in note
    assert "one.momentum 0.8 instead of 2 N.s" in note
    assert "two.momentum 1.2 instead of 0 N.s" in note
    assert note in str(run(welded(), 0.1))


class Relativistic(Inertia):
    """Momentum m v / sqrt(1 - v^2/c^2), which has no value from the speed of light on."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", default=1.0)
    light: Parameter = parameter("m/s", default=1.0)

    def flow(self, momentum: Expr) -> Expr:
        ratio = momentum / (self.mass * self.light)
        return momentum / self.mass / sqrt(1.0 + ratio * ratio)

    def momentum(self, flow: Expr) -> Expr:
        ratio = flow / self.light
        return self.mass * flow / sqrt(1.0 - ratio * ratio)

    def energy(self, momentum: Expr) -> Expr:
        ratio = momentum / (self.mass * self.light)
        return self.mass * self.light**2.0 * (sqrt(1.0 + ratio * ratio) - 1.0)


def meeting(slow: float, fast: float):
    one, two = Mass(mass=1.0), Relativistic()
    rig = system(connect(one.flange, two.flange), one=one, two=two)
    return run(rig, 0.01, initial={"one.momentum": slow, "two.momentum": fast})


@pytest.mark.parametrize(
    ("slow", "fast"), [(0.5, 0.0), (0.5, -5.0), (0.9, 0.0), (0.9, 50.0), (0.99, 5.0), (-0.99, 50.0)]
)
def test_masses_with_a_greatest_speed_meet_below_it(slow, fast):
    r = meeting(slow, fast)
    speed = brentq(lambda v: v + v / math.sqrt(1.0 - v * v) - slow - fast, -1.0 + 1e-12, 1.0 - 1e-12, xtol=1e-14)
    assert r.at_start("one.flange.flow") == pytest.approx(speed, rel=1e-9)
    assert r.at_start("one.momentum") + r.at_start("two.flange.momentum") == pytest.approx(slow + fast, rel=1e-9)


def test_a_start_at_which_a_law_has_no_value_is_refused():
    with pytest.raises(SimulationError, match=r"no start of the states keeps what two\.momentum should store"):
        meeting(1.5, 0.0)


def test_starts_that_agree_are_kept_in_silence():
    r = run(welded(start_velocity=1.0), 0.1)
    assert r.notes == ()
    assert r.at_start("one.momentum") == 2.0


def test_the_balance_counts_from_the_merged_start():
    assert energy_balance(run(welded(), 0.1)).relative_residual < 1e-12


def test_levered_masses_keep_the_sum_of_ratio_times_momentum():
    r = run(levered(Lever(ratio=2.0)), 0.1)
    assert r.at_start("one.flange.flow") == pytest.approx((2.0 - 2.0 * 3.0) / (2.0 + 4.0 * 3.0))


class Growing(Transformer):
    """A lever whose ratio grows with time, by a table: 2 at 0 s, 4 at 1 s."""

    a = Port(Translation)
    b = Port(Translation)
    grown = table("1", ("s",), [(-1.0, 0.5, 3.0)], (0.0, 3.0, 8.0))

    def modulus(self) -> Expr:
        return self.grown(time)


def test_a_ratio_that_changes_counts_as_it_is_at_the_start():
    r = run(levered(Growing()), 1e-3, step=1e-5)
    assert r.at_start("one.flange.flow") == pytest.approx((2.0 - 2.0 * 3.0) / (2.0 + 4.0 * 3.0))
    later = run(levered(Growing()), 1.0 + 1e-3, step=1e-5, start=1.0)
    assert later.at_start("one.flange.flow") == pytest.approx((2.0 - 4.0 * 3.0) / (2.0 + 16.0 * 3.0))


def test_three_masses_on_levers_meet_at_once():
    a, b, c = (Mass(mass=m, start_velocity=v) for m, v in ((2.0, 1.0), (3.0, 0.5), (4.0, -2.0)))
    ab, bc = Lever(ratio=2.0), Lever(ratio=-0.5)
    rig = system(
        connect(a.flange, ab.a), connect(ab.b, b.flange, bc.a), connect(bc.b, c.flange), a=a, b=b, c=c, ab=ab, bc=bc
    )
    ratios, masses, speeds = np.array([1.0, 2.0, -1.0]), np.array([2.0, 3.0, 4.0]), np.array([1.0, 0.5, -2.0])
    expected = ratios @ (masses * speeds) / (ratios**2 @ masses)
    r = run(rig, 0.1)
    assert r.at_start("a.flange.flow") == pytest.approx(expected)
    assert r.at_start("c.flange.flow") == pytest.approx(-expected)
    assert len(r.notes) == 1


def parallel_capacitors(**first: float) -> Component:
    one, two, load, ground = Capacitor(capacitance=1.0), Capacitor(capacitance=3.0), Resistor(resistance=9.0), Ground()
    return system(
        connect(one.a, two.a, load.a),
        connect(one.b, two.b, load.b, ground.pin),
        one=one,
        two=two,
        load=load,
        ground=ground,
    )


def test_joined_capacitors_share_their_charge():
    both = {"one.port.effort": 8.0, "two.port.effort": 0.0}
    r = run(parallel_capacitors(), 0.1, initial=both)
    assert r.at_start("one.port.effort") == pytest.approx(2.0)
    assert r.at_start("two.port.displacement") == pytest.approx(6.0)
    (note,) = r.notes
    assert "24 J are lost" in note


def test_what_the_scenario_says_about_one_holds_for_all():
    r = run(parallel_capacitors(), 0.1, initial={"one.port.effort": 8.0})
    assert r.at_start("one.port.effort") == pytest.approx(8.0)
    assert r.at_start("two.port.effort") == pytest.approx(8.0)
    (note,) = r.notes
    assert "the scenario gives the start of what it moves with" in note


def test_springs_in_series_keep_their_length_together():
    # Without the mass between them both springs carry the same force.
    one, middle, two = Spring(stiffness=100.0, start_compression=0.03), Mass(mass=1.0), Spring(stiffness=200.0)
    wall, end = Fixed(), Mass(mass=5.0)
    rig = system(
        connect(wall.flange, one.a),
        connect(one.b, middle.flange, two.a),
        connect(two.b, end.flange),
        wall=wall,
        one=one,
        middle=middle,
        two=two,
        end=end,
    )
    r = run(elaborate(rig).without(no_effort("middle.flange")), 0.1)
    one_now, two_now = r.at_start("one.port.displacement"), r.at_start("two.port.displacement")
    assert one_now + two_now == pytest.approx(0.03)
    assert 100.0 * one_now == pytest.approx(200.0 * two_now)


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
def test_a_mass_that_a_source_moves_has_no_say():
    moving, mass = Moving(velocity=2.0), Mass(mass=3.0)
    r = run(system(connect(moving.flange, mass.flange), moving=moving, mass=mass), 0.1)
    assert r.at_start("mass.flange.flow") == pytest.approx(2.0)
    assert r.notes == ("mass.momentum starts at 6 N.s, not at 0: a source decides it",)
