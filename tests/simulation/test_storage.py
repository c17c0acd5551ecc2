"""Trajectories as files."""

import io
import json
import math
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from propermodel.catalogue.finding import load_subject
from propermodel.compiler import compile_model
from propermodel.diagnostics import DocumentError, parse_path
from propermodel.diagnostics import Path as Path_
from propermodel.modelling.limits import Limits
from propermodel.simulation.archive_writer import ArchiveWriter
from propermodel.simulation.simulate import simulate
from propermodel.simulation.storage import load_trajectory, save_trajectory
from propermodel.simulation.trajectory import Ending, EventRecord, RunStatus, Trajectory
from tests.strangers import changed_documents, damaged_bytes

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
    assert (header["format"], header["version"]) == ("propermodel-trajectory", 2)


def _arrays(file: Path) -> dict[str, np.ndarray]:
    with np.load(file) as archive:
        return {name: archive[name] for name in archive.files}


def _written(target: Path, arrays: dict[str, np.ndarray], *, is_packed: bool = True) -> Path:
    with target.open("wb") as stream:
        writer = ArchiveWriter(stream, is_packed=is_packed)
        for name, array in arrays.items():
            writer.add(name, array)
        writer.finish()
    return target


def _changed(file: Path, target: Path, part: str = "header", **changes: object) -> Path:
    arrays = _arrays(file)
    document = {**json.loads(arrays[part].tobytes()), **changes}
    arrays[part] = np.frombuffer(json.dumps(document).encode(), dtype=np.uint8)
    return _written(target, arrays)


@pytest.mark.parametrize(
    ("changes", "where", "message"),
    [
        ({"format": "another"}, "", r"expected a document of format 'propermodel-trajectory'; its format is 'another'"),
        ({"version": 1}, "", r"the version of this propermodel-trajectory document is 1; version 2 is read"),
        ({"columns": [[["a", "b"], "m", 1000]]}, "columns", r"expected at least 1001 columns of signals, found \d+"),
        ({"columns": [[["a", "b"], "m", -1]]}, "columns[0][2]", r"expected a count, found the number -1"),
        ({"columns": [["a.b", "m", 0]]}, "columns[0][0]", r"expected a list, found the text 'a.b'"),
        ({"columns": 3}, "columns", r"expected a list, found the number 3"),
        ({"powers": []}, "integrals", r"expected arrays of 1 columns of numbers, found one of \(11, \d+\)"),
        ({"scenario": {}}, "scenario", r"expected a document of format 'propermodel-scenario'"),
        ({"notes": [1]}, "notes[0]", r"expected text, found the number 1"),
    ],
)
def test_a_changed_header_is_refused(file: Path, tmp_path: Path, changes: dict, where: str, message: str):
    with pytest.raises(DocumentError, match=message) as caught:
        load_trajectory(_changed(file, tmp_path / "changed.npz", **changes))
    fault, *_ = caught.value.diagnostics
    assert (Path(fault.source.file).name, fault.where) == ("changed.npz", where)


@pytest.mark.parametrize(
    ("changes", "where", "message"),
    [
        ({"ending": {}}, "progress/0.ending", r"the entry 'status' is missing"),
        ({"statistics": 1}, "progress/0.statistics", r"expected an object, found the number 1"),
        ({"time": "later"}, "progress/0.time", r"expected a number, found the text 'later'"),
    ],
)
def test_a_changed_ending_is_refused(file: Path, tmp_path: Path, changes: dict, where: str, message: str):
    with pytest.raises(DocumentError, match=message) as caught:
        load_trajectory(_changed(file, tmp_path / "changed.npz", "progress/0", **changes))
    assert where in [fault.where for fault in caught.value.diagnostics]


def test_notes_events_and_tables_that_were_left_come_back(run: Trajectory, tmp_path: Path):
    started = simulate(run.compiled, run.scenario, step=1e-3, start="equilibrium")
    told = replace(
        started,
        events=(
            EventRecord(0.5, parse_path("stop"), 2.0, 1.5),
            EventRecord(0.75, Path_(("a.b", "c")), math.inf, -math.inf),
        ),
    )
    save_trajectory(told, tmp_path / "told.npz")
    stored = load_trajectory(tmp_path / "told.npz")
    assert stored.notes == told.notes
    assert stored.notes
    assert stored.events == told.events
    assert stored.outside_tables == told.outside_tables


