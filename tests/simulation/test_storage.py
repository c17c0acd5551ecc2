"""Trajectories as files."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from propermodel.cli.models import load_subject
from propermodel.compiler import compile_model
from propermodel.diagnostics import DocumentError, parse_path
from propermodel.simulation.simulate import simulate
from propermodel.simulation.storage import load_trajectory, save_trajectory
from propermodel.simulation.trajectory import Trajectory

MODEL = f"{Path(__file__).parents[1] / 'cli' / 'quarter_car.py'}:QuarterCar"


@pytest.fixture(scope="module")
def run() -> Trajectory:
    subject = load_subject(MODEL)
    return simulate(compile_model(subject.model), subject.scenario, step=1e-3)


@pytest.fixture(scope="module")
def file(run: Trajectory, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "run.npz"
    save_trajectory(run, path)
    return path


def test_columns_come_back_as_they_were(run: Trajectory, file: Path):
    stored = load_trajectory(file)
    assert stored.paths == run.paths
    np.testing.assert_array_equal(stored.time, run.time)
    for path in run.paths:
        np.testing.assert_array_equal(stored[path], run[path])
        assert stored.unit(path) == run.unit(path)
    np.testing.assert_array_equal(stored["body.flange.power"], run["body.flange.power"])
    assert stored.unit("body.flange.power") == "W"


def test_model_scenario_and_ending_come_back(run: Trajectory, file: Path):
    stored = load_trajectory(file)
    assert stored.model == run.compiled.model
    assert stored.scenario == run.scenario
    assert stored.ending == run.ending
    assert stored.statistics == run.statistics
    assert (stored.method, stored.step) == (run.method.value, run.step)


def test_integrals_of_power_come_back(run: Trajectory, file: Path):
    stored = load_trajectory(file)
    bond = parse_path("body.flange")
    assert stored.work(bond)[-1] == run.work(bond)
    assert stored.activity(bond)[-1] == run.activity(bond)
    assert len(stored.integral_times) == len(stored.activity(bond)) == 11


def test_some_columns_can_be_chosen(run: Trajectory, tmp_path: Path):
    save_trajectory(run, tmp_path / "some.npz", only=["body.flange.power"])
    stored = load_trajectory(tmp_path / "some.npz")
    assert [str(path) for path in stored.paths] == ["body.flange.effort", "body.flange.flow"]
    with pytest.raises(DocumentError, match=r"no observable 'body.flange.flw'\n  help: did you mean"):
        stored["body.flange.flw"]


def test_nothing_of_the_file_is_a_pickle(file: Path):
    with np.load(file, allow_pickle=False) as archive:
        assert {archive[name].dtype.kind for name in archive.files} == {"f", "u"}
        header = json.loads(archive["header"].tobytes())
    assert (header["format"], header["version"]) == ("propermodel-trajectory", 1)


def _changed(file: Path, target: Path, **changes: object) -> Path:
    with np.load(file) as archive:
        arrays = {name: archive[name] for name in archive.files}
    header = {**json.loads(arrays["header"].tobytes()), **changes}
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(target, **arrays)
    return target


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "another"}, r"its format is 'another', not 'propermodel-trajectory'"),
        ({"version": 2}, r"its version is 2; version 1 is read"),
        ({"columns": [[["a", "b"], "m", 1000]]}, r"its header is damaged: 'columns' is not an array"),
        ({"columns": [[["a", "b"], "m", -1]]}, r"its header is damaged"),
        ({"columns": [["a.b", "m", 0]]}, r"its header is damaged: ''a.b'' is not a list of names"),
        ({"columns": 3}, r"its header is damaged"),
        ({"ending": {}}, r"its header is damaged"),
        ({"powers": []}, r"its header is damaged: 'integrals' is not an array"),
    ],
)
def test_a_changed_header_is_refused(file: Path, tmp_path: Path, changes: dict, message: str):
    with pytest.raises(DocumentError, match=message):
        load_trajectory(_changed(file, tmp_path / "changed.npz", **changes))


def test_other_files_are_refused(tmp_path: Path):
    text = tmp_path / "text.npz"
    text.write_text("not an archive")
    empty = tmp_path / "empty.npz"
    zipfile.ZipFile(empty, "w").close()
    single = tmp_path / "single.npy"
    np.save(single, np.zeros(3))
    for path in (text, empty, single, tmp_path / "missing.npz"):
        with pytest.raises(DocumentError, match=r"cannot be read as a trajectory"):
            load_trajectory(path)
