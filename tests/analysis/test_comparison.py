"""Comparison of runs, on runs whose difference is known."""

from __future__ import annotations

import numpy as np
import pytest

from propermodel.analysis.comparison import compare
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
    assert (error.rms, error.maximum, error.final_error) == (0.0, 0.0, 0.0)


def test_numbers_of_a_known_difference(model):
    # v = 2 t against v = 3 t over 1 s: the difference t has maximum 1 and rms 1/sqrt(3); the range is 2.
    slow, fast = run(model, 1.0, every=1e-3), run(model, 1.0, every=1e-3, parameters={"push.force": 6.0})
    (error,) = compare(slow, fast, ["mass.flange.flow"]).outputs
    assert error.reference_range == pytest.approx(2.0)
    assert error.maximum == pytest.approx(0.5)
    assert error.at == pytest.approx(1.0)
    assert error.rms == pytest.approx(0.5 / np.sqrt(3.0), rel=1e-3)
    assert (error.reference_final, error.final) == (pytest.approx(2.0), pytest.approx(3.0))
    assert error.final_error == pytest.approx(0.5)
    assert str(error) == (
        "mass.flange.flow: rms 28.875% of its range, largest 50.000% at 1.0 s, final 2 -> 3 m/s (+50.000%)"
    )


def test_runs_on_different_grids_are_compared_at_the_instants_of_the_reference(model):
    coarse, fine = run(model, 1.0, every=0.1), run(model, 1.0, every=0.03)
    (error,) = compare(coarse, fine, ["mass.flange.flow"]).outputs
    assert error.maximum < 0.02


def test_a_constant_output_is_measured_against_its_size(model):
    one, other = run(model, 1.0), run(model, 1.0, parameters={"push.force": 6.0})
    (error,) = compare(one, other, ["mass.flange.effort"]).outputs
    assert error.reference_range == pytest.approx(0.0, abs=1e-12)
    assert error.maximum == pytest.approx(0.5)


def test_an_output_that_one_run_lacks_is_named(model):
    r = run(model, 1.0)
    with pytest.raises(SimulationError, match=r"the model has no observable 'mass\.flange\.flwo'"):
        compare(r, r, ["mass.flange.flwo"])
