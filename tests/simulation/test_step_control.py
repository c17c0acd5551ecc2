"""Runs that choose their steps: events, integrals, standstill, designs, continuation, choosing a method, failures."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from propermodel import (
    Backend,
    Component,
    Method,
    Resistance,
    Scenario,
    compile_model,
    connect,
    designs,
    elaborate,
    energy_balance,
    load_trajectory,
    parameter,
    rank_activity,
    save_trajectory,
    sensitivities,
    simulate,
    simulate_many,
)
from propermodel.diagnostics import SimulationError, parse_path
from propermodel.expressions import Expr
from propermodel.library.mechanics.translation import Friction
from propermodel.modelling import Parameter, Port, Translation
from propermodel.simulation.trajectory import RunStatus
from tests.event_parts import BouncingBall
from tests.parts import Damper, Fixed, Mass, Spring
from tests.simulation.test_stability import MOVING, Both, Swinging

ADAPTIVE = pytest.mark.parametrize("method", [Method.RODAS, Method.DOPRI5])
GRAVITY = 10.0


class Sliding(Component):
    """A block of 2 kg on the floor, pulled at the end of a spring; at rest its eigenvalue is -3000 1/s."""

    block, spring, damper, wall = Mass(mass=2.0), Spring(stiffness=200.0), Damper(damping=2.0), Fixed()
    friction = Friction(force=6.0, width=1e-3)
    connections = (
        connect(block.flange, spring.a, damper.a, friction.a),
        connect(spring.b, damper.b, friction.b, wall.flange),
    )


@ADAPTIVE
@pytest.mark.parametrize("backend", list(Backend))
def test_events_are_located_to_the_tolerance_of_the_steps(backend: Backend, method: Method) -> None:
    ball = compile_model(elaborate(BouncingBall()), backend=backend)
    run = simulate(ball, Scenario(stop=3.0), method=method, tolerance=1e-8, record_every=0.5)
    assert run.ending.is_complete
    # Free fall is a polynomial of degree two, which every method follows exactly.
    at, speed = math.sqrt(2.0 / GRAVITY), math.sqrt(2.0 * GRAVITY)
    for event in run.events:
        assert event.time == pytest.approx(at, abs=1e-9)
        speed *= 0.8
        at += 2.0 * speed / GRAVITY
    assert len(run.events) > 5
    assert run.statistics.steps < 200


@ADAPTIVE
def test_work_and_activity_are_as_accurate_as_the_tolerance(method: Method) -> None:
    model = compile_model(elaborate(Both()))
    exact = simulate(model, MOVING, method=method, tolerance=1e-9, record_every=5.0)
    total = exact.memory.activity.sum()
    for tolerance in (1e-3, 1e-5):
        run = simulate(model, MOVING, method=method, tolerance=tolerance, record_every=5.0)
        assert abs(energy_balance(run).relative_residual) < 10.0 * tolerance
        assert np.abs(run.memory.activity - exact.memory.activity).max() < 10.0 * tolerance * total


def test_a_stop_costs_no_more_than_driving() -> None:
    model = compile_model(elaborate(Sliding()))
    # It swings for some seconds, then friction holds it.
    scenario = Scenario(stop=4.0, initial={parse_path("block.flange.flow"): 5.0})
    still = replace(scenario, stop=40.0)

    def steps(method: Method) -> tuple[float, float]:
        moving = simulate(model, scenario, method=method, record_every=1.0)
        standing = simulate(model, still, method=method, record_every=1.0, continued_from=moving)
        assert abs(standing.at_end("block.flange.flow")) < 1e-3
        return moving.statistics.steps / 4.0, (standing.statistics.steps - moving.statistics.steps) / 36.0

    moving, standing = steps(Method.RODAS)
    assert standing < 0.2 * moving
    # An explicit method follows the slope of the force at rest, 3000 1/s.
    moving, standing = steps(Method.DOPRI5)
    assert standing > 500.0


@ADAPTIVE
def test_every_design_chooses_its_own_steps(method: Method) -> None:
    model = compile_model(elaborate(Both()))
    sets = designs(replace(MOVING, stop=2.0), {"soft.spring.stiffness": [50.0, 500.0, 5e4]})
    together = simulate_many(model, sets, method=method, tolerance=1e-5, threads=2)
    assert together.lanes == 1
    for k, scenario in enumerate(sets):
        alone = simulate_many(model, [scenario], method=method, tolerance=1e-5)
        np.testing.assert_array_equal(together.final[k], alone.final[0])
        np.testing.assert_array_equal(together.activities[k], alone.activities[0])


@ADAPTIVE
def test_a_run_that_is_continued_keeps_its_step(method: Method, tmp_path: FilePath) -> None:
    model = compile_model(elaborate(Swinging()))
    whole = simulate(model, replace(MOVING, stop=20.0), method=method, tolerance=1e-6, record_every=10.0)
    first = simulate(model, replace(MOVING, stop=10.0), method=method, tolerance=1e-6, record_every=10.0)
    second = simulate(
        model, replace(MOVING, stop=20.0), method=method, tolerance=1e-6, record_every=10.0, continued_from=first
    )
    np.testing.assert_array_equal(second.memory.state, whole.memory.state)
    assert second.statistics == replace(
        second.statistics, steps=whole.statistics.steps, rejected=whole.statistics.rejected
    )
    save_trajectory(second, tmp_path / "run.npz")
    stored = load_trajectory(tmp_path / "run.npz")
    assert (stored.method, stored.tolerance) == (method, 1e-6)
    assert stored.statistics.rejected == second.statistics.rejected


def test_a_ranking_is_checked_with_a_finer_tolerance() -> None:
    model = compile_model(elaborate(Both()))
    run = simulate(model, MOVING, method=Method.RODAS, tolerance=1e-3)
    finer = run.stepping.refined()
    assert (finer.method, finer.tolerance) == (Method.RODAS, 1e-4)
    refined = simulate(model, MOVING, method=finer.method, step=finer.step, tolerance=finer.tolerance)
    ranking = rank_activity(run, refined=refined)
    assert "at a tolerance of 0.0001 instead of 0.001" in str(ranking)
    assert ranking.discretisation is not None
    assert ranking.discretisation.largest_change_points < 0.1


# -- the choice -----------------------------------------------------------------------------------------


def test_a_stiff_model_gets_the_implicit_method_and_is_told_why() -> None:
    run = simulate(compile_model(elaborate(Both())), MOVING, method="auto", record_every=10.0)
    assert run.method is Method.RODAS
    (note,) = run.notes
    assert note.startswith("method auto chose rodas, tolerance 0.0001: in the first 2 s the error allows steps of ")
    assert "foot.momentum has the eigenvalue" in note
    assert note.endswith("the model is stiff")


def test_a_smooth_model_gets_the_explicit_method_and_is_told_why() -> None:
    run = simulate(compile_model(elaborate(Swinging())), MOVING, method="auto", tolerance=1e-6, record_every=10.0)
    assert run.method is Method.DOPRI5
    (note,) = run.notes
    assert note.startswith("method auto chose dopri5, tolerance 1e-06: in the first 2 s the error allows steps of ")
    assert "has the eigenvalue 0 +- 5i 1/s" in note
    assert note.endswith("the model is not stiff")
    assert run.at_end("mass.flange.flow") == pytest.approx(math.cos(500.0), abs=1e-2)


def test_a_run_that_is_continued_keeps_what_was_chosen() -> None:
    model = compile_model(elaborate(Both()))
    first = simulate(model, MOVING, method="auto")
    second = simulate(model, replace(MOVING, stop=110.0), method="auto", continued_from=first)
    assert second.method is first.method
    assert second.notes == first.notes


# -- what goes wrong ------------------------------------------------------------------------------------


class Runaway(Resistance):
    """Pushes the more the faster it moves."""

    port = Port(Translation)
    factor: Parameter = parameter("N.s2/m2", default=1.0)

    def effort(self, flow: Expr) -> Expr:
        """The force."""
        return -self.factor * flow * abs(flow)


@ADAPTIVE
def test_a_solution_without_end_is_told_with_its_state(method: Method) -> None:
    class Escaping(Component):
        mass, push = Mass(mass=1.0), Runaway()
        connections = (connect(mass.flange, push.port),)

    run = simulate(compile_model(elaborate(Escaping())), replace(MOVING, stop=3.0), method=method)
    assert run.ending.status is RunStatus.FAILED
    assert run.ending.time == pytest.approx(1.0, abs=1e-3)
    assert run.ending.message.startswith("stopped at 1 s: no step is short enough for the tolerance")
    assert str(run.ending.path) == "mass.momentum"


def test_numbers_that_grow_because_of_the_step_are_explained_where_it_becomes_too_long() -> None:
    found = simulate(compile_model(elaborate(Both())), replace(MOVING, stop=20.0), method=Method.RK4, step=1e-3)
    assert found.ending.status is RunStatus.FAILED
    assert "rk4 is stable with steps up to" in found.ending.message
    assert "foot.momentum has the eigenvalue" in found.ending.message
    assert found.ending.message.endswith("take a smaller step, or the method ros2 or rodas")


@pytest.mark.parametrize("method", [Method.RODAS, "auto"])
def test_sensitivities_ask_for_steps_that_stay(method: Method) -> None:
    with pytest.raises(SimulationError, match="sensitivities are derivatives of steps that stay"):
        sensitivities(compile_model(elaborate(Both())), MOVING, parameters=["mass.mass"], method=method)
