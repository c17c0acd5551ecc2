"""The spine: warnings are shown by who compiles a model, and stay with it."""

from __future__ import annotations

import warnings

import pytest

import propermodel as pm
from propermodel.compiler import compile_quietly
from tests.faults.structure_cases import Oscillator, TwoRooms


def test_a_sound_model_has_no_warnings():
    assert pm.compile_model(pm.elaborate(Oscillator())).warnings == ()


def test_warnings_point_at_the_line_that_compiles():
    with pytest.warns(pm.ModelWarning) as shown:
        compiled = pm.compile_model(pm.elaborate(TwoRooms()))
    (warning,) = shown
    assert warning.filename == __file__
    assert isinstance(warning.message, pm.ModelWarning)
    assert (warning.message.diagnostic,) == compiled.warnings


def test_a_line_that_compiles_again_and_again_shows_a_warning_once():
    model = pm.elaborate(TwoRooms())
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("default")
        for _ in range(3):
            pm.compile_model(model)
    assert len(shown) == 1


def test_trial_compilations_are_quiet_and_keep_their_warnings():
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        compiled = compile_quietly(pm.elaborate(TwoRooms()))
    assert shown == []
    assert [diagnostic.code for diagnostic in compiled.warnings] == ["structure/disconnected"]


def test_what_removals_bring_about_is_no_reason_to_warn():
    model = pm.elaborate(TwoRooms()).without([pm.ZeroEffort(pm.Path(("left_spring", "port")))])
    assert pm.compile_model(model).warnings == ()


def test_a_reduction_tries_candidates_quietly():
    with pytest.warns(pm.ModelWarning):
        compiled = pm.compile_model(pm.elaborate(TwoRooms()))
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        start = {pm.Path(("left_mass", "momentum")): 1.0, pm.Path(("right", "mass", "momentum")): 0.01}
        run = pm.simulate(compiled, pm.Scenario(stop=2.0, initial=start), step=1e-3)
        refined = pm.simulate(compiled, pm.Scenario(stop=2.0, initial=start), step=5e-4)
        pm.plan_reduction(compiled, run, pm.rank_activity(run, refined=refined), threshold=0.99)
    assert shown == []
