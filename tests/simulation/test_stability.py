"""The largest stable step against closed forms, and what a run says whose step is longer."""

from __future__ import annotations

import math

import pytest

from propermodel import Component, Method, Scenario, compile_model, connect, elaborate, simulate, step_limit
from propermodel.diagnostics import parse_path
from propermodel.simulation.stability import StepLimit
from tests.parts import Damper, Fixed, Mass, Spring, SpringDamper

MOVING = Scenario(stop=100.0, initial={parse_path("mass.flange.flow"): 1.0})


class Slowing(Component):
    """Slows down with 50 1/s."""

    mass, damper, wall = Mass(mass=2.0), Damper(damping=100.0), Fixed()
    connections = (connect(mass.flange, damper.a), connect(damper.b, wall.flange))


class Swinging(Component):
    """Swings with 5 rad/s for ever."""

    mass, spring, wall = Mass(mass=2.0), Spring(stiffness=50.0), Fixed()
    connections = (connect(mass.flange, spring.a), connect(spring.b, wall.flange))


class Both(Component):
    """A stiff and much damped foot under a slow mass."""

    mass, foot, wall = Mass(mass=2.0), Mass(mass=0.1), Fixed()
    soft, hard = SpringDamper(stiffness=50.0, damping=1.0), SpringDamper(stiffness=1e4, damping=400.0)
    connections = (
        connect(mass.flange, soft.a),
        connect(soft.b, foot.flange, hard.a),
        connect(hard.b, wall.flange),
    )


def limit(component: Component, method: Method) -> StepLimit:
    return step_limit(compile_model(elaborate(component)), MOVING, method)


@pytest.mark.parametrize(
    ("method", "share"), [(Method.EULER, 2.0), (Method.SEMI_IMPLICIT, 2.0), (Method.RK4, 2.785293563)]
)
def test_a_decay_limits_the_step(method: Method, share: float) -> None:
    found = limit(Slowing(), method)
    assert found.step == pytest.approx(share / 50.0, rel=1e-2)
    assert found.rate == pytest.approx(-50.0)
    assert str(found.state) == "mass.momentum"


def test_an_oscillation_limits_the_step() -> None:
    found = limit(Swinging(), Method.SEMI_IMPLICIT)
    assert found.step == pytest.approx(2.0 / 5.0, rel=1e-2)
    assert abs(found.rate) == pytest.approx(5.0)
    assert limit(Swinging(), Method.RK4).step == pytest.approx(2.0 * math.sqrt(2.0) / 5.0, rel=1e-2)
    # Euler's method lets it grow by 1 + (5 h)**2 / 2 a step: a thousandfold over 100 s.
    assert limit(Swinging(), Method.EULER).step == pytest.approx(math.log(1e3) / 100.0 * 2.0 / 25.0, rel=1e-2)


def test_the_implicit_method_has_no_limit() -> None:
    found = limit(Both(), Method.ROS2)
    assert math.isinf(found.step)
    assert str(found) == "ros2 is stable with any step here"


@pytest.mark.parametrize("method", [Method.EULER, Method.SEMI_IMPLICIT, Method.RK4])
def test_a_run_below_the_limit_decays_and_one_beyond_it_grows_and_says_so(method: Method) -> None:
    compiled = compile_model(elaborate(Both()))
    at = step_limit(compiled, MOVING, method)
    calm, wild = (
        simulate(compiled, MOVING, method=method, step=share * at.step, record_every=50.0) for share in (0.97, 1.03)
    )
    assert abs(calm.at_end("foot.flange.flow")) < 1e-3
    assert not abs(wild.at_end("foot.flange.flow")) < 1.0
    assert calm.notes == ()
    (note,) = wild.notes
    assert note.startswith(f"a step of {wild.step:g} s is too long at the start: {method} is stable with steps up to")
    assert "foot.momentum has the eigenvalue -3" in note
    assert note.endswith("take a smaller step, or the method ros2 or rodas")
    assert simulate(compiled, MOVING, method=Method.ROS2, step=wild.step, record_every=50.0).notes == ()
