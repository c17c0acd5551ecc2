"""Comparison of runs, on runs whose difference is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.analysis.comparison import Feature, OutputError, compare
from propermodel.analysis.features import Peak, SignalFeatures, Undefined
from propermodel.diagnostics import SimulationError
from propermodel.library.mechanics.translation import Mass
from propermodel.modelling import connect
from tests.physics.systems import Push, compiled, run, system


@pytest.fixture(scope="module")
def model():
    push, mass = Push(force=4.0), Mass(mass=2.0)
    return compiled(system(connect(push.flange, mass.flange), push=push, mass=mass))


def test_a_run_equals_itself(model):
    r = run(model, 1.0)
    (error,) = compare(r, r, ["mass.flange.flow"]).outputs
    assert (error.rms, error.largest, error.final_error) == (0.0, 0.0, 0.0)


def test_numbers_of_a_known_difference(model):
    # v = 2 t against v = 3 t over 1 s: the difference t has maximum 1 and rms 1/sqrt(3); the range is 2.
    slow, fast = run(model, 1.0, every=1e-3), run(model, 1.0, every=1e-3, parameters={"push.force": 6.0})
    (error,) = compare(slow, fast, ["mass.flange.flow"]).outputs
    assert error.reference_range == pytest.approx(2.0)
    assert error.largest == pytest.approx(0.5)
    assert error.at == pytest.approx(1.0)
    assert error.mean == pytest.approx(0.25)
    assert error.rms == pytest.approx(0.5 / np.sqrt(3.0), rel=1e-3)
    assert (error.reference.final, error.other.final) == (pytest.approx(2.0), pytest.approx(3.0))
    assert error.final_error == pytest.approx(0.5)
    assert str(error) == (
        "mass.flange.flow: rms 28.868% of its range, largest 50.000% at 1.0 s, final 2 -> 3 m/s (+50.000%)"
    )


def test_runs_on_different_grids_are_compared_at_the_instants_of_the_reference(model):
    coarse, fine = run(model, 1.0, every=0.1), run(model, 1.0, every=0.03)
    (error,) = compare(coarse, fine, ["mass.flange.flow"]).outputs
    assert error.largest < 0.02


def test_a_constant_output_is_measured_against_its_size(model):
    one, other = run(model, 1.0), run(model, 1.0, parameters={"push.force": 6.0})
    (error,) = compare(one, other, ["mass.flange.effort"]).outputs
    assert error.reference_range == pytest.approx(0.0, abs=1e-12)
    assert error.largest == pytest.approx(0.5)


def test_an_output_that_one_run_lacks_is_named(model):
    r = run(model, 1.0)
    with pytest.raises(SimulationError, match=r"the model has no observable 'mass\.flange\.flwo'"):
        compare(r, r, ["mass.flange.flwo"])


def differing(**changes: object) -> OutputError:
    """An output that rises to 2 in 4 s with a peak of 3, and of the other run what is given."""
    before = SignalFeatures(final=2.0, peak=Peak(3.0, 5.0), rise=4.0, settling=10.0)
    after = SignalFeatures(**{"final": 2.1, "peak": Peak(3.3, 4.0), "rise": 5.0, "settling": 8.0, **changes})  # pyright: ignore[reportArgumentType]
    return OutputError(
        path=pm.Path(("y",)),
        unit="m",
        reference_range=3.0,
        mean=0.01,
        rms=0.02,
        largest=0.05,
        at=1.0,
        scale=3.0,
        reference=before,
        other=after,
    )


def test_every_feature_has_a_share():
    shares = {feature.value: differing().of(feature) for feature in Feature}
    assert shares == pytest.approx(
        {
            "mean": 0.01,
            "rms": 0.02,
            "largest": 0.05,
            "final": 0.1 / 3.0,
            "peak": 0.1,
            "peak_time": 0.2,
            "rise": 0.25,
            "settling": 0.2,
        }
    )


def test_a_tolerance_is_judged_by_its_worst_feature():
    assert pm.Tolerance(rms=0.04).score(differing()) == pytest.approx(0.5)
    both = pm.Tolerance(rms=0.04, settling=0.1)
    assert both.score(differing()) == pytest.approx(2.0)
    assert both.smallest == 0.04
    assert str(both) == "rms within 4 %, settling within 10 %"
    assert both.score(differing(settling=Undefined("it still moves"))) == math.inf
    assert pm.Tolerance.of(0.03) == pm.Tolerance(rms=0.03)


def test_the_peak_of_the_other_run_is_sought_on_the_same_side(model):
    # One rises, the other falls: what the other has is no peak of the first.
    up, down = run(model, 1.0, every=1e-2), run(model, 1.0, every=1e-2, parameters={"push.force": -4.0})
    (found,) = compare(up, down, ["mass.flange.flow"]).outputs
    assert isinstance(found.other.peak, Undefined)
    assert "to that side" in found.other.peak.why


@pytest.mark.parametrize("share", [0.0, -0.1, math.inf, math.nan])
def test_a_tolerance_is_a_share_above_zero(share: float):
    with pytest.raises(pm.ProperModelError, match="a share above zero"):
        pm.Tolerance(final=share)


def test_a_tolerance_names_a_feature():
    with pytest.raises(pm.ProperModelError, match="needs a feature"):
        pm.Tolerance()
