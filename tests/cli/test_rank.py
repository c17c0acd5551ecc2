"""Ranking of elements, windows, bonds and frequencies."""

import json
from pathlib import Path

import pytest

from propermodel.diagnostics import parse_path
from propermodel.modelling.documents import write_scenario
from propermodel.modelling.model import Scenario
from tests.cli.commands import MODEL, fail, succeed


def test_rank_prints_the_ranking_with_its_check():
    printed = succeed("rank", MODEL, "--step", "0.001")
    rows = [line.split()[0] for line in printed.splitlines()[2:8]]
    assert rows[0] == "suspension.spring"
    assert rows[-1] == "tyre.damper"
    assert "at a step of 0.0005 s instead of 0.001 s indices change by at most" in printed


def test_rank_of_a_window_and_without_a_check():
    report = json.loads(succeed("rank", MODEL, "--window", 2, 5, "--no-refine", "--json"))
    assert report["window_s"] == [2.0, 5.0]
    assert report["discretisation_check_points"] is None
    assert sum(element["index"] for element in report["elements"]) == pytest.approx(1.0)


def test_rank_of_bonds_tells_their_shares_at_junctions():
    printed = succeed("rank", MODEL, "--step", "0.001", "--bonds", "--no-refine").splitlines()
    assert printed[2].split()[0] == "suspension.spring.difference_ring2.carried"
    assert "not checked with a smaller step" in printed
    report = json.loads(succeed("rank", MODEL, "--step", "0.001", "--bonds", "--json"))
    (road,) = (bond for bond in report["bonds"] if bond["kind"] == "Sf")
    assert list(road["relative"].values()) == [1.0]
    assert report["discretisation_check"] == "at a step of 0.0005 s instead of 0.001 s"
    assert not any(junction["is_inactive"] for junction in report["junctions"])
    lines = succeed("rank", MODEL, "--step", "0.001", "--bonds", "--no-refine", "--csv").splitlines()
    assert lines[0].startswith("rank,path,kind,domain,tail,head,activity_J,share")
    assert len(lines) == 1 + len(report["bonds"])


def test_rank_measures_storage_about_a_point():
    plain, about = (
        json.loads(succeed("rank", MODEL, "--step", "0.001", "--no-refine", "--json", *more))
        for more in ((), ("--about", "equilibrium"))
    )
    # At rest nothing in this car is loaded, so that nothing changes but what the ranking says of itself.
    assert about["elements"] == plain["elements"]
    assert about["datums"] == [*plain["datums"], "storage: measured about the equilibrium in scenario waves"]
    printed = succeed(
        "rank", MODEL, "--step", "0.001", "--no-refine", "--about", "start", "--about-of", "tyre", "--about-of", "body"
    )
    assert "datum of storage: measured about the start of scenario waves in tyre, body" in printed
    assert "error[command/about]" in fail(2, "rank", MODEL, "--about-of", "tyre")


def test_rank_by_frequency_needs_no_run():
    printed = succeed("rank", MODEL, "--frequencies", "0.5:20", "--input", "road.flow=0.01", "--threshold", "0.99")
    assert "datum of efforts and flows: deviations from the start of scenario waves" in printed
    report = json.loads(succeed("rank", MODEL, "--frequencies", "0.5:20:7", "--about", "equilibrium", "--json"))
    assert [part["name"] for part in report["parts"]] == [f"{0.5 * 40.0 ** (k / 6):.4g} Hz" for k in range(7)]
    assert "error[command/frequencies]" in fail(2, "rank", MODEL, "--frequencies", "20:5")
    assert "error[command/frequencies]" in fail(2, "rank", MODEL, "--frequencies", "1:2", "--input", "road.flow=much")


def test_rank_over_windows_tells_the_largest_indices_and_what_is_kept():
    printed = succeed("rank", MODEL, "--step", "0.001", "--windows", "0.3:1.7,2:4", "--threshold", "0.99")
    assert "waves, 0.3 to 1.7 s" in printed
    assert "a threshold of 0.99 keeps 5 of 6" in printed
    report = json.loads(succeed("rank", MODEL, "--step", "0.001", "--no-refine", "--windows", "1 s", "--json"))
    assert len(report["parts"]) == 10
    body = next(element for element in report["elements"] if element["path"] == "body")
    assert body["largest_index"] == max(part["index"] for part in body["parts"])
    assert sum(c["index"] for c in report["components"]) < 1.0
    assert "'0:x' are no windows" in fail(2, "rank", MODEL, "--windows", "0:x")


def test_rank_prints_csv_with_a_column_for_each_scenario(tmp_path: Path):
    files = [tmp_path / f"{name}.json" for name in ("short", "long")]
    for number, file in enumerate(files, 1):
        start = {parse_path("wheel.momentum"): 8.0}
        write_scenario(Scenario(name=file.stem, stop=float(number), initial=start), file)
    scenarios = [argument for file in files for argument in ("--scenario", file)]
    lines = succeed("rank", MODEL, "--csv", "--no-refine", *scenarios).splitlines()
    assert lines[0].endswith("index in short,index in long")
    assert len(lines) == 7
