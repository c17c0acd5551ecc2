"""Variables of elements that a model does without: recovered by formula or integral, or refused with the reason."""

from __future__ import annotations

import numpy as np
import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from propermodel.diagnostics import parse_path
from propermodel.library.mechanics.translation import Fixed, Mass, Spring
from tests.physics.systems import Push, system

RK4 = pm.Method.RK4


def run_without(*removals: pm.Removal, record: list[str] | None = None) -> pm.Trajectory:
    model = pm.elaborate(QuarterCar()).without(removals)
    return pm.simulate(pm.compile_model(model), scenario(), method=RK4, step=1e-3, record=record, record_every=2e-3)


WHEEL, TYRE = parse_path("wheel.flange"), parse_path("tyre.spring.port")


def test_a_mass_that_is_left_out_still_has_a_velocity_and_its_momentum():
    run = run_without(pm.ZeroEffort(WHEEL))
    np.testing.assert_allclose(run["wheel.momentum"], 80.0 * run["wheel.flange.flow"], rtol=1e-12, atol=1e-12)
    assert np.ptp(run["wheel.flange.flow"]) > 0.1
    assert not run["wheel.flange.effort"].any()


def test_a_rigid_spring_shows_its_force_and_what_that_would_compress():
    run = run_without(pm.ZeroFlow(TYRE))
    force = run["tyre.spring.port.effort"]
    assert np.ptp(force) > 1000.0
    np.testing.assert_allclose(run["tyre.spring.displacement"], force / 2.4e5, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("removal", [pm.ZeroEffort(TYRE), pm.ConstantEffort(TYRE, 50.0)])
def test_a_compliance_with_a_prescribed_effort_has_the_integral_of_its_flow(removal: pm.Removal):
    run = run_without(removal)
    length = run["tyre.spring.displacement"]
    assert np.ptp(length) > 0.01
    np.testing.assert_allclose(np.gradient(length, run.time)[2:-2], run["tyre.spring.port.flow"][2:-2], atol=1e-4)
    assert np.array_equal(run["tyre.spring.port.displacement"], length)
    assert run.at_end("tyre.spring.displacement") == length[-1]
    assert run.at_start("tyre.spring.displacement") == length[0] == 0.0


def test_the_length_of_a_spring_with_constant_force_in_closed_form():
    push, mass, spring, wall = Push(force=5.0), Mass(mass=2.0), Spring(stiffness=10.0), Fixed()
    model = pm.elaborate(
        system(
            pm.connect(wall.flange, spring.a),
            pm.connect(spring.b, mass.flange, push.flange),
            push=push,
            mass=mass,
            spring=spring,
            wall=wall,
        )
    )
    full = pm.compile_model(model)
    begin = pm.Scenario(stop=3.0, initial={parse_path("spring.displacement"): 0.25})  # pyright: ignore[reportArgumentType]
    sense = np.sign(pm.simulate(full, pm.Scenario(stop=0.1), method=RK4, step=1e-3)["spring.port.flow"][-1])
    reduced = pm.compile_model(model.without([pm.ConstantEffort(parse_path("spring.port"), 1.0)]))
    run = pm.simulate(reduced, begin, method=RK4, step=1e-3)
    # The spring's force of 1 N acts against or with the push, as the spring is compressed or stretched by it.
    acceleration = (5.0 - sense) / 2.0
    expected = 0.25 + sense * 0.5 * acceleration * run.time**2
    np.testing.assert_allclose(run["spring.displacement"], expected, rtol=1e-5, atol=1e-6)


def test_what_is_recorded_for_an_integral_is_enough_for_it():
    removal = pm.ZeroEffort(TYRE)
    run = run_without(removal, record=["tyre.spring.displacement"])
    assert "tyre.spring.displacement" in run
    assert "wheel.flange.flow" not in run
    assert np.array_equal(run["tyre.spring.displacement"], run_without(removal)["tyre.spring.displacement"])


def test_what_follows_from_nothing_is_refused_with_the_removal_to_blame():
    run = run_without(pm.ZeroEffort(TYRE))
    with pytest.raises(pm.ProperModelError) as caught:
        run["tyre.spring.energy"]
    assert str(caught.value).splitlines()[0] == (
        "error[reduction/not-recovered]: 'tyre.spring.energy' belongs to tyre.spring, which this model does without "
        "(no effort at tyre.spring.port), and it stores nothing any more"
    )
    assert "tyre.spring.port.flow" in str(caught.value)
    with pytest.raises(pm.ProperModelError, match="does without"):
        run_without(pm.ZeroEffort(TYRE), record=["tyre.spring.energy"])
    assert "tyre.spring.energy" not in run


def test_a_misspelt_name_is_still_a_misspelt_name():
    run = run_without(pm.ZeroEffort(TYRE))
    with pytest.raises(pm.ProperModelError, match=r"did you mean 'body\.flange\.flow'"):
        run["body.flange.flo"]


def test_designs_side_by_side_have_the_same_integrals():
    model = pm.elaborate(QuarterCar()).without([pm.ZeroEffort(TYRE)])
    compiled = pm.compile_model(model)
    scenarios = pm.designs(scenario(), {"body.mass": [1000.0, 1200.0]})
    many = pm.simulate_many(
        compiled, scenarios, method=RK4, step=1e-3, record=["tyre.spring.displacement"], record_every=2e-3
    )
    alone = run_without(pm.ZeroEffort(TYRE))["tyre.spring.displacement"]
    np.testing.assert_allclose(many["tyre.spring.displacement"][1], alone, rtol=1e-12, atol=1e-15)
    assert many.at_end("tyre.spring.displacement")[1] == pytest.approx(alone[-1])


def test_an_element_that_others_leave_idle_is_told_as_such():
    run = run_without(pm.ZeroFlow(TYRE))  # which the damper beside it cannot feel any more
    with pytest.raises(pm.ProperModelError) as caught:
        run["tyre.damper.port.displacement"]
    assert "tyre.damper, which this model does without (the removals leave it nothing to act on)" in str(caught.value)
