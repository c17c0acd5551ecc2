"""Activity of bonds and junctions, against what symmetry, transformers and closed forms say."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from examples import coupled_coils
from propermodel.library.mechanics.planar.components import PlanarBody
from propermodel.library.mechanics.rotation import Gear, RotatingInertia
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from tests.physics.systems import Push, SinePush, run, system


class Twist(pm.EffortSource):
    shaft = pm.Port(pm.Rotation)
    torque: pm.Parameter = pm.parameter("N.m")

    def effort(self) -> pm.Expr:
        return -self.torque


def path(text: str) -> pm.Path:
    return pm.Path(tuple(text.split(".")))


def resonance() -> pm.Component:
    """A pushed mass between a spring and a damper to the ground."""
    push, mass, spring = SinePush(force=2.0, frequency=1.0), Mass(mass=2.0), Spring(stiffness=50.0)
    damper, ground = Damper(damping=3.0), Fixed()
    return system(
        pm.connect(push.flange, mass.flange, spring.a, damper.a),
        pm.connect(spring.b, damper.b, ground.flange),
        push=push,
        mass=mass,
        spring=spring,
        damper=damper,
        ground=ground,
    )


def test_relative_activities_at_a_junction_are_those_of_harmonic_motion():
    # On a common flow v sin(wt): I m v^2 / 2, C k v^2 / (2 w^2), R pi d v^2 / (2 w) per half period, and the source
    # the integral of |sin(wt) (a sin(wt) + b cos(wt))|.
    answer = pm.simulate(
        pm.compile_model(pm.elaborate(resonance())),
        pm.Scenario(stop=30.0),
        method=pm.Method.RK4,
        step=1e-3,
        integrals_every=1.0,
    )
    ranking = pm.rank_bonds(answer, window=(29.0, 30.0))
    w = 2.0 * math.pi
    reactance = 2.0 * w - 50.0 / w
    swing = abs(complex(3.0, reactance))
    phase = math.atan2(reactance, 3.0)
    # mean |cos(p) + cos(2x + p)| / 2, by quadrature
    x = np.linspace(0.0, math.pi, 200001)
    pushed = swing * float(np.mean(np.abs(np.cos(phase) + np.cos(2.0 * x + phase)))) / 2.0 * 2.0 * math.pi / w
    expected = {
        "mass.flange": 2.0 * 2.0,
        "spring.port": 2.0 * 50.0 / w**2,
        "damper.port": math.pi * 3.0 / w,
        "push.flange": pushed,
    }
    (junction,) = {row.at[0].junction for row in ranking.rows if row.path.parent == path("push")}
    for name, value in expected.items():
        (end,) = [end for end in ranking.row(path(name)).at if end.junction == junction] or [None]
        assert end is not None
        assert end.relative == pytest.approx(value / max(expected.values()), rel=1e-3)
    assert ranking.junction(junction).bonds[0] == (path("mass.flange"), 1.0)
    assert ranking.inactive == ()


def test_both_sides_of_a_transformer_have_the_same_activity():
    ranking = pm.rank_bonds(run(geared(), 1.0))
    first, second = (ranking.row(path(f"gear.{port}")) for port in ("a", "b"))
    assert first.kind == second.kind == "TF"
    assert first.activity == pytest.approx(second.activity, rel=1e-12)
    assert second.activity == pytest.approx(ranking.row(path("load.shaft")).activity, rel=1e-12)


def geared() -> pm.Component:
    engine, gear = RotatingInertia(inertia=1.0, start_speed=2.0), Gear(ratio=3.0)
    load, twist = RotatingInertia(inertia=4.0), Twist(torque=1.0)
    return system(
        pm.connect(engine.shaft, gear.a, twist.shaft),
        pm.connect(gear.b, load.shaft),
        engine=engine,
        gear=gear,
        load=load,
        twist=twist,
    )


def symmetric(offset: float) -> pm.Component:
    """Two equal masses that swing against each other, and a body on springs between them."""
    left, right = (Mass(mass=1.0, start_velocity=v) for v in (1.0, -1.0 - offset))
    middle, near, far = Mass(mass=0.5), Spring(stiffness=40.0), Spring(stiffness=40.0)
    return system(
        pm.connect(left.flange, near.a),
        pm.connect(near.b, middle.flange, far.a),
        pm.connect(far.b, right.flange),
        left=left,
        right=right,
        middle=middle,
        near=near,
        far=far,
    )


def test_a_junction_that_symmetry_holds_still_is_inactive():
    ranking = pm.rank_bonds(run(symmetric(0.0), 2.0))
    still = ranking.row(path("middle.flange")).at[0].junction
    assert [junction.path for junction in ranking.inactive] == [still]
    assert ranking.junction(still).share < 1e-9
    assert f"inactive: 1-junction {still}" in str(ranking)
    assert pm.rank_bonds(run(symmetric(0.5), 2.0)).inactive == ()


def test_a_junction_is_inactive_only_if_no_run_moves_it():
    car = pm.compile_model(pm.elaborate(symmetric(0.0)))
    calm = run(car, 2.0)
    lively = run(car, 2.0, initial={"right.momentum": -2.0})
    assert len(pm.rank_bonds([calm]).inactive) == 1
    both = pm.rank_bonds([calm, lively])
    assert both.inactive == ()
    one, other = (pm.rank_bonds(r).row(path("middle.flange")) for r in (calm, lively))
    assert both.row(path("middle.flange")).activity == pytest.approx(one.activity + other.activity)


def test_finer_steps_tell_what_a_share_is_worth():
    coarse, fine, finest = (run(resonance(), 5.0, step=step, every=0.5) for step in (0.1, 0.05, 1e-3))
    checked = pm.rank_bonds(coarse, refined=fine)
    truth = {row.path: row.share for row in pm.rank_bonds(finest).rows}
    assert checked.comparison == "at a step of 0.05 s instead of 0.1 s"
    for row in checked.rows:
        assert row.change_points is not None
        assert 100.0 * abs(row.share - truth[row.path]) < 3.0 * row.change_points + 1e-6


def test_every_degree_of_freedom_of_a_body_is_a_row():
    body = PlanarBody(mass=3.0, pitch_inertia=2.0, start_speed=5.0)
    push, lift, twist = Push(force=4.0), Push(force=1.0), Twist(torque=0.0)
    parts = {"body": body, "push": push, "lift": lift, "twist": twist}
    model = system(
        pm.connect(push.flange, body.forward),
        pm.connect(lift.flange, body.vertical),
        pm.connect(twist.shaft, body.pitch),
        **parts,
    )
    rows = {str(row.path): row for row in pm.rank_activity(run(model, 2.0)).rows}
    assert set(rows) == {"body.forward_mass", "body.vertical_mass", "body.inertia"}
    # From 5 to 5 + 4/3 * 2 m/s ahead, from 0 to 1/3 * 2 m/s upwards, and no turn.
    assert rows["body.forward_mass"].activity == pytest.approx(1.5 * ((5.0 + 8.0 / 3.0) ** 2 - 25.0), rel=1e-9)
    assert rows["body.vertical_mass"].activity == pytest.approx(1.5 * (2.0 / 3.0) ** 2, rel=1e-9)
    assert rows["body.inertia"].activity == 0.0


def test_a_field_is_one_row_with_the_activity_of_each_port():
    answer = coupled_coils.run(pm.elaborate(coupled_coils.CoupledCoils()))
    ranking = pm.rank_activity(answer)
    row = ranking.row(path("coils"))
    ports = dict(row.ports)
    assert row.activity == pytest.approx(np.sum(np.abs(np.diff(answer["coils.energy"]))), rel=1e-3)
    assert set(ports) == {path("coils.primary"), path("coils.secondary")}
    # The field takes up what the winding lets through, and passes on what the load burns.
    assert ports[path("coils.secondary")] == pytest.approx(
        pm.rank_activity(answer).row(path("load")).activity, rel=1e-9
    )
    assert row.activity < row.sum_over_ports
    assert {path("coils.primary"), path("coils.secondary")} <= {bond.path for bond in pm.rank_bonds(answer).rows}
