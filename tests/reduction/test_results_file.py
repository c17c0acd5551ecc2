"""Results of a search on disk: going on where it stopped, sharing them, and files that do not fit."""

from __future__ import annotations

import json
from pathlib import Path as FilePath

import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario

OUTPUTS = ("body.flange.flow", "suspension.spring.port.effort")


def search(
    file: FilePath, tolerance: pm.Tolerance | float, most: int = 200, step: float = 1e-3
) -> pm.ProperModelSearch:
    return pm.find_proper_model(
        pm.elaborate(QuarterCar()),
        scenario(),
        dict.fromkeys(OUTPUTS, tolerance),
        method=pm.Method.RK4,
        step=step,
        most_simulations=most,
        results=file,
    )


def outcome(found: pm.ProperModelSearch) -> list[tuple[object, ...]]:
    return [(c.rows, c.removals, c.verdict, c.score, c.comparisons) for c in found.candidates]


def test_a_search_goes_on_where_it_stopped(tmp_path: FilePath):
    alone = search(tmp_path / "alone", 0.02)
    file = tmp_path / "results"
    stopped = search(file, 0.02, most=2)
    assert stopped.simulations < alone.simulations
    rest = search(file, 0.02)
    assert rest.simulations == alone.simulations - stopped.simulations
    assert outcome(rest) == outcome(alone)
    again = search(file, 0.02)
    assert again.simulations == 0
    assert outcome(again) == outcome(alone)


def test_other_tolerances_share_results(tmp_path: FilePath):
    file = tmp_path / "results"
    search(file, 0.05)
    tolerance = pm.Tolerance(rms=0.05, largest=0.5, peak=0.3)
    found, alone = search(file, tolerance), search(tmp_path / "alone", tolerance)
    assert found.simulations < alone.simulations
    assert found.best is not None
    assert alone.best is not None
    assert found.best.rows == alone.best.rows
    assert found.best.comparisons == alone.best.comparisons


def test_a_line_that_was_cut_short_is_run_again(tmp_path: FilePath):
    file = tmp_path / "results"
    whole = search(file, 0.02)
    text = file.read_text()
    file.write_text(text[: text.rstrip().rfind("\n") + 20])
    assert search(file, 0.02).simulations == 1
    assert outcome(search(file, 0.02)) == outcome(whole)


@pytest.mark.parametrize("damage", ["", "[1, 2]\n", "{}\n", '{"format": "propermodel-model"}\n', "\x00\n"])
def test_files_of_something_else_are_refused(tmp_path: FilePath, damage: str):
    file = tmp_path / "results"
    file.write_text(damage)
    with pytest.raises(pm.ProperModelError, match="results-file"):
        search(file, 0.02)
    assert file.read_text() == damage


def test_results_of_another_step_and_broken_lines_are_refused(tmp_path: FilePath):
    file = tmp_path / "results"
    search(file, 0.05)
    with pytest.raises(pm.ProperModelError, match="other scenarios, outputs or steps"):
        search(file, 0.05, step=5e-4)
    head, first, *rest = file.read_text().splitlines()
    broken = json.dumps({**json.loads(first), "outputs": 7})
    file.write_text("\n".join([head, broken, *rest]) + "\n")
    with pytest.raises(pm.ProperModelError, match="broken"):
        search(file, 0.05)
