"""Predicted errors of removals against the runs of models from which the elements were removed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from scipy.stats import spearmanr

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from examples.slider_crank import SliderCrank
from examples.slider_crank import scenario as crank_scenario
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import parse_path
from propermodel.library.mechanics.translation import Damper, Fixed, HardeningSpring, Mass, QuadraticDrag, Spring
from propermodel.reduction.prediction import Prediction, Replacement
from propermodel.simulation.trajectory import Trajectory
from tests.physics.systems import SinePush

OUTPUTS = ("body.flange.flow", "suspension.spring.port.effort")
CLOSE = 0.04  # what rings on after the end of the window is predicted, too
SETTINGS = {"method": pm.Method.RK4, "step": 5e-4, "record_every": 2e-3}


@cache
def quarter_car() -> tuple[pm.Model, Trajectory, Prediction]:
    model = pm.elaborate(QuarterCar())
    run = pm.simulate(pm.compile_model(model), scenario(), **SETTINGS)
    return model, run, pm.predict_errors(run, OUTPUTS)


def weighted_error(full: Trajectory, other: Trajectory, path: str) -> float:
    """The measure that is predicted: root mean square with the weight exp(-2 t / T), over the range."""
    weight = np.exp(-2.0 * (full.time - full.time[0]) / (full.time[-1] - full.time[0]))
    difference = (other[path] - full[path]) * weight
    return float(np.sqrt(np.sum(difference**2) / np.sum(weight**2)) / np.ptp(full[path]))


def removed(model: pm.Model, removals: Sequence[Replacement]) -> Trajectory:
    return pm.simulate(pm.compile_model(model.without(removals)), scenario(), **SETTINGS)


def test_predictions_are_exact_for_single_removals_of_a_linear_model():
    model, full, prediction = quarter_car()
    compared = 0
    for row in prediction.rows():
        for way in row.ways:
            other = removed(model, way.removals)
            for path, error in way.errors.items():
                true = weighted_error(full, other, str(path))
                assert error == pytest.approx(true, rel=CLOSE, abs=1e-6), (way.removals, path)
                compared += 1
    assert compared > 25


@pytest.mark.parametrize(
    "removals",
    [
        (pm.ZeroEffort(parse_path("wheel.flange")), pm.ZeroEffort(parse_path("tyre.damper.port"))),
        (pm.ZeroFlow(parse_path("tyre.spring.port")), pm.ZeroEffort(parse_path("suspension.damper.port"))),
        (
            pm.ConstantEffort(parse_path("suspension.spring.port"), 150.0),
            pm.ZeroEffort(parse_path("wheel.flange")),
            pm.ZeroEffort(parse_path("tyre.damper.port")),
        ),
    ],
)
def test_predictions_are_exact_for_several_removals_at_once(removals: tuple[Replacement, ...]):
    model, full, prediction = quarter_car()
    other, predicted = removed(model, removals), prediction.of(removals)
    assert predicted is not None
    for path, error in predicted.errors.items():
        assert error == pytest.approx(weighted_error(full, other, str(path)), rel=CLOSE)


def test_removals_that_leave_no_solution_have_no_prediction():
    prediction = quarter_car()[2]
    twice = tuple(pm.ZeroFlow(parse_path(path)) for path in ("tyre.spring.port", "tyre.damper.port"))
    assert prediction.of(twice) is None  # the tyre made rigid twice
    assert prediction.of(()) == pm.PredictedError((), dict.fromkeys(map(parse_path, OUTPUTS), 0.0))
    with pytest.raises(pm.ProperModelError, match=r"did you mean .tyre\.spring\.port"):
        prediction.of((pm.ZeroFlow(parse_path("tyre.sprin.port")),))


class Absorber(pm.Component):
    """A mass and a spring in series that cancel each other at the frequency of the push, beside a damper."""

    shaker = SinePush(force=10.0, frequency=2.0)
    machine = Mass(mass=1.0)
    stiffness = Spring(stiffness=(2.0 * np.pi * 2.0) ** 2)
    damper = Damper(damping=20.0)
    ground = Fixed()

    connections = (
        pm.connect(shaker.flange, machine.flange, stiffness.a, damper.a),
        pm.connect(stiffness.b, damper.b, ground.flange),
    )


def test_a_pair_that_cancels_is_seen():
    """At resonance mass and spring are the most active, and together they do nothing."""
    run = pm.simulate(
        pm.compile_model(pm.elaborate(Absorber())),
        pm.Scenario(stop=20.0),
        method=pm.Method.RK4,
        step=1e-3,
        record_every=5e-3,
    )
    ranking = pm.rank_activity(run)
    assert ranking.row(parse_path("damper")).index < ranking.row(parse_path("machine")).index * 3.0
    prediction = pm.predict_errors(run, ["damper.port.effort"])
    mass, spring = pm.ZeroEffort(parse_path("machine.flange")), pm.ZeroEffort(parse_path("stiffness.port"))
    alone = [prediction.of([removal]) for removal in (mass, spring)]
    pair = prediction.of([mass, spring])
    assert pair is not None
    assert all(way is not None and way.worst > 5.0 * pair.worst for way in alone)


class Nonlinear(pm.Component):
    """Three masses in a row on springs that harden and dampers that grow with speed."""

    shaker = SinePush(force=30.0, frequency=0.7)
    masses = pm.repeat(3, Mass(mass=1.0))
    springs = pm.repeat(3, HardeningSpring(stiffness=60.0, cubic_stiffness=2000.0))
    drags = pm.repeat(3, QuadraticDrag(air_density=1.2, drag_area=5.0))
    small = Mass(mass=0.02)
    soft = Spring(stiffness=0.5)
    leak = Damper(damping=0.05)
    dampers = pm.repeat(3, Damper(damping=1.0))
    ground = Fixed()

    connections = (
        pm.connect(ground.flange, springs[0].a, soft.a, leak.a, *(damper.a for damper in dampers)),
        pm.connect(springs[0].b, masses[0].flange, drags[0].flange, dampers[0].b, springs[1].a, leak.b, soft.b),
        pm.connect(springs[1].b, masses[1].flange, drags[1].flange, dampers[1].b, springs[2].a, small.flange),
        pm.connect(springs[2].b, masses[2].flange, drags[2].flange, dampers[2].b, shaker.flange),
    )


def ranks(found: FloatArray, true: FloatArray) -> float:
    return float(spearmanr(found, true).statistic)


def test_predictions_rank_a_nonlinear_model_better_than_activity_does():
    model = pm.elaborate(Nonlinear())
    settings = {"method": pm.Method.RK4, "step": 1e-3, "record_every": 5e-3}
    full = pm.simulate(pm.compile_model(model), pm.Scenario(stop=20.0), **settings)
    outputs = ["masses[0].flange.flow", "masses[2].flange.flow"]
    prediction, ranking = pm.predict_errors(full, outputs), pm.rank_activity(full)
    found: list[tuple[float, float, float]] = []
    for row in prediction.rows():
        assert row.best is not None
        other = pm.simulate(pm.compile_model(model.without(row.best.removals)), pm.Scenario(stop=20.0), **settings)
        true = max(output.rms for output in pm.compare(full, other, outputs).outputs)
        found.append((row.best.worst, true, ranking.row(row.row).index))
    predicted, true, activity = np.array(found).T
    assert ranks(predicted, true) > 0.9
    assert ranks(predicted, true) > ranks(activity, true)
    assert np.mean(np.abs(np.log2(predicted / true)) < 1.0) >= 0.8


def test_relations_that_are_far_from_linear_are_named():
    run = pm.simulate(pm.compile_model(pm.elaborate(SliderCrank())), crank_scenario(), step=1e-4, record_every=1e-3)
    (note,) = pm.predict_errors(run, ["flywheel.shaft.flow"]).notes
    assert "drive (1" in note
    assert not quarter_car()[2].notes


def test_a_table_reads_well():
    _, run, prediction = quarter_car()
    lines = prediction.text(pm.rank_activity(run)).splitlines()
    assert lines[0].split() == ["element", "replaced", "by", "activity", "body.flange.flow", "...on.spring.port.effort"]
    assert lines[1].split()[:5] == ["1", "tyre.damper", "no", "effort", "0.022%"]
    assert len(lines) == 7


@pytest.mark.parametrize(
    ("outputs", "code"),
    [
        ([], "reduction/unknown-output"),
        (["body.flange.flo"], "reduction/unknown-output"),
        (["body.mass"], "reduction/unknown-output"),
    ],
)
def test_outputs_that_cannot_be_predicted_are_refused(outputs: list[str], code: str):
    with pytest.raises(pm.ProperModelError) as caught:
        pm.predict_errors(quarter_car()[1], outputs)
    assert caught.value.diagnostics[0].code == code
