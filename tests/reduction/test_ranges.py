"""Errors over ranges of parameters, against runs made one by one."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from propermodel.analysis.comparison import Feature
from propermodel.diagnostics import parse_path
from propermodel.reduction.ranges import halton

RK4 = pm.Method.RK4
OUTPUT = "body.flange.flow"
MASS, TYRE = parse_path("body.mass"), parse_path("tyre.spring.stiffness")
RANGES = {MASS: (900.0, 1500.0), TYRE: 0.2}


@pytest.fixture(scope="module")
def search() -> pm.ProperModelSearch:
    return pm.find_proper_model(
        pm.elaborate(QuarterCar()), scenario(), {OUTPUT: pm.Tolerance(rms=0.05, largest=0.2)}, method=RK4, step=1e-3
    )


def error_with(search: pm.ProperModelSearch, values: dict[pm.Path, float]) -> pm.OutputError:
    """The error of the recommended model with parameters; it has no tyre, so it is not told of its stiffness."""
    runs = [
        pm.simulate(
            pm.compile_model(model), replace(scenario(), parameters=own), method=RK4, step=1e-3, record_every=5e-3
        )
        for model, own in ((search.model, values), (search.reduced(), {MASS: values[MASS]}))
    ]
    (error,) = pm.compare(*runs, [OUTPUT]).outputs
    return error


def test_the_worst_case_is_that_of_runs_one_by_one(search: pm.ProperModelSearch):
    made = pm.certify(search, search.recommended, ranges=RANGES, samples=6)
    sampled = made.certificate.ranges
    assert sampled is not None
    assert (sampled.samples, sampled.unusable) == (10, 0)
    assert [(r.parameter, r.low, r.high) for r in sampled.ranges] == [
        (MASS, 900.0, 1500.0),
        (TYRE, pytest.approx(1.92e5), pytest.approx(2.88e5)),
    ]
    corners = list(itertools.product((900.0, 1500.0), (1.92e5, 2.88e5)))
    errors = {corner: error_with(search, dict(zip((MASS, TYRE), corner, strict=True))) for corner in corners}
    for case in sampled.worst:
        own = error_with(search, dict(case.parameters))
        assert case.error == pytest.approx(own.of(case.feature), rel=1e-6)
        assert case.error >= max(error.of(case.feature) for error in errors.values()) * (1.0 - 1e-9)
    assert [case.feature for case in sampled.worst] == [Feature.RMS, Feature.LARGEST]


def test_an_error_beyond_its_tolerance_somewhere_in_the_ranges_is_told(search: pm.ProperModelSearch):
    made = pm.certify(search, search.recommended, ranges=RANGES, samples=2)
    assert not made.certificate.is_within
    assert any("with body.mass = 900" in warning for warning in made.certificate.warnings)
    assert "parameters outside the ranges" in str(made)


def test_without_a_choice_a_larger_model_that_holds_everywhere_is_taken():
    tolerance = {OUTPUT: pm.Tolerance(rms=0.05, peak=0.04)}
    found = pm.find_proper_model(pm.elaborate(QuarterCar()), scenario(), tolerance, step=1e-3)
    assert found.recommended is not None
    made = pm.certify(found, ranges=RANGES, samples=2)
    assert made.certificate.is_within
    assert made.certificate.reduced.rows > found.rows - len(found.recommended.rows)


def test_a_reduced_model_that_fails_somewhere_is_infinitely_wrong(search: pm.ProperModelSearch):
    # Without wheel and tyre damper a mode at stiffness over damping is too fast for these steps where damping is small.
    chosen = replace(
        search.candidates[0],
        rows=(parse_path("wheel"), parse_path("tyre.damper")),
        removals=(pm.ZeroEffort(parse_path("wheel.flange")), pm.ZeroEffort(parse_path("tyre.damper.port"))),
    )
    made = pm.certify(search, chosen, ranges={"suspension.damper.damping": (20.0, 1500.0)}, samples=1)
    sampled = made.certificate.ranges
    assert sampled is not None
    assert sampled.unusable == 0
    assert [(case.error, dict(case.parameters)) for case in sampled.worst] == [
        (math.inf, {parse_path("suspension.damper.damping"): 20.0})
    ] * 2
    assert not made.certificate.is_within


def test_ranges_are_repeated_with_the_certificate(search: pm.ProperModelSearch, tmp_path: Path):
    made = pm.certify(search, search.recommended, ranges={MASS: 0.05}, samples=3)
    again = pm.read_certificate(pm.write_certificate(made, tmp_path))
    assert again.certificate == made.certificate
    verification = pm.verify_certificate(again)
    assert verification.holds
    assert any("over the ranges" in check.what for check in verification.checks)


def test_points_fill_the_ranges_evenly():
    points = halton(200, 3)
    assert points.shape == (200, 3)
    for column in points.T:
        counts, _ = np.histogram(column, bins=10, range=(0.0, 1.0))
        assert np.all(np.abs(counts - 20) <= 3)
    assert np.all(np.abs(np.corrcoef(points.T) - np.eye(3)) < 0.1)
    assert halton(4, 2)[:, 0] == pytest.approx([0.5, 0.25, 0.75, 0.125])


@pytest.mark.parametrize(
    ("ranges", "message"),
    [({"body.mas": 0.1}, "did you mean 'body.mass'"), ({"body.mass": (2.0, 1.0)}, "holds nothing")],
)
def test_ranges_of_nothing_are_refused(search: pm.ProperModelSearch, ranges: dict, message: str):
    with pytest.raises(pm.ProperModelError) as caught:
        pm.certify(search, ranges=ranges)
    assert message in str(caught.value)
