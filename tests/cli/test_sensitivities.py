"""`propermodel sensitivities`, as a user types it."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from propermodel.cli.app import app

MODEL = f"{Path(__file__).with_name('quarter_car.py')}:QuarterCar"


def invoke(*arguments: str):
    return CliRunner().invoke(app, ["sensitivities", MODEL, "--step", "1e-3", *arguments])


def test_a_table_says_what_a_parameter_changes():
    done = invoke("--parameter", "body.mass", "--output", "body.flange.flow")
    assert done.exit_code == 0, done.output
    assert "m/s per kg" in done.stdout
    assert "points per %" in done.stdout


def test_json_holds_values_derivatives_and_relative_forms():
    done = invoke("--parameter", "body.mass", "--output", "body.flange.flow", "--json")
    report = json.loads(done.stdout)
    (parameter,), (output,) = report["parameters"], report["outputs"]
    assert (parameter["path"], parameter["unit"]) == ("body.mass", "kg")
    relative = output["derivatives"][0] * parameter["value"] / output["value"]
    assert output["relative"] == [pytest.approx(relative)]
    assert sum(element["index"]["derivatives"][0] for element in report["elements"]) == pytest.approx(0.0, abs=1e-9)


def test_no_parameter_is_misuse():
    done = invoke()
    assert done.exit_code == 2
    assert "no parameter is given" in done.stderr
