"""Runs that are recorded to files while they go on."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from propermodel.catalogue.finding import load_subject
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import DocumentError, SimulationError, parse_path
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.limits import LIMITS
from propermodel.modelling.model import Scenario
from propermodel.simulation import archive_writer, run_writer, series
from propermodel.simulation.archive_writer import ArchiveWriter
from propermodel.simulation.archives import Member, read_column, scan
from propermodel.simulation.simulate import Progress, simulate
from propermodel.simulation.storage import StoredTrajectory, load_trajectory, save_trajectory
from propermodel.simulation.trajectory import RunStatus, Trajectory
from tests.event_parts import BouncingBall

MODEL = f"{Path(__file__).parents[1] / 'cli' / 'quarter_car.py'}:QuarterCar"
FLOW = "body.flange.flow"


@pytest.fixture(scope="module")
def compiled() -> CompiledModel:
    return compile_model(load_subject(MODEL).model)


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_subject(MODEL).scenario


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(run_writer, "CHUNK_BYTES", 2**14)


def both(compiled: CompiledModel, scenario: Scenario, file: Path, **options: object) -> tuple[Trajectory, Trajectory]:
    given = {"step": 1e-3, "record_every": 1e-3, **options}
    return simulate(compiled, scenario, **given), simulate(compiled, scenario, record_to=file, **given)


def assert_same(stored: StoredTrajectory | Trajectory, run: Trajectory) -> None:
    np.testing.assert_array_equal(stored.time, run.time)
    np.testing.assert_array_equal(stored.integral_times, run.integral_times)
    assert stored.paths == run.paths
    for path in run.paths:
        np.testing.assert_array_equal(stored[path], run[path])
    assert (stored.ending, stored.events, stored.notes) == (run.ending, run.events, run.notes)


@pytest.mark.usefixtures("small_chunks")
def test_a_recorded_run_is_the_run_in_memory(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    kept, recorded = both(compiled, scenario, tmp_path / "run.npz")
    stored = load_trajectory(tmp_path / "run.npz")
    assert len(kept.time) > 10_000
    assert len(zipfile.ZipFile(tmp_path / "run.npz").namelist()) > 20
    for found in (recorded, stored):
        assert_same(found, kept)
    np.testing.assert_array_equal(recorded.columns, kept.columns)
    np.testing.assert_array_equal(recorded.activities, kept.activities)
    bond = parse_path("body.flange")
    np.testing.assert_array_equal(stored.activity(bond), kept.kept_activity(bond))
    np.testing.assert_array_equal(recorded["body.flange.work"], kept["body.flange.work"])
    assert (stored.model, stored.scenario, stored.method) == (compiled.model, scenario, kept.method)
    assert stored.statistics == recorded.statistics
    assert stored.unit(FLOW) == "m/s"


def test_a_recorded_run_is_saved_and_continued_like_another(
    compiled: CompiledModel, scenario: Scenario, tmp_path: Path
):
    half = replace(scenario, stop=5.0)
    kept, recorded = both(compiled, half, tmp_path / "run.npz", record=[FLOW])
    save_trajectory(recorded, tmp_path / "again.npz")
    assert_same(load_trajectory(tmp_path / "again.npz"), kept)
    again, rest = (
        simulate(compiled, scenario, step=1e-3, record_every=1e-3, record=[FLOW], continued_from=recorded, record_to=to)
        for to in (None, tmp_path / "rest.npz")
    )
    assert_same(load_trajectory(tmp_path / "rest.npz"), replace(again, ending=rest.ending))
    assert rest.time[-1] == scenario.stop


def test_other_programs_can_read_the_file(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    simulate(compiled, scenario, record=[FLOW], step=1e-3, record_to=tmp_path / "run.npz")
    with zipfile.ZipFile(tmp_path / "run.npz") as archive:
        assert archive.testzip() is None
    with np.load(tmp_path / "run.npz", allow_pickle=False) as arrays:
        header = json.loads(arrays["header"].tobytes())
        rows = arrays["signals/0"]
    assert [["body", "flange", "flow"], "m/s", 0] in header["columns"]
    stored = load_trajectory(tmp_path / "run.npz")
    np.testing.assert_array_equal(rows, np.column_stack([stored.time, stored[FLOW]]))


def test_nothing_recorded_is_a_file_too(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    run = simulate(compiled, scenario, record=[], step=1e-3, record_to=tmp_path / "run.npz")
    stored = load_trajectory(tmp_path / "run.npz")
    assert stored.paths == ()
    assert len(stored.time) == 101
    assert stored.activity(parse_path("body.flange"))[-1] == run.activity(parse_path("body.flange"))


def test_events_are_in_the_file_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(run_writer, "WRITTEN_EVERY_S", 0.0)
    ball = compile_model(elaborate(BouncingBall()))
    run = simulate(
        ball, Scenario(stop=3.5), method=Method.RK4, step=1e-2, record_every=0.05, record_to=tmp_path / "run.npz"
    )
    assert len(run.events) == 9
    with np.load(tmp_path / "run.npz") as arrays:
        assert sum(name.startswith("progress/") for name in arrays) > 9
    assert_same(load_trajectory(tmp_path / "run.npz"), run)


# -- runs that are cut off --------------------------------------------------------------------------------------

KILLED = """
import sys
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import compile_model
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
subject = load_subject(sys.argv[1])
simulate(compile_model(subject.model), Scenario(stop=1e6), step=1e-3, record_every=1e-3, record_to=sys.argv[2])
"""


def wait_for(is_so: Callable[[], bool], what: str) -> None:
    until = time.monotonic() + 60.0
    while not is_so():
        assert time.monotonic() < until, what
        time.sleep(0.02)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no signal that kills")
def test_a_killed_process_leaves_all_but_its_last_rows(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    file = tmp_path / "run.npz"
    with subprocess.Popen([sys.executable, "-c", KILLED, MODEL, str(file)]) as process:
        try:
            wait_for(lambda: file.exists() and file.stat().st_size > 3 * run_writer.CHUNK_BYTES, "nothing is recorded")
            while_running = load_trajectory(file)
            assert while_running.ending.status is RunStatus.INTERRUPTED
            seen = len(while_running.time)
        finally:
            os.kill(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    stored = load_trajectory(file)
    rows = len(stored.time)
    assert rows >= seen > 0
    # All but the matrix that was being filled, and what was not yet reported, is there.
    assert rows * 8 * (1 + len(stored.paths)) > file.stat().st_size // 2
    assert stored.ending.message == f"the recording was cut off after {stored.ending.time:.6g} s"
    assert 0.0 < stored.time[-1] <= stored.ending.time
    assert stored.statistics.steps >= rows - 1
    again = simulate(compiled, Scenario(stop=float(stored.time[9999])), step=1e-3, record_every=1e-3, record=[FLOW])
    np.testing.assert_array_equal(stored.time[:10_000], again.time[:10_000])
    np.testing.assert_array_equal(stored[FLOW][:10_000], again[FLOW][:10_000])
    assert len(stored.overview(FLOW, points=100).time) <= 101


@pytest.mark.usefixtures("small_chunks")
def test_whatever_is_left_of_a_file_is_a_run(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    short = replace(scenario, stop=2.0)
    run = simulate(compiled, short, step=1e-3, record_every=1e-3, record_to=tmp_path / "run.npz", record=[FLOW])
    whole = (tmp_path / "run.npz").read_bytes()
    with (tmp_path / "run.npz").open("rb") as stream:
        members = scan(stream, LIMITS)
    assert sum(member.name.startswith("signals/") for member in members) > 1
    reports = [member.data + member.packed_size for member in members if member.name.startswith("progress/")]
    cut = tmp_path / "cut.npz"
    lengths: list[int] = []
    for end in sorted({*range(members[0].data + members[0].size, len(whole), 1009), *reports, len(whole) - 1}):
        cut.write_bytes(whole[:end])
        stored = load_trajectory(cut)
        rows = len(stored.time)
        lengths.append(rows)
        np.testing.assert_array_equal(stored[FLOW], run[FLOW][:rows])
        np.testing.assert_array_equal(stored.time, run.time[:rows])
        if end >= reports[-1]:
            assert stored.ending == run.ending
        else:
            assert stored.ending.message.startswith("the recording was cut off after")
    assert lengths == sorted(lengths)
    assert len(set(lengths)) > 2
    cut.write_bytes(whole[: members[0].data + 10])
    with pytest.raises(DocumentError, match="it has no header"):
        load_trajectory(cut)


@pytest.mark.usefixtures("small_chunks")
def test_parts_that_never_reached_the_disk_end_the_run(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    """A computer that loses its power may keep the length of a file, with zeros in place of the last parts."""
    file = tmp_path / "run.npz"
    simulate(compiled, scenario, step=1e-3, record_every=1e-3, record_to=file, record=[FLOW])
    with file.open("rb") as stream:
        members = scan(stream, LIMITS)
    rows = [member for member in members if member.name.startswith("signals/")]
    lost = rows[-2]
    data = bytearray(file.read_bytes()[: members[-1].begin])
    data[lost.data + 1000 : lost.data + 2000] = bytes(1000)
    file.write_bytes(data)
    stored = load_trajectory(file)
    assert 0 < len(stored.time) <= sum(member.shape[0] for member in rows[:-2])
    assert stored.ending.status is RunStatus.INTERRUPTED


def test_an_interrupted_run_is_whole_up_to_there(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    def interrupt(progress: Progress) -> None:
        if progress.fraction > 0.0:
            raise KeyboardInterrupt

    long = replace(scenario, stop=1e6)
    run = simulate(compiled, long, step=1e-3, record=[FLOW], progress=interrupt, record_to=tmp_path / "run.npz")
    assert run.ending.status is RunStatus.INTERRUPTED
    stored = load_trajectory(tmp_path / "run.npz")
    assert_same(stored, run)
    assert stored.ending.message.startswith("interrupted at")


@pytest.mark.skipif(sys.platform == "win32", reason="limits of processes are those of POSIX")
def test_a_full_disk_ends_the_run_and_keeps_what_is_there(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    import resource

    file = tmp_path / "run.npz"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (9 * 2**20, before[1]))
    try:
        run = simulate(compiled, replace(scenario, stop=1e6), step=1e-3, record_every=1e-3, record_to=file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert run.ending.status is RunStatus.FAILED
    assert "it could not be recorded further: File too large" in run.ending.message
    stored = load_trajectory(file)
    assert 0 < len(stored.time) == len(run.time)
    assert stored.time[-1] <= run.ending.time
    assert np.isfinite(run.at_end(FLOW))


def test_a_file_that_cannot_be_written_is_said_before_the_run(
    compiled: CompiledModel, scenario: Scenario, tmp_path: Path
):
    with pytest.raises(
        SimulationError, match=r"error\[simulation/record-to\]: the run cannot be recorded to .*nowhere"
    ):
        simulate(compiled, scenario, record_to=tmp_path / "nowhere" / "run.npz")


def test_a_file_that_was_exchanged_is_noticed(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    run = simulate(compiled, scenario, step=1e-3, record_to=tmp_path / "run.npz")
    simulate(compiled, scenario, step=5e-4, record_to=tmp_path / "run.npz")
    with pytest.raises(DocumentError, match="it has been changed since it was opened"):
        run[FLOW]


# -- bounded memory -----------------------------------------------------------------------------------------------

MEASURED = """
import resource, sys
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import compile_model
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
subject = load_subject(sys.argv[1])
compiled = compile_model(subject.model)
peaks = []
for stop in (5.0, 600.0):
    run = simulate(compiled, Scenario(stop=stop), step=1e-3, record_every=1e-3, record_to=sys.argv[2])
    run.overview(sys.argv[3])
    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10))
