"""A run that is opened again says what it said before."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propermodel as pm
from propermodel.analysis.balance import energy_balance
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import DocumentError
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.reopening import reopened
from propermodel.simulation.simulate import Progress, simulate
from propermodel.simulation.trajectory import Trajectory


@pytest.fixture(scope="module", params=["half-car", "truck"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Trajectory, Trajectory]:
    """A run, and the same from its file."""
    subject = load_subject(request.param)
    scenario = replace(subject.scenario, stop=10.0)
    file = tmp_path_factory.mktemp("runs") / "run.npz"
    run = simulate(
        compile_model(subject.model), scenario, step=1e-3, record_every=0.05, integrals_every=0.5, record_to=file
    )
    return run, reopened(pm.load_trajectory(file))


def test_values_at_both_ends_are_the_same(made: tuple[Trajectory, Trajectory]):
    run, again = made
    assert again.ending == run.ending
    states = [state.path for state in run.compiled.system.states]
    energies = [item.element / "energy" for item in run.compiled.system.energies]
    for path in (*states, *energies):
        assert again.at_start(path) == run.at_start(path)
    for path in run.paths:
        assert again.at_end(path) == pytest.approx(run.at_end(path), rel=1e-12, abs=1e-12)
    np.testing.assert_array_equal(again.memory.activity, run.memory.activity)
    np.testing.assert_array_equal(again.memory.state, run.memory.state)
    np.testing.assert_array_equal(again.memory.discrete, run.memory.discrete)


def test_ranking_balance_and_plan_are_the_same(made: tuple[Trajectory, Trajectory]):
    run, again = made
    ranking = pm.rank_activity(again)
    assert ranking == pm.rank_activity(run)
    assert pm.rank_activity(again, window=(2.0, 6.5)) == pm.rank_activity(run, window=(2.0, 6.5))
    assert energy_balance(again).relative_residual == pytest.approx(energy_balance(run).relative_residual, rel=1e-6)
    plans = [plan_reduction(each.compiled, each, ranking, threshold=0.97) for each in made]
    assert [d.verdict for d in plans[0].decisions] == [d.verdict for d in plans[1].decisions]
    assert plans[0].removals == plans[1].removals


def test_a_run_that_was_stopped_ends_where_its_integrals_do(tmp_path: Path):
    subject = load_subject("half-car")
    compiled: CompiledModel = compile_model(subject.model)
    file = tmp_path / "run.npz"

    def stop(progress: Progress) -> None:
        if progress.time > 3.0:
            raise KeyboardInterrupt

    simulate(compiled, subject.scenario, step=1e-4, record_every=0.05, record_to=file, progress=stop)
    again = reopened(pm.load_trajectory(file))
    end = again.scenario.stop
    assert 3.0 <= end < subject.scenario.stop
    expected = simulate(compiled, replace(subject.scenario, stop=end), step=1e-4, record_every=0.05)
    assert again.activity("heave.flange") == pytest.approx(expected.activity("heave.flange"), rel=1e-9)
    assert "interrupted" in again.ending.message
    assert pm.rank_activity(again).window == (0.0, end)


def test_a_part_of_a_run_is_refused(tmp_path: Path):
    subject = load_subject("half-car")
    run = simulate(compile_model(subject.model), replace(subject.scenario, stop=0.1), step=1e-3)
    pm.save_trajectory(run, tmp_path / "part.npz", only=["heave.flange.flow"])
    with pytest.raises(DocumentError, match="document/partial-run"):
        reopened(pm.load_trajectory(tmp_path / "part.npz"))
