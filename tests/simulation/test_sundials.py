"""Runs by CVODE behind the same interface, and generated methods against them as independent reference."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from propermodel import Component, Method, Scenario, compile_model, connect, elaborate, energy_balance, simulate
from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Memory, Request, Status
from propermodel.library.mechanics.translation import Friction
from propermodel.simulation.trajectory import RunStatus
from tests.codegen.programs import Draft, implicit, oscillator
from tests.codegen.test_rosenbrock import van_der_pol
from tests.event_parts import BouncingBall
from tests.parts import Fixed, Mass, SpringDamper
from tests.simulation.test_stability import MOVING, Both


def ended(draft: Draft, method: Method, until: float = 2.0, tolerance: float = 1e-9, **asked: float) -> Memory:
    memory = draft.memory()
    machine = build_machine(draft.program(), method)
    request = replace(Request(until=until, step=until, tolerance=tolerance), **asked)  # pyright: ignore[reportArgumentType]
    while (status := machine.run(memory, request).status) is Status.PAUSED:
        pass
    assert status is Status.FINISHED
    return memory


@pytest.mark.parametrize("method", [Method.RODAS, Method.DOPRI5])
@pytest.mark.parametrize(
    ("draft", "until"),
    [(van_der_pol(3.0), 2.0), (oscillator(), 0.3), (implicit(2), 1.0)],
    ids=["limit cycle", "sampled", "block"],
)
def test_generated_methods_agree_with_cvode(draft: Draft, until: float, method: Method) -> None:
    expected = ended(draft, Method.CVODE, until, row_period=0.2)
    found = ended(draft, method, until, row_period=0.2)
    for name in ("state", "integral", "activity", "discrete"):
        exact = getattr(expected, name)
        np.testing.assert_allclose(getattr(found, name), exact, atol=2e-6 * np.abs(exact).max(initial=1e-9))
    np.testing.assert_array_equal(found.samples_taken, expected.samples_taken)


def test_the_fixed_step_of_an_implicit_method_converges_to_cvode() -> None:
    exact = ended(van_der_pol(3.0), Method.CVODE).state
    errors = [np.abs(ended(van_der_pol(3.0), Method.ROS2, step=h).state - exact).max() for h in (4e-3, 2e-3)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("backend", list(Backend))
def test_events_and_rows_are_those_of_other_methods(backend: Backend) -> None:
    ball = compile_model(elaborate(BouncingBall()), backend=backend)
    found = simulate(ball, Scenario(stop=1.5), method=Method.CVODE, tolerance=1e-8, record_every=0.25)
    expected = simulate(ball, Scenario(stop=1.5), method=Method.RK4, step=1e-3, record_every=0.25)
    assert found.ending.is_complete
    assert len(found.events) == len(expected.events) == 2
    for one, other in zip(found.events, expected.events, strict=True):
        assert one.time == pytest.approx(other.time, abs=1e-7)
        assert one.lost == pytest.approx(other.lost, rel=1e-6)
    np.testing.assert_allclose(found.time, expected.time, atol=1e-7)
    np.testing.assert_allclose(found.columns, expected.columns, atol=1e-5)


def test_the_energy_of_a_stiff_model_with_dry_friction_is_that_of_rodas() -> None:
    class Rubbing(Component):
        mass, foot, wall = Mass(mass=2.0), Mass(mass=0.1), Fixed()
        soft, hard = SpringDamper(stiffness=50.0, damping=0.1), SpringDamper(stiffness=1e4, damping=400.0)
        friction = Friction(force=2.0, width=0.01)
        connections = (
            connect(mass.flange, soft.a, friction.a),
            connect(soft.b, foot.flange, hard.a),
            connect(hard.b, friction.b, wall.flange),
        )

    model = compile_model(elaborate(Rubbing()))
    runs = [
        simulate(model, replace(MOVING, stop=3.0), method=method, tolerance=1e-7, record_every=1.0)
        for method in (Method.CVODE, Method.RODAS)
    ]
    expected, found = (run.memory.activity for run in runs)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6 * expected.max())
    assert abs(energy_balance(runs[0]).relative_residual) < 1e-5


def test_a_run_that_cannot_go_on_says_so() -> None:
    draft = Draft()
    calm, wild = draft.state("calm", 1.0), draft.state("wild", 1.0)
    draft.rate(calm, -calm)
    draft.rate(wild, wild * wild)
    memory = draft.memory()
    outcome = build_machine(draft.program(), Method.CVODE).run(memory, Request(until=2.0, step=1.0))
    assert (outcome.status, outcome.index) == (Status.STEP_TOO_SMALL, 1)
    assert outcome.time == pytest.approx(1.0, abs=3e-3)


def test_a_run_tells_its_method_and_tolerance() -> None:
    run = simulate(compile_model(elaborate(Both())), replace(MOVING, stop=1.0), method=Method.CVODE)
    assert run.ending.status is RunStatus.COMPLETED
    assert "steps (cvode, tolerance 0.0001)" in str(run)