def test_energies_of_a_failed_run_come_back(run: Trajectory, tmp_path: Path):
    failed = replace(
        run,
        events=(EventRecord(0.5, parse_path("stop"), 2.0, math.nan),),
        ending=Ending(RunStatus.FAILED, "a number is not finite", 0.5, parse_path("body")),
    )
    save_trajectory(failed, tmp_path / "failed.npz")
    stored = load_trajectory(tmp_path / "failed.npz")
    assert stored.ending == failed.ending
    assert math.isnan(stored.events[0].energy_after)


def test_other_files_are_refused(tmp_path: Path):
    text = tmp_path / "text.npz"
    text.write_text("not an archive")
    empty = tmp_path / "empty.npz"
    zipfile.ZipFile(empty, "w").close()
    single = tmp_path / "single.npy"
    np.save(single, np.zeros(3))
    for path in (text, empty, single):
        with pytest.raises(DocumentError, match=r"error\[document/archive\]: the file cannot be read as a trajectory"):
            load_trajectory(path)
    for path, reason in ((tmp_path / "missing.npz", "No such file"), (tmp_path, "it is a folder")):
        with pytest.raises(DocumentError, match=rf"error\[document/file\]: the file cannot be read: {reason}"):
            load_trajectory(path)


# -- files from strangers -------------------------------------------------------------------------------------


