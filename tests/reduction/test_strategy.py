"""What makes a search cheap: pairs that cancel, runs that end early, refusals that are learnt."""

from __future__ import annotations

import numpy as np
import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from propermodel.analysis.tolerances import Tolerance
from propermodel.diagnostics import Path, parse_path
from propermodel.reduction.candidates import Verdict
from propermodel.reduction.prediction import Replacement
from propermodel.reduction.refusals import fewest_refused
from propermodel.reduction.watched_run import WatchedRun, least_errors, run_watched, score_of
from propermodel.simulation.stepping import Stepping
from tests.reduction.test_prediction import Absorber

RK4 = pm.Method.RK4
OUTPUT = parse_path("body.flange.flow")


def absorber() -> pm.ProperModelSearch:
    return pm.find_proper_model(
        pm.elaborate(Absorber()), pm.Scenario(stop=20.0), {"damper.port.effort": 0.2}, method=RK4, step=1e-3
    )


def test_pairs_are_predicted_as_each_of_them_is():
    run = pm.simulate(pm.compile_model(pm.elaborate(QuarterCar())), scenario(), method=RK4, step=1e-3)
    prediction = pm.predict_errors(run, [OUTPUT, "suspension.spring.port.effort"])
    removals: list[Replacement] = [
        pm.ZeroEffort(parse_path("wheel.flange")),
        pm.ZeroFlow(parse_path("wheel.flange")),
        pm.ZeroFlow(parse_path("tyre.spring.port")),
        pm.ZeroFlow(parse_path("tyre.damper.port")),
        pm.ConstantEffort(parse_path("suspension.spring.port"), 100.0),
    ]
    found = prediction.responses.pair_errors([prediction.move(removal) for removal in removals])
    for i, first in enumerate(removals):
        for j, second in enumerate(removals):
            together = None if first.bond == second.bond else prediction.of([first, second])
            if together is None:
                assert np.all(np.isnan(found[:, i, j])), (first, second)
            else:
                assert found[:, i, j] == pytest.approx(list(together.errors.values()), rel=1e-9)


def test_a_pair_that_cancels_goes_together_and_is_called_fragile():
    found = absorber()
    assert found.best is not None
    assert {"machine", "stiffness"} <= set(map(str, found.best.rows))
    assert {"machine", "stiffness"} <= set(map(str, found.best.fragile))
    assert "fragile" in str(found)


def test_a_run_ends_when_it_is_outside():
    model = pm.elaborate(QuarterCar())
    full = pm.compile_model(model)
    driven = scenario()
    reference = pm.simulate(full, driven, method=RK4, step=1e-3, record_every=5e-3)
    smaller = pm.compile_model(model.without([pm.ZeroEffort(parse_path("suspension.damper.port"))]))
    stepping = Stepping(RK4, 1e-3, 1, 1e-6)

    def watched(tolerance: Tolerance) -> WatchedRun:
        return run_watched(smaller, driven, reference, {OUTPUT: tolerance}, stepping, 5e-3)

    whole = watched(Tolerance(rms=10.0))
    assert whole.comparison is not None
    other = pm.simulate(smaller, driven, method=RK4, step=1e-3, record_every=5e-3)
    plain = pm.compare(reference, other, [OUTPUT]).outputs[0]
    assert whole.comparison.outputs[0].rms == pytest.approx(plain.rms, rel=1e-12)
    for feature in ("rms", "mean", "largest"):
        share = getattr(plain, feature)
        tolerance = Tolerance(**{feature: 0.05 * share})
        early = watched(tolerance)
        assert early.comparison is None
        assert early.time < driven.stop
        assert 1.0 < early.score({OUTPUT: tolerance}) <= 20.0 + 1e-9


def test_bounds_grow_towards_the_score():
    model = pm.elaborate(QuarterCar())
    reference = pm.simulate(pm.compile_model(model), scenario(), method=RK4, step=1e-3)
    tolerances = {OUTPUT: Tolerance(rms=0.01)}
    changed = reference[OUTPUT] + 0.02 * np.ptp(reference[OUTPUT])
    bounds = [
        score_of(least_errors(reference, reference.time[:count], {OUTPUT: changed[:count]}), tolerances)
        for count in (len(changed) // 4, len(changed) // 2, len(changed))
    ]
    assert bounds == pytest.approx([1.0, np.sqrt(2.0), 2.0], rel=0.05)


def test_the_fewest_rows_that_are_refused_are_found():
    rows = {Path((f"row{k}",)): (pm.ZeroEffort(Path((f"row{k}", "port"))),) for k in range(40)}
    bad = {Path(("row7",)), Path(("row29",)), Path(("row30",))}
    asked: list[int] = []

    def is_refused(part: dict[Path, tuple[Replacement, ...]]) -> bool:
        asked.append(len(part))
        return bad <= set(part)

    assert set(fewest_refused(rows, is_refused)) == bad
    assert len(asked) < 25


def test_what_is_refused_is_not_tried_again():
    found = pm.find_proper_model(
        pm.elaborate(QuarterCar()), scenario(), {"suspension.damper.port.flow": 0.5}, method=RK4, step=1e-3
    )
    refused = [set(c.removals) for c in found.candidates if c.verdict is Verdict.REFUSED]
    for k, first in enumerate(refused):
        assert not any(first <= second for second in refused[k + 1 :])
