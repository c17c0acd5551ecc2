"""A step that becomes too long during a run is reported, with the time and the element."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import propermodel as pm
from propermodel.codegen.fastest import LONGEST, LOOK_EVERY
from propermodel.codegen.machine import Memory
from propermodel.diagnostics import parse_path
from propermodel.expressions.core import TIME
from propermodel.simulation import step_watch
from tests.parts import Fixed, Mass, Spring

METHODS = pytest.mark.parametrize("method", list(LONGEST))
STEP = 1e-3


class Sticking(pm.Resistance):
    """Sticks from 3 s to 6 s; its force levels off at some speed, so that numbers may chatter without growing."""

    flange = pm.Port(pm.Translation)
    damping: pm.Parameter = pm.parameter("N.s/m")
    width: pm.Parameter = pm.parameter("m/s")

    def effort(self, flow: pm.Expr) -> pm.Expr:
        sticks = pm.where(abs(TIME - pm.quantity(4.5, "s")) < pm.quantity(1.5, "s"), 1.0, 0.0)
        return (pm.quantity(4.0, "N.s/m") + sticks * self.damping) * self.width * pm.tanh(flow / self.width)


class Slider(pm.Component):
    """A mass of 2 kg on a spring, which friction holds for a while."""

    damping: pm.Parameter = pm.parameter("N.s/m", default=0.0)
    width: pm.Parameter = pm.parameter("m/s", default=0.01)

    mass, spring, wall = Mass(mass=2.0), Spring(stiffness=50.0), Fixed()
    friction = Sticking(damping=damping, width=width)

    connections = (
        pm.connect(mass.flange, spring.a, friction.flange),
        pm.connect(spring.b, wall.flange),
    )


def slide(method: pm.Method, rate: float, width: float = 0.01, **options: object) -> pm.Trajectory:
    """A run of 10 s whose fastest mode has this rate from 3 s to 6 s, 1/s, as long as its speed is below the width."""
    compiled = pm.compile_model(pm.elaborate(Slider()))
    scenario = pm.Scenario(
        stop=10.0,
        initial={parse_path("mass.flange.flow"): 0.005},
        parameters={parse_path("damping"): 2.0 * rate, parse_path("width"): width},
    )
    return pm.simulate(compiled, scenario, method=method, step=STEP, **options)  # type: ignore[arg-type]


def assert_notes(run: pm.Trajectory, method: pm.Method) -> None:
    (note,) = run.notes
    found = re.fullmatch(
        rf"a step of 0\.001 s is too long from (\S+) s on: {method} is stable with steps up to (\S+) s here: "
        r"mass\.momentum has the eigenvalue (\S+) 1/s; take a smaller step, or the method ros2 or rodas",
        note,
    )
    assert found is not None, note
    assert 3.0 < float(found[1]) < 6.0
    assert 0.0 < float(found[2]) <= STEP
    assert float(found[3]) < -LONGEST[method] / STEP
    assert note in str(run)


@METHODS
def test_a_mode_that_becomes_too_fast_is_noted_before_numbers_are_large(method: pm.Method) -> None:
    run = slide(method, 1.01 * LONGEST[method] / STEP, width=1e200)
    assert run.ending.is_complete
    assert_notes(run, method)


@pytest.mark.parametrize("method", [pm.Method.EULER, pm.Method.SEMI_IMPLICIT])
def test_friction_that_chatters_is_noted_although_it_is_slow_on_either_side(method: pm.Method) -> None:
    run = slide(method, 1.5 * LONGEST[method] / STEP)
    assert abs(run["mass.flange.flow"]).max() < 0.02
    assert_notes(run, method)


@METHODS
def test_a_step_that_is_short_enough_has_no_note(method: pm.Method) -> None:
    assert slide(method, 0.8 * LONGEST[method] / STEP).notes == ()
    assert slide(pm.Method.ROS2, 1.2 * LONGEST[method] / STEP).notes == ()


def test_the_note_is_in_files_and_in_runs_that_are_continued(tmp_path: Path) -> None:
    too_fast = 3.0 / STEP
    run = slide(pm.Method.EULER, too_fast, record_to=tmp_path / "run.npz")
    pm.save_trajectory(run, tmp_path / "saved.npz")
    for file in ("run.npz", "saved.npz"):
        assert pm.load_trajectory(tmp_path / file).notes == run.notes
    later = pm.simulate(run.compiled, pm.Scenario(stop=12.0), method=run.method, step=STEP, continued_from=run)
    assert later.notes == run.notes


def test_a_model_that_is_too_large_for_its_spectrum_is_watched_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_watch, "MOST_STATES", 1)
    (note,) = slide(pm.Method.RK4, 2.82 / STEP, width=1e200).notes
    assert "in which mass.momentum has the largest part, has an eigenvalue of the size" in note
    assert slide(pm.Method.RK4, 2.7 / STEP, width=1e200).notes == ()


def test_a_suspicion_that_is_not_confirmed_is_followed_by_a_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    def refuse(_: object, memory: Memory, *__: object) -> None:
        asked.append(memory.time)

    monkeypatch.setattr(step_watch, "limit_below", refuse)
    monkeypatch.setattr(step_watch, "FIRST_REST", 2)
    assert slide(pm.Method.EULER, 3.0 / STEP).notes == ()
    # While it sticks: 3000 steps with looks every 256 of them, of which 2, 4, ... are left out.
    assert 2 <= len(asked) <= 3
    assert asked[1] - asked[0] >= 2 * LOOK_EVERY * STEP
