"""Local tests over several runs: what is dropped is small in each of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

import propermodel as pm
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.library.mechanics.rotation import RotatingInertia, RotationalSpringDamper, ViscousFriction
from propermodel.library.vehicle.half_car import HalfCar
from propermodel.modelling import ConstantFlow, ZeroFlow
from propermodel.reduction.plan import Verdict
from propermodel.reduction.single import Refusal
from propermodel.simulation.trajectory import Trajectory
from tests.physics.systems import Drive, compiled, run, scenario, system
from tests.reduction.rigs import quarter_car


def waves(full: pm.CompiledModel, *frequencies: float) -> list[Trajectory]:
    return [
        replace(
            run(full, 4.0, step=5e-4, every=2e-3, parameters={"road.frequency": f, "tyre.damping": 400.0}),
            scenario=replace(scenario(4.0), name=f"{f:g} Hz"),
        )
        for f in frequencies
    ]


def decision(reduction: pm.Reduction, row: str):
    return next(d for d in reduction.decisions if d.row.path == parse_path(row))


def test_what_is_small_in_one_scenario_must_be_small_in_all():
    full = compiled(quarter_car(velocity=0.3))
    runs = waves(full, 1.0, 14.0)
    ranking = pm.rank_activity(runs)
    slow, fast, both = (pm.plan_reduction(full, r, ranking, threshold=0.6) for r in (runs[0], runs[1], runs))
    # On slow waves the damper of the tyre gives 1.5 % of what its spring gives, on fast ones 22 %: pi d w / (2 k).
    assert decision(slow, "tyre.damper").verdict is Verdict.REMOVED
    assert decision(both, "tyre.damper").cause is decision(fast, "tyre.damper").cause is Refusal.LARGE
    # On fast waves the body stands still, on slow ones it does not.
    assert ZeroFlow(parse_path("body.flange")) in fast.removals
    assert decision(both, "body").cause is decision(slow, "body").cause is Refusal.LARGE
    assert both.removed == ()
    # What one scenario would have dropped is missed in the other.
    force = "tyre.a.effort"
    for reduction, other in ((slow, runs[1]), (fast, runs[0])):
        reduced = compiled(full.model.without(reduction.removals))
        (error,) = pm.compare(other, run(reduced, 4.0, step=5e-4, every=2e-3, **given(other)), [force]).outputs
        assert error.rms > 0.02


def given(of: Trajectory) -> dict[str, dict[str, float]]:
    frequency = float(of.scenario.name.split()[0])
    return {"parameters": {"road.frequency": frequency, "tyre.damping": 400.0}}


def test_a_run_twice_is_like_once():
    full = compiled(quarter_car(velocity=0.3))
    (one,) = waves(full, 3.0)
    ranking = pm.rank_activity(one)
    once, twice = (pm.plan_reduction(full, r, ranking, threshold=0.9) for r in (one, [one, one]))
    assert once.removals == twice.removals != ()
    assert [(d.verdict, d.cause) for d in once.decisions] == [(d.verdict, d.cause) for d in twice.decisions]


def flywheel() -> pm.Component:
    """A heavy wheel that drives a light one through a soft shaft."""
    heavy, shaft = RotatingInertia(inertia=400.0), RotationalSpringDamper(stiffness=50.0, damping=2.0)
    light, bearing, drive = RotatingInertia(inertia=0.5), ViscousFriction(damping=0.2), Drive(torque=3.0)
    return system(
        pm.connect(heavy.shaft, shaft.a),
        pm.connect(shaft.b, light.shaft, bearing.shaft, drive.shaft),
        heavy=heavy,
        shaft=shaft,
        light=light,
        bearing=bearing,
        drive=drive,
    )


def test_a_store_is_constant_only_if_it_has_one_value_in_all_scenarios():
    full = compiled(flywheel())
    runs = [run(full, 8.0, every=8e-3, initial={"heavy.shaft.flow": v, "light.shaft.flow": v}) for v in (10.0, 60.0)]
    ranking = pm.rank_activity(runs)
    for one in runs:
        alone = pm.plan_reduction(full, one, ranking, threshold=0.5)
        (constant,) = (r for r in alone.removals if isinstance(r, ConstantFlow))
        assert constant.value == pytest.approx(one["heavy.shaft.flow"].mean(), rel=0.02)
    both = pm.plan_reduction(full, runs, ranking, threshold=0.5)
    assert not any(isinstance(removal, ConstantFlow) for removal in both.removals)


def test_runs_of_another_model_or_none_are_refused():
    full, other = compiled(quarter_car()), compiled(HalfCar())
    (one,) = waves(full, 3.0)
    ranking = pm.rank_activity(one)
    with pytest.raises(ReductionError, match=r"reduction/runs.*the run of scenario '3 Hz' is one of another model"):
        pm.plan_reduction(other, [one], ranking)
    with pytest.raises(ReductionError, match="there is no run to reduce system by"):
        pm.plan_reduction(full, [], ranking)
