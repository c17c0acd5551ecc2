"""Two-ports that cannot be turned round, found before anything is simulated."""

from __future__ import annotations

import propermodel as pm
from examples.slider_crank import SliderCrank, run
from propermodel.analysis.tolerances import Tolerance
from propermodel.diagnostics import parse_path
from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.divisions import divisions_by_zero
from propermodel.reduction.proposals import Proposed
from propermodel.reduction.trials import Trials

DRIVE = parse_path("drive")


def without_flywheel(model: pm.Model) -> pm.CompiledModel:
    return pm.compile_model(model.without([pm.ZeroEffort(parse_path("flywheel.shaft"))]))


def test_a_crank_does_not_follow_its_piston_through_a_dead_centre():
    model = pm.elaborate(SliderCrank())
    assert divisions_by_zero(without_flywheel(model), [run(model)]) == (DRIVE,)


def test_between_dead_centres_it_does():
    model = pm.elaborate(SliderCrank())
    quarter = pm.Scenario(
        stop=0.02, inputs={parse_path("torque"): 2.0}, initial={parse_path("sensor.counter.turned"): 0.6}
    )
    between = pm.simulate(pm.compile_model(model), quarter, method=pm.Method.RK4, step=1e-4)
    assert divisions_by_zero(without_flywheel(model), [between]) == ()


def test_a_model_that_keeps_its_strokes_divides_by_nothing():
    model = pm.elaborate(SliderCrank())
    smaller = pm.compile_model(model.without([pm.ZeroEffort(parse_path("bearing.shaft"))]))
    assert divisions_by_zero(smaller, [run(model)]) == ()


def test_a_search_refuses_it_by_name():
    full_run = run(pm.elaborate(SliderCrank()))
    output = {parse_path("piston.flange.flow"): Tolerance(rms=0.1)}
    trials = Trials(full_run.compiled, (full_run.scenario,), output, full_run, None, None)
    choice = {parse_path("flywheel"): (pm.ZeroEffort(parse_path("flywheel.shaft")),)}
    refused = trials.prepare(Proposed(choice, 0.5))
    assert isinstance(refused, Candidate)
    assert refused.verdict is Verdict.REFUSED
    assert refused.why == "it would divide by the modulus of drive, which passes zero"
