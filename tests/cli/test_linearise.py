"""`propermodel linearise`, as a user types it."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from propermodel.cli.app import app

MODEL = f"{Path(__file__).with_name('quarter_car.py')}:QuarterCar"


def succeed(*arguments: str) -> str:
    done = CliRunner().invoke(app, ["linearise", MODEL, *arguments])
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.parametrize("point", [(), ("--at", "0.2"), ("--equilibrium",)], ids=["start", "instant", "equilibrium"])
def test_a_linear_model_has_the_same_modes_wherever_it_is_taken(point: tuple[str, ...]):
    report = json.loads(succeed(*point, "--json"))
    assert report["time_s"] == pytest.approx(0.2 if point[:1] == ("--at",) else 0.0)
    values = np.linalg.eigvals(np.array(report["A"]))
    upper = sorted(value.imag / (2.0 * math.pi) for value in values if value.imag > 0.0)
    assert sorted(mode["frequency_Hz"] for mode in report["modes"] if mode["frequency_Hz"]) == pytest.approx(upper)
    assert report["is_stable"]


def test_modes_are_printed_and_transfer_functions_where_outputs_are_named():
    alone = succeed()
    assert "frequency Hz" in alone
    assert "(s^2+" not in alone
    assert "body.flange.flow / road" in succeed("--output", "body.flange.flow").replace(
        ".flow / road.flow", ".flow / road"
    )


def test_matrices_are_printed_on_request():
    assert "\n  A\n" in succeed("--matrices")
