"""What is wrong on the command line is told as it is in a model."""

from pathlib import Path

import pytest

from propermodel.cli.progress import ProgressBars
from propermodel.compiler import compile_model
from propermodel.modelling.documents import write_model
from propermodel.simulation.simulate import Progress
from tests.cli.commands import FILE, MODEL, _model, fail, invoke, succeed


def test_unknown_model():
    assert fail(2, "run", "half-kar") == (
        "error[command/unknown-model]: there is no model 'half-kar'\n  help: did you mean 'half-car'?\n"
    )


def test_unknown_class():
    assert "help: did you mean 'QuarterCar'?" in fail(2, "run", f"{FILE}:QuarterCra")


def test_a_file_without_a_class_offers_its_components():
    printed = fail(2, "show", FILE)
    assert "say which one is the model" in printed
    assert f"{FILE}:QuarterCar" in printed


def test_something_that_is_no_component():
    assert "gives Scenario, which is no component or model" in fail(2, "show", f"{FILE}:waves")


def test_a_file_that_is_not_there():
    assert "error[command/file]: there is no file 'gone.py'" in fail(2, "check", "gone.py:Car")
    assert "error[document/file]" in fail(1, "check", "gone.json")


def test_a_file_that_cannot_be_imported(tmp_path: Path):
    file = tmp_path / "wrong_import.py"
    file.write_text("import math\n\nmath.nothing\n")
    printed = fail(2, "check", f"{file}:Car")
    assert "the file cannot be imported: AttributeError" in printed
    assert "wrong_import.py:3" in printed


def test_unknown_scenario():
    assert "help: did you mean 'bouncing'?" in fail(2, "run", MODEL, "--scenario", "bouncy")
    assert "one of waves, bouncing, scenario" in fail(2, "run", MODEL, "--scenario", "xyz")


def test_scenario_of_a_file_and_of_another_model(tmp_path: Path):
    printed = succeed("run", MODEL, "--scenario", f"{FILE}:bouncing", "--step", "0.001")
    assert "scenario bouncing: completed to 4 s" in printed
    write_model(compile_model(_model()).model, tmp_path / "car.json")
    assert "document of format 'propermodel-scenario'" in fail(2, "run", MODEL, "--scenario", tmp_path / "car.json")


def test_wrong_settings_are_all_reported():
    settings = ["body_mas=3", "body_mass=3 m", "body_mass", "wheel.mass=heavy", "suspension.stiffness=20 kN/m"]
    printed = fail(2, "run", MODEL, *(part for setting in settings for part in ("--set", setting)))
    assert printed.count("error[") == 4
    assert "the model has no parameter 'body_mas'\n  help: did you mean 'body_mass'?" in printed
    assert "'3 m' has the dimension m, not that of kg" in printed
    assert "'--set body_mass' has no '='" in printed
    assert "'heavy' is not a number with a unit" in printed


def test_a_value_out_of_range():
    assert "lies outside its range 100 to inf" in fail(2, "run", MODEL, "--set", "body_mass=5 kg")


def test_unknown_output_is_found_before_the_run(tmp_path: Path):
    printed = fail(2, "reduce", MODEL, "--out", tmp_path, "--output", "body.flange.flw")
    assert "did you mean 'body.flange.flow'?" in printed


def test_a_run_that_fails_numerically_says_so_and_keeps_what_was_computed(tmp_path: Path):
    done = invoke("run", MODEL, "--method", "euler", "--step", "0.3", "--until", "900", "--out", tmp_path)
    assert done.exit_code == 1
    assert "is no longer a finite number; try a smaller step" in done.stdout
    assert (tmp_path / "trajectory.npz").is_file()
    done = invoke("reduce", MODEL, "--method", "euler", "--step", "0.3", "--until", "900", "--out", tmp_path)
    assert done.exit_code == 1
    assert "error[study/incomplete]: full run: stopped at" in done.stderr
    assert (tmp_path / "full.npz").is_file()


class InterruptingBars(ProgressBars):
    """A user who presses Ctrl-C as soon as something moves."""

    def __call__(self, stage: str, progress: Progress | None = None) -> None:
        if progress is not None and stage in {"simulating", "refined"}:
            raise KeyboardInterrupt


def test_an_interrupted_run_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.cli.progress.ProgressBars", InterruptingBars)
    done = invoke("run", MODEL, "--until", "1000", "--step", "0.001", "--out", tmp_path)
    assert done.exit_code == 130
    assert "what was computed is kept" in done.stdout
    assert (tmp_path / "trajectory.npz").is_file()


def test_an_interrupted_study_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.cli.progress.ProgressBars", InterruptingBars)
    done = invoke("reduce", MODEL, "--step", "0.001", "--out", tmp_path)
    assert done.exit_code == 130
    assert "refined run: interrupted at" in done.stderr
    assert (tmp_path / "full.npz").is_file()