print(*peaks)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="the measurement is that of POSIX")
def test_memory_does_not_grow_with_the_length_of_a_run(tmp_path: Path):
    file = tmp_path / "run.npz"
    command = [sys.executable, "-c", MEASURED, MODEL, str(file), FLOW]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    short, long = map(float, answer.split())
    size = file.stat().st_size / 2**20
    assert size > 100.0  # MiB
    assert long - short < 30.0


# -- overviews ------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("points", [1, 7, 300, 10**6])
@pytest.mark.parametrize("window", [(-np.inf, np.inf), (0.5, 9.25), (3.0001, 3.0002), (2.0, 2.0), (20.0, 30.0)])
def test_overviews_of_files_and_of_arrays_hold_all_values(
    compiled: CompiledModel, scenario: Scenario, tmp_path: Path, points: int, window: tuple[float, float]
):
    kept, recorded = both(compiled, scenario, tmp_path / "run.npz", record=[FLOW, "wheel.flange.flow"])
    inside = (kept.time >= window[0]) & (kept.time <= window[1])
    for run in (kept, recorded, load_trajectory(tmp_path / "run.npz")):
        for path in (FLOW, "wheel.flange.flow"):
            seen = run.overview(path, *window, points=points)
            values, times = kept[path][inside], kept.time[inside]
            assert len(seen.time) <= points + 2
            assert (seen.least <= seen.greatest).all()
            if not len(times):
                assert not len(seen.time)
                continue
            assert seen.time[0] == times[0]
            groups = np.searchsorted(times, seen.time)
            np.testing.assert_array_equal(seen.least, np.minimum.reduceat(values, groups))
            np.testing.assert_array_equal(seen.greatest, np.maximum.reduceat(values, groups))


