"""Reducing at a threshold and within tolerances, and the certificates of both."""

import json
from pathlib import Path

import pytest

from propermodel.modelling.documents import read_model
from tests.cli.commands import MODEL, fail, invoke, succeed


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("study")
    options = ["--threshold", "0.97", "--junction-tolerance", "0.1", "--step", "0.001", "--output", "body.flange.flow"]
    return out, succeed("reduce", MODEL, "--out", out, *options)


def test_reduce_prints_decisions_errors_and_files(reduced: tuple[Path, str]):
    out, printed = reduced
    lines = printed.splitlines()
    wheel = next(line for line in lines if line.startswith("wheel "))
    assert "removed" in wheel
    assert "no effort" in wheel
    assert any(line.startswith("body.flange.flow ") and line.endswith("m/s") for line in lines)
    assert "4 states become 3" in lines
    assert "6 energy elements; the threshold keeps 4" in lines
    for name in ("activity.png", "outputs.png", "summary.json", "reduced_model.json"):
        assert (out / name).is_file()
        assert (out / name).as_posix() in printed
    assert all(line == line.rstrip() for line in lines)


def test_the_reduced_model_can_be_run_and_shown_again(reduced: tuple[Path, str]):
    out, _ = reduced
    assert len(read_model(out / "reduced_model.json").removals) == 2
    shown = succeed("show", out / "reduced_model.json")
    assert "no effort at wheel.flange" in shown
    report = json.loads(
        succeed("run", out / "reduced_model.json", "--scenario", out / "reduced_scenario.json", "--json")
    )
    assert report["status"] == "completed"
    assert report["time_s"] == 10.0
    assert set(report["outputs"]) == {
        "body.momentum",
        "suspension.spring.displacement",
        "tyre.spring.displacement",
    }


def test_starts_of_removed_storage_are_left_out_of_the_reduced_scenario(tmp_path: Path):
    arguments = ["--scenario", "bouncing", "--threshold", "0.5", "--junction-tolerance", "1", "--no-speed", "--json"]
    summary = json.loads(succeed("reduce", MODEL, "--out", tmp_path, *arguments, "--step", "0.001"))
    gone = {element["path"] for element in summary["elements"] if element["decision"] == "removed"}
    scenario = json.loads((tmp_path / "reduced_scenario.json").read_text())
    assert ("wheel" in gone) == (not scenario["initial"])


def test_the_smallest_model_within_tolerances(tmp_path: Path):
    options = ["--tolerance", "body.flange.flow=5%", "--step", "0.001", "--until", "4", "--out", tmp_path]
    report = json.loads(succeed("reduce", MODEL, *options, "--json"))
    assert report == json.loads((tmp_path / "search.json").read_text())
    smallest = report["candidates"][report["smallest"]]
    assert smallest["verdict"] == "within the tolerances"
    assert smallest["errors"]["waves"]["body.flange.flow"]["rms"] <= 0.05
    assert len(read_model(tmp_path / "reduced_model.json").removals) >= 1
    assert "rows  states" in succeed("reduce", MODEL, *options)


def test_both_ways_to_reduce_write_a_certificate_that_holds(reduced: tuple[Path, str], tmp_path: Path):
    assert "the certificate holds" in succeed("verify", reduced[0] / "certificate.json")
    options = ["--tolerance", "body.flange.flow=5%", "--step", "0.001", "--until", "4", "--out", tmp_path]
    assert "certificate.json" in succeed("reduce", MODEL, *options)
    report = json.loads(succeed("verify", tmp_path / "certificate.json", "--json"))
    assert report["holds"]
    assert report["error_over_tolerance"] <= 1.0
    scenario = tmp_path / "scenario.json"
    assert succeed("verify", tmp_path / "certificate.json", "--model", MODEL, "--scenario", scenario)


