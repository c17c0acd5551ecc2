"""What an index depends on besides physics: frame, coordinates, datum, pseudo-bonds and detail (modes 9 to 13)."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.expressions import Expr, sin, time
from propermodel.library.mechanics.planar.components import EulerGyrator
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, SpringDamper
from propermodel.library.pseudo_thermal import HeatStore, ThermalConductor
from propermodel.library.thermal import HeatCapacity, WallConductance
from propermodel.modelling import (
    Component,
    FlowSource,
    Parameter,
    Port,
    Translation,
    connect,
    elaborate,
    parameter,
    quantity,
)
from propermodel.reduction.prediction import predict_errors
from propermodel.reduction.search import find_proper_model
from propermodel.simulation.trajectory import Trajectory
from tests.parts import Line, Pipe, Tank
from tests.physics.systems import Shaking, run, scenario, system
from tests.reduction.failure_modes.plain import error_without, plain_mora, rows_of


def predicted(trajectory: Trajectory, output: str) -> dict[str, float]:
    """The least predicted error of every row."""
    rows = predict_errors(trajectory, [output]).rows()
    return {str(row.row): row.best.worst for row in rows if row.best is not None}


# -- 9: the frame --------------------------------------------------------------------------------------------------


class MovingShaker(FlowSource):
    """Shakes about a constant velocity."""

    flange = Port(Translation)
    mean: Parameter = parameter("m/s")
    swing: Parameter = parameter("m/s", default=0.3)
    frequency: Parameter = parameter("Hz", default=2.0)

    def flow(self) -> Expr:
        return self.mean + self.swing * sin(2.0 * math.pi * self.frequency * time)


def carried(mean: float) -> Component:
    """The same shaken masses, seen from the ground or from a frame that moves along."""
    road, wheel = MovingShaker(mean=mean), Mass(mass=80.0, start_velocity=mean)
    body = Mass(mass=300.0, start_velocity=mean)
    tyre, suspension = SpringDamper(stiffness=2.4e4, damping=150.0), SpringDamper(stiffness=2e4, damping=600.0)
    return system(
        connect(road.flange, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange),
        road=road,
        tyre=tyre,
        wheel=wheel,
        suspension=suspension,
        body=body,
    )


STRUT = "suspension.spring.port.effort"


def test_a_frame_changes_activity_but_no_predicted_error():
    at_rest = run(elaborate(carried(0.0)), 3.0, step=5e-4, every=1.5e-3)
    moving = run(elaborate(carried(200.0)), 3.0, step=5e-4, every=1.5e-3)
    assert error_without(at_rest, plain_mora(at_rest, 0.9), STRUT) < 0.1
    plain = plain_mora(moving, 0.9)
    assert rows_of(plain) >= {"suspension.spring", "suspension.damper"}  # the masses seem to do all the work
    assert error_without(moving, plain, STRUT) > 0.2
    here, there = predicted(at_rest, STRUT), predicted(moving, STRUT)
    for row in ("tyre.spring", "tyre.damper", "suspension.damper", "suspension.spring"):
        assert there[row] == pytest.approx(here[row], rel=1e-3)


def test_between_bodies_activity_is_the_same_in_every_frame():
    rankings = [rank_activity(run(elaborate(carried(v)), 3.0, step=5e-4, every=1.5e-3)) for v in (0.0, 200.0)]
    for row in ("tyre.spring", "tyre.damper", "suspension.damper"):
        first, second = (ranking.row(parse_path(row)).activity for ranking in rankings)
        assert second == pytest.approx(first, rel=1e-6)


# -- 10: coordinates -----------------------------------------------------------------------------------------------


class FreeBody(Component):
    """A body in axes that turn with it at a constant rate; it flies straight on."""

    forward, upward, turning = Mass(mass=10.0, start_velocity=3.0), Mass(mass=10.0), EulerGyrator(mass=10.0)
    connections = (
        connect(forward.flange, turning.a),
        connect(turning.b, upward.flange),
        connect(quantity(5.0, "rad/s"), turning.pitch_rate),
    )


class WholeBody(FreeBody):
    """The same body as one energy element."""

    energy_group = True


def test_a_body_that_flies_straight_on_is_active_in_axes_that_turn():
    turn = 2.0 * math.pi / 5.0
    ranking = rank_activity(run(elaborate(FreeBody()), turn, step=turn / 4000, every=turn / 100))
    for axis in ("forward", "upward"):
        # 2 m v^2 per axis and turn, and nothing in axes that stay.
        assert ranking.row(parse_path(axis)).activity == pytest.approx(2.0 * 10.0 * 3.0**2, rel=1e-5)
    assert not any("turning" in str(row.path) for row in ranking.rows)  # it passes power on, and is no element


def test_declared_as_one_element_it_does_nothing_and_nothing_is_ranked():
    turn = 2.0 * math.pi / 5.0
    r = run(elaborate(system(body=WholeBody())), turn, step=turn / 4000, every=turn / 100)
    assert r.activity("body") == pytest.approx(0.0, abs=1e-6)


# -- 11: the datum of an effort ------------------------------------------------------------------------------------


def vessels() -> Component:
    """Two vessels that exchange oil through a line with friction."""
    first, second, line, pipe = Tank(capacity=1e-9), Tank(capacity=1e-9), Line(inertance=1e6), Pipe(loss=1e7)
    return system(
        connect(first.port, line.a),
        connect(line.b, pipe.a),
        connect(pipe.b, second.port),
        first=first,
        second=second,
        line=line,
        pipe=pipe,
    )


def test_a_datum_changes_activity_but_no_predicted_error():
    model = elaborate(vessels())
    runs = [
        run(
            model,
            1.0,
            step=2e-4,
            every=5e-4,
            initial={"first.port.effort": datum + 1e5, "second.port.effort": datum - 1e5},
        )
        for datum in (0.0, 2e7)
    ]
    gauge, absolute = runs
    output = "line.port.flow"
    assert "pipe" not in rows_of(plain_mora(gauge))
    plain = plain_mora(absolute)
    assert "pipe" in rows_of(plain)
    only_pipe = [removal for removal in plain if removal.bond == parse_path("pipe.port")]
    assert error_without(absolute, only_pipe, output) > 0.1
    assert predicted(absolute, output)["pipe"] == pytest.approx(predicted(gauge, output)["pipe"], rel=1e-3)
    assert any(text.startswith("hydraulic: ") for text in rank_activity(absolute).datums)


# -- 12: pseudo-bonds ----------------------------------------------------------------------------------------------


def warm_and_moving(*, true: bool) -> Component:
    shaker, mass, spring = Shaking(velocity=1.0, frequency=1.0), Mass(mass=1.0), Spring(stiffness=100.0)
    mechanics = {"shaker": shaker, "mass": mass, "spring": spring}
    joints = (connect(shaker.flange, spring.a), connect(spring.b, mass.flange))
    if true:
        store, wall = HeatCapacity(capacity=100.0, start_temperature=350.0), WallConductance(conductance=5.0)
        return system(*joints, connect(store.port, wall.port), **mechanics, store=store, wall=wall)
    hot, cold = HeatStore(capacity=100.0, start_temperature=350.0), HeatStore(capacity=100.0)
    wall = ThermalConductor(conductance=5.0)
    thermal = (connect(hot.port, wall.a), connect(wall.b, cold.port))
    return system(*joints, *thermal, **mechanics, hot=hot, cold=cold, wall=wall)


def test_pseudo_bonds_are_not_ranked_with_true_ones():
    r = run(compile_quietly(elaborate(warm_and_moving(true=False))), 2.0, step=1e-3)
    # Temperature times heat flow has no meaning, and is larger than all power.
    assert r.activity("hot.port") > 100.0 * r.activity("mass.flange")
    with pytest.raises(ReductionError, match="true and pseudo bonds cannot be ranked together"):
        rank_activity(r)
    assert {str(row.path) for row in rank_activity(r, among="true").rows} == {"mass", "spring"}


def test_heat_as_a_true_bond_is_ranked_with_the_rest():
    r = run(compile_quietly(elaborate(warm_and_moving(true=True))), 2.0, step=1e-3)
    assert {str(row.path) for row in rank_activity(r).rows} == {"mass", "spring", "store", "wall"}


# -- 13: how finely a thing is modelled ----------------------------------------------------------------------------


def rig(pieces: int) -> Component:
    """A mass on a stiff rod, modelled as one spring or as many in series, beside a busy soft spring."""
    shaker, mass, soft, damper, ground = (
        Shaking(velocity=1.0, frequency=3.0),
        Mass(mass=10.0),
        Spring(stiffness=5e3),
        Damper(damping=60.0),
        Fixed(),
    )
    rods = [Spring(stiffness=6e4 * pieces) for _ in range(pieces)]
    chain = [connect(shaker.flange, rods[0].a)]
    chain += [connect(one.b, other.a) for one, other in pairwise(rods)]
    chain += [connect(rods[-1].b, mass.flange, soft.a, damper.a), connect(soft.b, damper.b, ground.flange)]
    parts = {f"rod{number}": rod for number, rod in enumerate(rods)}
    return system(*chain, shaker=shaker, mass=mass, soft=soft, damper=damper, ground=ground, **parts)


def test_a_rod_in_many_pieces_is_not_lost_piece_by_piece():
    output = "rod0.port.effort"
    whole = run(elaborate(rig(1)), 1.0, step=2e-4, every=1e-3)
    fine = run(elaborate(rig(6)), 1.0, step=2e-4, every=1e-3)
    share = rank_activity(whole).row(parse_path("rod0")).index
    pieces = [row.index for row in rank_activity(fine).rows if str(row.path).startswith("rod")]
    assert sum(pieces) == pytest.approx(share, rel=1e-2)  # together they are what the rod is
    threshold = 1.0 - 0.6 * share
    assert "rod0" not in rows_of(plain_mora(whole, threshold))
    lost = plain_mora(fine, threshold)
    assert any(name.startswith("rod") for name in rows_of(lost))
    assert error_without(whole, plain_mora(whole, threshold), output) < 0.3 * error_without(fine, lost, output)
    search = find_proper_model(fine.compiled.model, scenario(1.0), {output: 0.05}, step=2e-4)
    assert search.best is None or error_without(fine, search.best.removals, output) < 0.06