def test_an_overview_reads_little_of_a_long_file(
    compiled: CompiledModel, scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    long = replace(scenario, stop=400.0)
    run = simulate(compiled, long, step=1e-3, record_every=1e-3, record_to=tmp_path / "run.npz")
    greatest = run[FLOW].max()
    rows: list[int] = []

    def counted(stream: BinaryIO, member: Member, index: int, first: int, last: int) -> FloatArray:
        rows.append(last - first)
        return read_column(stream, member, index, first, last)

    monkeypatch.setattr(series, "read_column", counted)
    seen = run.overview(FLOW, points=1000)
    assert 500 <= len(seen.time) <= 1002
    assert seen.greatest.max() == greatest
    assert len(run.signals) == 400_001
    assert 12_000 < sum(rows) < 80_000


def test_a_power_has_an_overview(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    kept, recorded = both(compiled, scenario, tmp_path / "run.npz")
    for run in (kept, recorded, load_trajectory(tmp_path / "run.npz")):
        seen = run.overview("body.flange.power", points=10)
        assert seen.greatest.max() == kept["body.flange.power"].max()
    assert kept.overview("body.flange.activity", points=10).greatest[-1] == kept["body.flange.activity"][-1]


# -- for other programs -----------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("small_chunks")
def test_columns_go_to_pandas_xarray_and_csv(compiled: CompiledModel, scenario: Scenario, tmp_path: Path):
    import pandas as pd

    simulate(compiled, scenario, step=1e-3, record_every=1e-3, record_to=tmp_path / "run.npz")
    stored = load_trajectory(tmp_path / "run.npz")
    names = [FLOW, "body.flange.power"]
    frame = stored.to_pandas(names)
    assert list(frame.columns) == names
    parts = list(stored.frames(names))
    assert len(parts) > 10
    pd.testing.assert_frame_equal(pd.concat(parts), frame)
    data = stored.to_xarray(names)
    assert data[FLOW].attrs == {"units": "m/s"}
    assert set(stored.to_xarray().data_vars) == set(map(str, stored.paths))
    stored.to_csv(tmp_path / "run.csv", names)
    with (tmp_path / "run.csv").open(newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["time_s", f"{FLOW} [m/s]", "body.flange.power [W]"]
    np.testing.assert_allclose(
        np.array(rows, dtype=float), np.column_stack([stored.time, *(stored[name] for name in names)]), rtol=1e-8
    )


# -- the archive ------------------------------------------------------------------------------------------------


def test_archives_may_have_more_parts_than_a_small_zip_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(archive_writer, "_MOST_16", 100)  # in place of 65535, which takes long
    file = tmp_path / "many.npz"
    with file.open("wb") as stream:
        writer = ArchiveWriter(stream, is_packed=False)
        for number in range(150):
            writer.add(f"a/{number}", np.zeros(1, np.uint8))
        writer.finish()
    with zipfile.ZipFile(file) as archive:
        assert len(archive.namelist()) == 150


def test_a_part_whose_writing_was_interrupted_is_written_over(tmp_path: Path):
    file = tmp_path / "a.npz"
    with file.open("wb") as stream:
        writer = ArchiveWriter(stream, is_packed=False)
        writer.add("a/0", np.arange(1000.0))
        stream.write(b"PK\x03\x04 half a part" + bytes(5000))
        writer.add("a/1", np.arange(3.0))
        writer.finish()
    with np.load(file) as arrays:
        assert arrays["a/1"].tolist() == [0.0, 1.0, 2.0]
    with file.open("rb") as stream:
        assert [member.name for member in scan(stream, LIMITS)] == ["a/0", "a/1"]


def test_parts_beyond_4_gib_are_found(tmp_path: Path):
    file = tmp_path / "far.npz"
    with file.open("wb") as stream:
        writer = ArchiveWriter(stream, is_packed=False)
        writer._end = 5 * 2**30  # a hole in the file, where other parts would be
        writer.add("a/0", np.arange(3.0))
        writer.finish()
    with zipfile.ZipFile(file) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["a/0.npy"]
