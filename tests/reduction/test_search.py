"""Searches for the smallest model within tolerances, against all subsets, and where activity alone goes wrong."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from propermodel.diagnostics import Path, parse_path
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, Weight
from propermodel.reduction.candidates import Verdict
from propermodel.reduction.prediction import predict_errors
from tests.cli import quarter_car as driven
from tests.physics.systems import SinePush

RK4 = pm.Method.RK4


class Pair(pm.Component):
    """A heavy mass on a soft spring carries a light one on a stiff spring, which is shaken."""

    shaker = SinePush(force=10.0, frequency=0.8)
    heavy = Mass(mass=2.0)
    light = Mass(mass=0.05)
    soft = Spring(stiffness=40.0)
    stiff = Spring(stiffness=2.0e3)
    damper = Damper(damping=2.0)
    ground = Fixed()

    connections = (
        pm.connect(ground.flange, soft.a, damper.a),
        pm.connect(soft.b, damper.b, heavy.flange, stiff.a),
        pm.connect(stiff.b, light.flange, shaker.flange),
    )


SHAKEN = pm.Scenario(name="shaken", stop=4.0)
OUTPUT = parse_path("heavy.flange.flow")


@cache
def all_subsets() -> dict[frozenset[Path], float]:
    """The least error of every set of rows that can go, over all replacements."""
    model = pm.elaborate(Pair())
    full = pm.simulate(pm.compile_model(model), SHAKEN, method=RK4, step=2e-3, record_every=4e-3)
    prediction = predict_errors(full, [OUTPUT])
    rows = {row.path: prediction.ways(row.bonds) for row in full.compiled.system.rows}
    found: dict[frozenset[Path], float] = {}
    for count in range(1, len(rows) + 1):
        for going in itertools.combinations(rows, count):
            for ways in itertools.product(*(rows[path] for path in going)):
                if prediction.of([removal for way in ways for removal in way]) is None:
                    continue  # what the linear equations cannot solve has no equations either
                try:
                    reduced = pm.compile_model(model.without([removal for way in ways for removal in way]))
                except pm.ProperModelError:
                    continue
                if OUTPUT not in reduced.lowered.observables:
                    continue
                run = pm.simulate(reduced, SHAKEN, method=RK4, step=2e-3, record=[OUTPUT], record_every=4e-3)
                if run.ending.is_complete:
                    error = pm.compare(full, run, [OUTPUT]).outputs[0].rms
                    found[frozenset(going)] = min(error, found.get(frozenset(going), np.inf))
    return found


@pytest.mark.parametrize("tolerance", [0.003, 0.02, 0.06])
def test_the_smallest_of_all_subsets_is_found(tolerance: float):
    found = pm.find_proper_model(
        pm.elaborate(Pair()), SHAKEN, {OUTPUT: tolerance}, method=RK4, step=2e-3, record_every=4e-3
    )
    truth = max((len(rows) for rows, error in all_subsets().items() if error <= tolerance), default=0)
    assert found.best is not None
    assert len(found.best.rows) == truth
    assert found.best.score <= 1.0
    assert found.simulations <= 25


def test_nothing_outside_the_tolerances_is_offered():
    model = pm.elaborate(QuarterCar())
    outputs = {"body.flange.flow": 0.01, "suspension.spring.port.effort": 0.01}
    found = pm.find_proper_model(model, scenario(), outputs, method=RK4, step=1e-3)
    assert found.best is not None
    full = pm.simulate(pm.compile_model(model), scenario(), method=RK4, step=1e-3, record_every=5e-3)
    again = pm.simulate(pm.compile_model(found.reduced()), scenario(), method=RK4, step=1e-3, record_every=5e-3)
    for output in pm.compare(full, again, outputs).outputs:
        assert output.rms <= 0.01
    assert found.best.states == 3
    assert set(map(str, found.best.rows)) == {"wheel", "tyre.damper"}
    assert "<- recommended" in str(found)


def test_all_scenarios_count():
    model = pm.elaborate(driven.QuarterCar())
    t = np.linspace(0.0, 10.0, 4001)
    slow, fast = (
        pm.Scenario(name=name, stop=10.0, inputs={"road.flow": pm.table_values([t], np.sin(rate * t))})
        for name, rate in (("slow", 5.0), ("fast", 50.0))
    )
    tolerances = {"body.flange.flow": 0.03}
    alone = pm.find_proper_model(model, slow, tolerances, method=RK4, step=1e-3)
    both = pm.find_proper_model(model, [slow, fast], tolerances, method=RK4, step=1e-3)
    assert alone.best is not None
    assert parse_path("wheel") in alone.best.rows
    assert both.best is None or parse_path("wheel") not in both.best.rows
    assert all(set(c.comparisons) == {"slow", "fast"} for c in both.candidates if c.verdict is Verdict.WITHIN)


class Loaded(pm.Component):
    """A soft spring carries a weight and hardly moves: no activity, yet the whole load."""

    shaker = SinePush(force=1.0, frequency=5.0)
    mass = Mass(mass=100.0)
    weight = Weight(mass=100.0)
    carrying = Spring(stiffness=4.0e4, start_compression=100.0 * 9.81 / 4.0e4)
    damper = Damper(damping=400.0)
    ground = Fixed()

    connections = (
        pm.connect(ground.flange, carrying.a, damper.a),
        pm.connect(carrying.b, damper.b, mass.flange, weight.flange, shaker.flange),
    )


def test_a_spring_that_carries_a_weight_is_not_dropped():
    model = pm.elaborate(Loaded())
    found = pm.find_proper_model(
        model, pm.Scenario(stop=4.0), {"mass.flange.flow": 0.2}, method=RK4, step=1e-3, record_every=5e-3
    )
    dropped = {
        type(removal)
        for c in found.candidates
        if c.verdict is Verdict.WITHIN
        for removal in c.removals
        if not isinstance(removal, pm.Freeze) and removal.bond == parse_path("carrying.port")
    }
    assert pm.ZeroEffort not in dropped


def test_progress_and_budget():
    seen: list[int] = []
    found = pm.find_proper_model(
        pm.elaborate(QuarterCar()),
        scenario(),
        {"body.flange.flow": 1e-4},
        method=RK4,
        step=1e-3,
        most_simulations=1,
        progress=lambda _, simulations: seen.append(simulations),
    )
    assert seen
    assert found.simulations <= 2
    assert len(seen) == len(found.candidates)


def test_every_feature_of_a_tolerance_counts():
    model = pm.elaborate(driven.QuarterCar())
    t = np.linspace(0.0, 10.0, 4001)
    ramp = pm.Scenario(name="ramp", stop=10.0, inputs={"road.flow": pm.table_values([t], np.minimum(t, 1.0))})
    output = "body.flange.flow"
    loose, strict = pm.Tolerance(final=0.01), pm.Tolerance(final=0.01, largest=0.01, settling=0.02)
    free = pm.find_proper_model(model, ramp, {output: loose}, method=RK4, step=1e-3)
    bound = pm.find_proper_model(model, ramp, {output: strict}, method=RK4, step=1e-3)
    assert free.best is not None
    assert bound.best is not None
    assert len(free.best.rows) > len(bound.best.rows)
    full, kept, less = (
        pm.simulate(pm.compile_model(m), ramp, method=RK4, step=1e-3, record_every=5e-3)
        for m in (model, bound.reduced(bound.best), free.reduced(free.best))
    )
    within, beyond = (pm.compare(full, run, [output]).outputs[0] for run in (kept, less))
    # The body goes its way however the wheel shakes, so the end alone is easy to keep.
    assert abs(beyond.final_error) <= 0.01
    assert beyond.largest > 0.01
    assert max(abs(within.final_error), within.largest) <= 0.01
    assert bound.best.score == pytest.approx(strict.score(within), rel=1e-3)


def test_a_search_without_tolerances_is_refused():
    with pytest.raises(pm.ProperModelError) as caught:
        pm.find_proper_model(pm.elaborate(QuarterCar()), scenario(), {})
    assert caught.value.diagnostics[0].code == "reduction/tolerances"
