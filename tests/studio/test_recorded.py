"""Columns of long and growing runs: every extreme is there, and little is read."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from propermodel.codegen.machine import Method
from propermodel.diagnostics import parse_path
from propermodel.modelling.model import Scenario
from propermodel.report.buckets import extremes
from propermodel.simulation.run_writer import RunWriter
from propermodel.simulation.trajectory import Ending, RunStatus, Statistics
from propermodel.simulation.trajectory_format import Header, StoredProgress
from propermodel.studio import recorded
from propermodel.studio.recorded import RecordedRuns, packed_series
from tests.faults.quarter import quarter

END = 100.0
PATHS = [parse_path(f"body.s{number}") for number in range(60)]


def write(file: Path, rows: int, pieces: int = 1, *, is_over: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """A run of 60 signals, each with one row that stands out; gives its times and rows."""
    generator = np.random.default_rng(rows)
    times = np.linspace(0.0, END, rows)
    values = np.sin(times)[:, np.newaxis] * np.arange(1.0, 61.0) + generator.normal(size=(rows, 60))
    values[generator.integers(0, rows, 60), np.arange(60)] = 1e4
    header = Header(
        method=Method.RK4,
        step=1e-3,
        columns=tuple((path, "m/s", column) for column, path in enumerate(PATHS)),
        powers=(),
        scenario=Scenario(stop=END),
        model=quarter().model,
    )
    with file.open("wb") as stream:
        writer = RunWriter(stream, header, 60)
        for part in np.array_split(np.arange(rows), pieces):
            writer.signals.add(times[part], values[part])
        ending = Ending(RunStatus.COMPLETED, "completed", END) if is_over else None
        writer.finish(StoredProgress(time=float(times[-1]), statistics=Statistics(rows, 0.0, 0.0), ending=ending))
    return times, values


@pytest.mark.parametrize(("begin", "end"), [(0.0, END), (20.0, 80.0), (33.3, 33.4), (99.0, 120.0)])
def test_a_kept_column_has_every_extreme(tmp_path: Path, begin: float, end: float):
    times, values = write(tmp_path / "run.npz", 5000)
    _, columns = RecordedRuns().get(tmp_path / "run.npz").extremes(PATHS[:3], begin, end, 200)
    edges = np.linspace(begin, end, 201)
    for number, column in enumerate(columns):
        np.testing.assert_allclose(column, extremes(times, values[:, number], edges), rtol=1e-12)


@pytest.mark.parametrize(("begin", "end", "count"), [(0.0, END, 50), (10.0, 90.0, 20), (40.0, 41.0, 100)])
def test_the_overview_of_a_long_column_loses_no_peak(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begin: float, end: float, count: int
):
    monkeypatch.setattr(recorded, "MOST_ROWS", 1000)
    times, values = write(tmp_path / "run.npz", 50_000)
    run = RecordedRuns().get(tmp_path / "run.npz")
    instants, columns = run.extremes(PATHS, begin, end, count)
    inside = (times >= begin) & (times <= end)
    width = (end - begin) / count
    for number, column in enumerate(columns):
        assert np.nanmax(column) == values[inside, number].max()
        assert np.nanmin(column) == values[inside, number].min()
        at = instants[::2][int(np.nanargmax(column.reshape(-1, 2).max(axis=1)))]
        assert abs(at - times[inside][values[inside, number].argmax()]) <= 1.5 * width
    assert not run.kept  # nothing of a long run is held


def test_a_run_that_grows_is_kept_up_with(tmp_path: Path):
    runs, file, other = RecordedRuns(), tmp_path / "run.npz", tmp_path / "other.npz"
    write(file, 400, is_over=False)
    first = runs.get(file).extremes(PATHS[:1], 0.0, END, 10)[1][0]
    times, values = write(other, 800)
    # The file as it is when the second half has come.
    file.write_bytes(other.read_bytes())
    run = runs.get(file)
    assert len(run.time) == 800
    np.testing.assert_array_equal(run.time[400:], times[400:])
    np.testing.assert_array_equal(run[PATHS[0]][400:], values[400:, 0])
    assert len(first) == len(run.extremes(PATHS[:1], 0.0, END, 10)[1][0])


def test_columns_of_runs_that_nobody_looks_at_are_forgotten(tmp_path: Path):
    runs = RecordedRuns(most_bytes=50_000)
    for name in ("one", "two", "three"):
        write(tmp_path / name, 1000)
        runs.get(tmp_path / name).extremes(PATHS[:5], 0.0, END, 10)
    kept = {name: len(runs.get(tmp_path / name).kept) for name in ("one", "two", "three")}
    assert kept["one"] == 0
    assert kept["three"] > 0


def test_sixty_signals_of_two_million_samples_are_ready_at_once(tmp_path: Path):
    write(tmp_path / "run.npz", 36_667)
    runs = RecordedRuns()
    packed_series(*runs.get(tmp_path / "run.npz").extremes(PATHS, 0.0, END, 1000))  # reads the file
    used: list[float] = []
    for begin, end in [(0.0, END), (10.0, 60.0), (30.0, 31.0)]:
        before = time.process_time()
        content = packed_series(*runs.get(tmp_path / "run.npz").extremes(PATHS, begin, end, 1000))
        used.append(time.process_time() - before)
        assert len(content) == 16_000 + 60 * 8_000
    assert max(used) < 0.15