def _members(file: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(file) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _packed(target: Path, members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(target, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return target


def _npy(array: np.ndarray, **options: bool) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def refused(path: Path, **options: Limits) -> str:
    with pytest.raises(DocumentError) as caught:
        load_trajectory(path, **options)
    assert f"--> {path.name}" in str(caught.value)
    return str(caught.value)


def test_the_size_is_known_before_anything_is_unpacked(file: Path, tmp_path: Path):
    zeros = _npy(np.zeros((2**10, 2**13), order="F"))  # packed into 64 kB
    bomb = _packed(tmp_path / "bomb.npz", {**_members(file), "signals/1.npy": zeros})
    del zeros
    assert bomb.stat().st_size < 2**18
    tracemalloc.start()
    message = refused(bomb, limits=Limits(trajectory_bytes=2**20))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert "error[document/size]: the file unpacks to more than 1048576 bytes" in message
    assert "limits=pm.Limits(trajectory_bytes=...)" in message
    assert peak < 2**20


def test_a_member_that_is_larger_than_it_tells_is_not_unpacked(file: Path, tmp_path: Path):
    members = _members(file)
    told = len(members["signals/0.npy"])
    path = _packed(tmp_path / "liar.npz", {**members, "signals/0.npy": members["signals/0.npy"] + bytes(10**7)})
    data = bytearray(path.read_bytes())
    claims = (told + 10**7).to_bytes(4, "little")
    while (at := data.find(claims)) >= 0:
        data[at : at + 4] = told.to_bytes(4, "little")
    path.write_bytes(data)
    stored = load_trajectory(path)
    with pytest.raises(DocumentError, match="'signals/0' has another size than it tells"):
        stored["body.flange.flow"]


def test_greater_limits_are_for_files_that_are_trusted(file: Path):
    assert "more than 1000 bytes" in refused(file, limits=Limits(trajectory_bytes=1000))
    assert "more than 2 parts" in refused(file, limits=Limits(trajectory_parts=2))
    assert "at most 500 are read" in refused(file, limits=Limits(file_bytes=500))
    assert "at most 50 are read" in refused(file, limits=Limits(values=50))
    assert load_trajectory(file, limits=Limits(trajectory_bytes=2**40)).paths


def test_pickled_arrays_are_not_loaded(file: Path, tmp_path: Path):
    class Trap:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "executed",))

    pickled = _npy(np.array([Trap()], dtype=object), allow_pickle=True)
    message = refused(_packed(tmp_path / "pickled.npz", {**_members(file), "signals/0.npy": pickled}))
    assert "'signals/0' is no array of numbers" in message
    assert not (tmp_path / "executed").exists()


def test_arrays_of_other_kinds_and_sizes_are_refused(file: Path, tmp_path: Path):
    members = _members(file)
    rows = members["signals/0.npy"]
    for data, reason in (
        (_npy(np.array(["a"])), "'signals/0' is no array of numbers"),
        (_npy(np.zeros(3, dtype=np.float32)), "'signals/0' is no array of numbers"),
        (_npy(np.zeros(3, dtype=np.uint8)), "columns of signals"),
        (_npy(np.zeros((3, 3, 99))), "expected arrays of"),
        (_npy(np.zeros((0, 999))), "expected arrays of"),
        (rows[:-8], "'signals/0' has another size than its shape tells"),
        (rows + b"1", "'signals/0' has another size than its shape tells"),
        (rows.replace(b"(101,", b"(-01,"), "'signals/0' is no array of numbers"),
        (rows.replace(b"'fortran_order': True", b"'fortran_order': 1000"), "'signals/0' is no array of numbers"),
        (b"\x93NUMPY\x01\x00\xff\xff" + bytes(1000), "'signals/0' is no array of numbers"),
        (b"1234567890" + bytes(200), "'signals/0' is no array of numbers"),
    ):
        assert reason in refused(_packed(tmp_path / "other.npz", {**members, "signals/0.npy": data})), reason


def test_parts_that_are_missing_or_not_known_are_refused(file: Path, tmp_path: Path):
    arrays = _arrays(file)
    rows = arrays["signals/0"]
    renamed = {("signals/1" if name == "signals/0" else name): array for name, array in arrays.items()}
    first, last = arrays["header"], arrays["progress/0"]
    for parts, reason in (
        (renamed, "'signals/0' is missing"),
        ({"header": first, "others/0": rows, "progress/0": last}, "it holds 'others', which is not known"),
        ({"header": first, "signals.2/0": rows, "progress/0": last}, "it holds 'signals.2', which is not known"),
        ({"header": first, "progress/1": last}, "'progress/0' is missing"),
        ({"progress/0": last}, "it has no header"),
        ({"header": rows}, "'header' is no text"),
    ):
        assert reason in refused(_written(tmp_path / "parts.npz", parts))


def test_archives_of_other_programs_are_refused(file: Path, tmp_path: Path):
    members = _members(file)
    assert "made by another program" in refused(_packed(tmp_path / "lzma.npz", members, zipfile.ZIP_LZMA))
    np.savez(tmp_path / "numpy.npz", time=np.zeros(3))
    assert "made by another program" in refused(tmp_path / "numpy.npz")
    encrypted = bytearray(file.read_bytes())
    encrypted[encrypted.find(b"PK\x03\x04") + 6] |= 1
    (tmp_path / "encrypted.npz").write_bytes(encrypted)
    assert "encrypted" in refused(tmp_path / "encrypted.npz")


def test_a_finished_file_with_a_changed_part_is_no_shorter_run(run: Trajectory, file: Path, tmp_path: Path):
    data = bytearray(file.read_bytes())
    data[data.find(b"PK\x03\x04", 4)] ^= 1
    (tmp_path / "changed.npz").write_bytes(data)
    assert "a part of it has been changed" in refused(tmp_path / "changed.npz")


@given(st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_bytes_are_refused_or_make_no_difference(
    run: Trajectory, file: Path, tmp_path: Path, data: st.DataObject
):
    original = file.read_bytes()
    damaged = data.draw(damaged_bytes(original))
    (tmp_path / "damaged.npz").write_bytes(damaged)
    try:
        stored = load_trajectory(tmp_path / "damaged.npz")
        time, flow = stored.time, stored["body.flange.flow"]
    except DocumentError:
        return
    if stored.ending.status is RunStatus.INTERRUPTED:  # what is left of a file whose end is gone
        assert stored.ending.message.startswith("the recording was cut off")
        assert len(time) == 0
    else:
        assert (time == run.time).all()
        assert (flow == run["body.flange.flow"]).all()


@given(st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_changed_headers_are_refused_or_make_a_run(file: Path, tmp_path: Path, data: st.DataObject):
    part = data.draw(st.sampled_from(["header", "progress/0"]))
    header = json.loads(_arrays(file)[part].tobytes())
    small = {name: None if name in ("model", "scenario") else value for name, value in header.items()}
    drawn = data.draw(changed_documents(small))
    changed = {name: header.get(name) if value is None else value for name, value in drawn.items()}
    try:
        stored = load_trajectory(_changed(file, tmp_path / "changed.npz", part, **changed))
    except DocumentError as error:
        refused = error
    else:
        assert len(stored.time) in (0, 101)
        return
    assert len(str(refused)) < 10_000
