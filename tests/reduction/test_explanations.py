"""What a plan says of its decisions, and what could be taken where removals leave no equations."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel.analysis.activity import rank_activity
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.modelling import ConstantFlow, ZeroEffort, ZeroFlow, elaborate
from propermodel.reduction.plan import plan_reduction
from propermodel.reduction.singular import Closure, SingularRemovals, explain_removals
from tests.physics.systems import compiled, run
from tests.reduction.rigs import driveline, ladder, preloaded, quarter_car


def explained(model: pm.Component, *removals: pm.Removal) -> SingularRemovals:
    found = explain_removals(elaborate(model), removals)
    assert found is not None
    return found


def test_rigid_parts_in_a_ring_are_a_loop_and_every_twin_is_regular():
    removals = [
        ZeroFlow(parse_path("tyre.spring.port")),
        ZeroFlow(parse_path("suspension.spring.port")),
        ZeroFlow(parse_path("body.flange")),
        ZeroEffort(parse_path("wheel.flange")),
    ]
    found = explained(quarter_car(), *removals)
    assert found.closure is Closure.LOOP
    assert set(found.members) == set(removals[:3])  # the massless wheel has no part in it
    assert len(found.twins) == 3
    for twin in found.twins:
        compiled(elaborate(quarter_car()).without(twin.instead if r == twin.member else r for r in removals))
    text = str(found)
    assert "body.flange (no flow)" in text
    assert "with road are a loop without a free variable" in text
    assert "regular would be no effort at body.flange or " in text


def test_what_nothing_holds_is_a_cutset():
    bonds = ("engine.shaft", "pinion.shaft", "shaft.spring.port", "shaft.damper.port")
    found = explained(driveline(), *(ZeroEffort(parse_path(bond)) for bond in bonds))
    assert found.closure is Closure.CUTSET
    assert {str(member.bond) for member in found.members} == set(bonds)
    assert all(isinstance(twin.instead, ZeroFlow) for twin in found.twins)


def test_where_nodes_share_effort_loops_are_of_efforts():
    found = explained(ladder(), *(ZeroEffort(parse_path(f"{name}.port")) for name in ("r1", "l1", "c1")))
    assert found.closure is Closure.LOOP
    assert {str(member.bond.parent) for member in found.members} == {"r1", "l1", "c1"}


def test_two_constants_in_a_row_of_gears_are_a_loop():
    removals = [ZeroFlow(parse_path("engine.shaft")), ConstantFlow(parse_path("pinion.shaft"), 3.0)]
    found = explained(driveline(), *removals)
    assert found.closure is Closure.LOOP
    assert {type(twin.instead) for twin in found.twins} == {ZeroEffort}


def test_regular_removals_need_no_explanation():
    assert explain_removals(elaborate(quarter_car()), [ZeroEffort(parse_path("body.flange"))]) is None


def test_a_removal_that_names_nothing_is_not_explained_away():
    with pytest.raises(ReductionError, match="which is no bond of the model"):
        explain_removals(elaborate(quarter_car()), [ZeroEffort(parse_path("body.flnge"))])


def test_every_row_lists_every_replacement_with_its_number():
    full = compiled(quarter_car(0.3, 10.0))
    r = run(full, 2.0, step=5e-4, every=1e-3)
    reduction = plan_reduction(full, r, rank_activity(r))
    for decision in reduction.decisions:
        kinds = {type(way.removal) for way in decision.ways}
        assert {ZeroEffort, ZeroFlow} <= kinds
    body = next(d for d in reduction.decisions if str(d.row.path) == "body")
    share = {type(way.removal): way.missing for way in body.ways}
    assert share[ZeroFlow] == pytest.approx(0.0206, rel=0.05)  # the clamped body: what the wheel hardly feels
    assert share[ZeroEffort] == pytest.approx(1.0)  # all that acts on the body is its inertia
    text = reduction.explain("body")
    assert "body.flange  no flow" in text
    assert "of the greatest activity missing at" in text


def test_the_dual_of_a_refused_replacement_is_in_the_list():
    full = compiled(preloaded())
    r = run(full, 2.0, step=5e-4, every=1e-3)
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.95, tolerance=0.2)
    text = reduction.explain("spring")
    assert text.splitlines()[0] == "spring, 1.685% of the activity: refused (too much together)"
    held = "spring.port  no flow                   0.02% of the greatest activity missing at brake.difference: small"
    assert held in text


def test_a_row_that_does_not_exist_is_not_explained():
    full = compiled(quarter_car())
    r = run(full, 1.0, step=5e-4)
    with pytest.raises(ReductionError, match="the plan has no row 'bodi'"):
        plan_reduction(full, r, rank_activity(r)).explain("bodi")