def test_ranges_of_parameters_stand_in_the_certificate(tmp_path: Path):
    options = ["--tolerance", "body.flange.flow=9%", "--step", "0.001", "--until", "2", "--out", tmp_path]
    ranges = ["--range", "body.mass=5%", "--range", "wheel.mass=0.07 t..90kg"]
    succeed("reduce", MODEL, *options, *ranges)
    found = json.loads((tmp_path / "certificate.json").read_text())["ranges"]["ranges"]
    assert [(r["parameter"], r["low"], r["high"]) for r in found][1] == ("wheel.mass", 70.0, 90.0)
    assert "is no range of a parameter" in fail(2, "reduce", MODEL, *options, "--range", "body.mass=5")
    assert "no parameter 'body.mas'" in fail(2, "reduce", MODEL, *options, "--range", "body.mas=5%")
    assert "there are none" in fail(2, "reduce", MODEL, "--out", tmp_path, *ranges)


def test_a_certificate_that_does_not_hold_ends_with_1(reduced: tuple[Path, str], tmp_path: Path):
    for file in reduced[0].glob("*.json"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    certificate = tmp_path / "certificate.json"
    document = json.loads(certificate.read_text())
    document["reduced"]["states"] -= 1
    certificate.write_text(json.dumps(document))
    done = invoke("verify", certificate)
    assert done.exit_code == 1
    assert "states of the reduced model" in done.stdout
    assert "does NOT hold" in done.stdout
    assert "not the file that was certified" in fail_after_change(tmp_path / "scenario.json", certificate)


def fail_after_change(file: Path, certificate: Path) -> str:
    file.write_text(file.read_text() + " ")
    return fail(2, "verify", certificate)


def test_tolerances_name_features(tmp_path: Path):
    options = ["--step", "0.001", "--until", "4", "--out", tmp_path, "--json"]
    given = ["--tolerance", "body.flange.flow=2%, largest:4%", "--tolerance", "body.flange.flow=peak-time:0.1"]
    report = json.loads(succeed("reduce", MODEL, *given, *options))
    assert report["tolerances"] == {"body.flange.flow": {"rms": 0.02, "largest": 0.04, "peak_time": 0.1}}
    errors = report["candidates"][report["smallest"]]["errors"]["waves"]["body.flange.flow"]
    assert errors["largest"] <= 0.04
    assert errors["settling"] == "it still moves when the run ends"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("body.flange.flow=finale:1%", "did you mean 'final'?"),
        ("body.flange.flow=1%,rms:2%", "the rms of 'body.flange.flow' is given twice"),
        ("body.flange.flow=-1%", "is no output with a tolerance"),
        ("body.flange.flow=final:", "is no output with a tolerance"),
    ],
)
def test_features_that_do_not_exist_are_refused(tmp_path: Path, text: str, message: str):
    assert message in fail(2, "reduce", MODEL, "--out", tmp_path, "--tolerance", text)


def test_tolerances_that_say_nothing_are_refused(tmp_path: Path):
    assert "'body.flange.flow' is no output with a tolerance" in fail(
        2, "reduce", MODEL, "--out", tmp_path, "--tolerance", "body.flange.flow"
    )
    assert "observables end with 'flow'" in fail(2, "reduce", MODEL, "--out", tmp_path, "--tolerance", "flow=1%")


def test_settings_reach_both_models(tmp_path: Path):
    arguments = ["--set", "body_mass=0.9 t", "--output", "body.flange.flow", "--no-speed", "--step", "0.001"]
    succeed("reduce", MODEL, "--out", tmp_path, *arguments, "--json")
    for name in ("scenario.json", "reduced_scenario.json"):
        assert json.loads((tmp_path / name).read_text())["parameters"] == {"body_mass": 900.0}


def test_json_is_the_summary_file(tmp_path: Path):
    printed = succeed("reduce", MODEL, "--out", tmp_path, "--until", "1", "--no-speed", "--step", "0.001", "--json")
    assert json.loads(printed) == json.loads((tmp_path / "summary.json").read_text())
