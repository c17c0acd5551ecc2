"""Extremes between recorded rows: in memory, in files, in overviews and around events."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propermodel as pm
from propermodel.diagnostics import DocumentError, SimulationError
from propermodel.expressions.core import TIME
from propermodel.simulation import run_writer
from propermodel.simulation.overview import Overview
from tests.event_parts import BouncingBall
from tests.parts import Mass

STEP = 1e-3
FORCE = "kick.flange.effort"
SPEED = "mass.flange.flow"


class Kick(pm.EffortSource):
    """Pushes back and forth, and kicks once, after a single step."""

    flange = pm.Port(pm.Translation)

    def effort(self) -> pm.Expr:
        seconds = TIME / pm.quantity(1.0, "s")
        kick = pm.where(abs(seconds - 0.537) < 0.4 * STEP, 100.0, 0.0)
        return (pm.sin(3.0 * seconds) + kick) * pm.quantity(1.0, "N")


class Kicked(pm.Component):
    mass = Mass(mass=2.0)
    kick = Kick()

    connections = (pm.connect(mass.flange, kick.flange),)


@pytest.fixture(scope="module")
def compiled() -> pm.CompiledModel:
    return pm.compile_model(pm.elaborate(Kicked()))


def run(compiled: pm.CompiledModel, **options: object) -> pm.Trajectory:
    given = {"method": pm.Method.RK4, "step": STEP, "record_every": 0.1, "record_extremes": True, **options}
    return pm.simulate(compiled, pm.Scenario(stop=1.25), **given)  # type: ignore[arg-type]


def assert_same(one: Overview, other: Overview) -> None:
    for name in ("time", "least", "greatest"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_kick_of_one_step_survives_coarse_rows(compiled: pm.CompiledModel):
    kicked = run(compiled)
    assert kicked[FORCE].max() < 1.1
    seen = kicked.extremes(FORCE)
    # One interval between every two rows, and one from the last row to the end.
    np.testing.assert_array_equal(seen.time, kicked.time)
    assert len(seen.time) == 13
    assert np.flatnonzero(seen.greatest > 1.1).tolist() == [5]
    every = run(compiled, record_every=STEP, record_extremes=False)
    assert seen.greatest.max() == pytest.approx(every[FORCE].max(), rel=1e-12)
    for begin, end, low, high in zip(kicked.time, [*kicked.time[1:], 1.25], seen.least, seen.greatest, strict=True):
        inside = every[FORCE][(every.time > begin - 1e-9) & (every.time < end + 1e-9)]
        assert (low, high) == pytest.approx((inside.min(), inside.max()), rel=1e-9, abs=1e-12)


def test_an_overview_shows_what_rows_do_not(compiled: pm.CompiledModel):
    for points in (1, 4, 1000):
        assert run(compiled).overview(FORCE, points=points).greatest.max() > 100.0
        assert run(compiled, record_extremes=False).overview(FORCE, points=points).greatest.max() < 1.1
    # The interval in which the window begins is seen as a whole.
    assert run(compiled).overview(FORCE, 0.55, 0.58).greatest.max() > 100.0
    assert run(compiled).overview(FORCE, 0.61, 2.0).greatest.max() < 1.1


@pytest.mark.parametrize("record_every", [0.1, 2e-3])
def test_a_file_holds_the_extremes_of_a_run_in_memory(
    compiled: pm.CompiledModel, tmp_path: Path, record_every: float, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(run_writer, "CHUNK_BYTES", 2**10)
    kept = run(compiled, record_every=record_every)
    recorded = run(compiled, record_every=record_every, record_to=tmp_path / "run.npz")
    pm.save_trajectory(kept, tmp_path / "saved.npz", only=[SPEED, FORCE])
    for found in (recorded, pm.load_trajectory(tmp_path / "run.npz"), pm.load_trajectory(tmp_path / "saved.npz")):
        for path in (FORCE, SPEED):
            assert_same(found.extremes(path), kept.extremes(path))
            for window in ((), (0.2, 0.9)):
                seen = found.overview(path, *window, points=3), kept.overview(path, *window, points=3)
                assert (seen[0].least.min(), seen[0].greatest.max()) == (seen[1].least.min(), seen[1].greatest.max())
    without = run(compiled, record_extremes=False, record_to=tmp_path / "run.npz")
    with pytest.raises(DocumentError, match=r"holds no extremes of 'kick.flange.effort' between rows"):
        pm.load_trajectory(tmp_path / "run.npz").extremes(FORCE)
    with pytest.raises(SimulationError, match=r"extremes of 'kick.flange.effort' between rows were not recorded"):
        without.extremes(FORCE)


@pytest.mark.parametrize("method", [pm.Method.RODAS, pm.Method.DOPRI5])
def test_methods_that_control_their_steps_look_after_each(compiled: pm.CompiledModel, method: pm.Method):
    """The speed under - sin 3t is (cos 3t - 1) / 6, least between the rows at 0.8 s and 1.6 s."""
    seen = run(compiled, method=method, step=0.01, record_every=0.8).extremes(SPEED)
    assert seen.least[1] == pytest.approx(-1.0 / 3.0, abs=2e-4)


def test_a_run_that_is_continued_begins_a_new_interval(compiled: pm.CompiledModel):
    first = pm.simulate(compiled, pm.Scenario(stop=0.45), step=STEP, record=[SPEED], record_extremes=True)
    rest = run(compiled, method=first.method, continued_from=first)
    assert first.extremes(SPEED).time[-1] == pytest.approx(0.4)
    seen = rest.extremes(FORCE)
    assert seen.time[:2] == pytest.approx([0.45, 0.5])
    assert seen.greatest[1] > 100.0


@pytest.mark.parametrize("backend", pm.Backend)
def test_events_end_intervals_as_rows_do(backend: pm.Backend):
    compiled = pm.compile_model(pm.elaborate(BouncingBall()), backend=backend)
    ball = pm.simulate(compiled, pm.Scenario(stop=0.7), step=STEP, record_every=0.5, record_extremes=True)
    speed = "ball.flange.flow"
    assert len(ball.events) == 1
    seen, rows = ball.extremes(speed), ball[speed]
    # Rows at 0 s, on either side of the impact and at 0.5 s; then to the end.
    np.testing.assert_array_equal(seen.time, ball.time)
    np.testing.assert_array_equal(seen.least[:3], np.minimum(rows[:-1], rows[1:]))
    np.testing.assert_array_equal(seen.greatest[:3], np.maximum(rows[:-1], rows[1:]))
    height = ball.extremes("height.height")
    assert height.greatest[0] == 1.0
    assert abs(height.least[0]) < 1e-9
