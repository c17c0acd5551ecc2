"""Faults in files: documents, trajectories, measured data; and on the command line."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import xarray as xr
from typer.testing import CliRunner

import propermodel as pm
from propermodel.cli.app import app
from propermodel.library.vehicle.mission import mission
from propermodel.modelling.documents import to_document
from propermodel.modelling.limits import LIMITS
from propermodel.reduction.certify import make_certificate
from propermodel.simulation.reopening import reopened
from tests.faults.case import Case
from tests.faults.quarter import STEP, quarter, run
from tests.faults.reduction_cases import claimed

HERE = Path(__file__).parent
RIG = HERE.parent / "cli" / "quarter_car.py"


def file_of(text: str | bytes, name: str = "model.json") -> Path:
    """A file in a folder of its own that is gone with the process."""
    folder = tempfile.TemporaryDirectory()  # kept by the list below
    _FOLDERS.append(folder)
    path = Path(folder.name) / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


_FOLDERS: list[tempfile.TemporaryDirectory[str]] = []


def read(text: str | bytes) -> object:
    return pm.read_model(file_of(text))


def document(**changes: object) -> str:
    return json.dumps({**to_document(quarter().model), **changes})


def too_large() -> object:
    path = file_of("", "model.json")
    with path.open("wb") as stream:
        stream.truncate(LIMITS.file_bytes + 1)
    return pm.read_model(path)


def partial_run() -> object:
    path = file_of("", "run.npz")
    pm.save_trajectory(run(), path, only=["body.flange.flow"])
    return reopened(pm.load_trajectory(path))


def missing_column() -> object:
    path = file_of("", "run.npz")
    pm.save_trajectory(run(), path, only=["body.flange.flow"])
    return pm.load_trajectory(path)["body.flange.effort"]


def measured(text: str, **options: str) -> object:
    return pm.measured(file_of(text, "road.csv"), **options)


def two_dimensions() -> object:
    return pm.measured(xr.DataArray(np.zeros((3, 2)), dims=("time", "wheel")))


def command(*arguments: object) -> Callable[[], str]:
    def typed() -> str:
        done = CliRunner().invoke(app, [str(argument) for argument in arguments])
        assert done.exit_code != 0, done.output
        assert "Traceback" not in done.output
        return done.stderr

    return typed


def unimportable() -> str:
    return command("check", f"{file_of('import nothing_of_this_name', 'rig.py')}:Rig")()


def unreadable_cache() -> str:
    with mock.patch.dict(os.environ, {"PROPERMODEL_CACHE": str(file_of("", "propermodel"))}):
        return command("cache")()


def changed_beside() -> object:
    claim = claimed(step=1e-3)
    short = replace(claim, conditions=(replace(claim.conditions[0], scenario=STEP),))
    certified = make_certificate(short, short.pairs(), method="choice", removed=())
    file = pm.write_certificate(certified, file_of("").parent)
    beside = file.with_name("scenario.json")
    beside.write_text(beside.read_text() + " ")
    return pm.read_certificate(file)


CASES = (
    Case(code="document/partial-run", run=partial_run, names=("a part of what",), cure="with all observables"),
    Case(
        code="document/file",
        run=lambda: pm.read_model("nowhere/model.json"),
        names=("nowhere/model.json", "No such file"),
        cure="path",
    ),
    Case(
        code="document/file",
        run=lambda: pm.read_certificate("docs"),
        names=("docs/certificate.json", "no certificate in 'docs'"),
        cure="propermodel reduce",
    ),
    Case(code="document/size", run=too_large, names=("model.json", str(LIMITS.file_bytes)), cure="file_bytes"),
    Case(code="document/limit", run=lambda: read("[" * 100), names=("model.json", "line 1"), cure="depth"),
    Case(
        code="document/digest",
        run=changed_beside,
        names=("scenario.json", "SHA-256"),
        cure="put the original file beside",
    ),
    Case(
        code="document/archive",
        run=lambda: pm.load_trajectory(file_of("time,force", "run.npz")),
        names=("run.npz", "it is no archive"),
        cure="save_trajectory",
    ),
    Case(
        code="document/json", run=lambda: read("{'format': 1}"), names=("model.json", "line 1, column 2"), cure="wrote"
    ),
    Case(
        code="document/format",
        run=lambda: read(document(format="propermodel-scenario")),
        names=("model.json", "propermodel-scenario"),
        cure="scenario",
    ),
    Case(
        code="document/version",
        run=lambda: read(document(version=99)),
        names=("model.json", "99"),
        cure="open it with the release that wrote it",
    ),
    Case(
        code="document/content",
        run=lambda: read(document(root={"nam": "quarter"})),
        names=("model.json", "root", "nam"),
        cure="did you mean 'name'?",
    ),
    Case(
        code="document/column",
        run=missing_column,
        names=("body.flange.effort",),
        cure="did you mean 'body.flange.flow'?",
    ),
    Case(code="data/kind", run=lambda: pm.measured([1.0, 2.0]), names=("list",), cure="table_values"),
    Case(
        code="data/column",
        run=lambda: measured("time [s],height [m]\n0,1\n1,2\n2,3\n", column="heigth"),
        names=("heigth",),
        cure="did you mean 'height",
    ),
    Case(code="data/short", run=lambda: measured("time,height\n0,1\n"), names=("road.csv",), cure="two or more lines"),
    Case(
        code="data/number",
        run=lambda: measured("time,height\n0,1\n1,high\n2,2\n"),
        names=("line 3", "road.csv:3", "'high' in column 'height'"),
        cure="correct the line",
    ),
    Case(
        code="data/time",
        run=lambda: measured("time,height\n0,1\n2,2\n1,3\n"),
        names=("line 4", "road.csv:4", "the time 1"),
        cure="sort the lines",
    ),
    Case(
        code="data/csv",
        run=lambda: pm.measured(file_of(b"time,height\n0,1\n\xff\xfe,2\n", "road.csv")),
        names=("road.csv:3", "UTF-8"),
        cure="save the table as CSV",
    ),
    Case(code="data/dimensions", run=two_dimensions, names=("'time', 'wheel'",), cure="select one value"),
    Case(
        code="library/unknown-mission",
        run=lambda: mission("fmtv_mixt"),
        names=("fmtv_mixt",),
        cure="did you mean 'fmtv_mixed'?",
    ),
    Case(code="library/mission-end", run=lambda: mission("fmtv_mixed", until=1e6), names=("2200 s",), cure="until"),
    Case(
        code="library/roughness",
        run=lambda: mission("fmtv_mixed", roughness={"city": "Z"}),
        names=("city", "Z"),
        cure="class",
    ),
    Case(
        code="activity/map",
        run=command("rank", "run.csv", "--map", "nowhere.toml"),
        names=("nowhere.toml",),
        cure='effort = "force"',
    ),
    Case(code="command/unknown-model", run=command("check", "trck"), names=("trck",), cure="did you mean 'truck'?"),
    Case(code="command/model", run=command("check", RIG), names=("quarter_car.py",), cure="QuarterCar"),
    Case(
        code="command/unknown-name",
        run=command("check", f"{RIG}:QuarterCat"),
        names=("QuarterCat",),
        cure="did you mean 'QuarterCar'?",
    ),
    Case(
        code="command/unknown-scenario",
        run=command("run", f"{RIG}:QuarterCar", "--scenario", "nowhere"),
        names=("nowhere",),
        cure="JSON document",
    ),
    Case(
        code="command/scenario",
        run=command("run", f"{RIG}:QuarterCar", "--scenario", f"{RIG}:QuarterCar"),
        names=("QuarterCar", "no scenario"),
        cure="name a Scenario",
    ),
    Case(code="command/file", run=command("check", "nowhere.py:Rig"), names=("nowhere.py",), cure="path"),
    Case(
        code="command/import",
        run=unimportable,
        names=("rig.py:1", "nothing_of_this_name"),
        cure="python",
    ),
    Case(code="command/cache", run=unreadable_cache, names=("propermodel",), cure="PROPERMODEL_CACHE"),
    Case(
        code="command/about",
        run=command("rank", f"{RIG}:QuarterCar", "--about-of", "tyre"),
        names=("--about-of",),
        cure="--about equilibrium",
    ),
    Case(
        code="command/frequencies",
        run=command("rank", f"{RIG}:QuarterCar", "--frequencies", "3-30"),
        names=("3-30",),
        cure="--frequencies 0.1:30",
    ),
    Case(
        code="command/point",
        run=command("linearise", f"{RIG}:QuarterCar", "--at", "1", "--equilibrium"),
        names=("--at", "--equilibrium"),
        cure="give one of them",
    ),
    Case(
        code="command/export",
        run=command("export", f"{RIG}:QuarterCar", "-o", "truck.txt"),
        names=("truck.txt",),
        cure="ends with .py or .json",
    ),
    Case(
        code="command/range",
        run=command(
            "reduce",
            f"{RIG}:QuarterCar",
            "--tolerance",
            "body.flange.flow=5%",
            "--range",
            "body.mass=5",
            "--out",
            "out",
        ),
        names=("body.mass=5",),
        cure="--range body.mass=10%",
    ),
    Case(
        code="command/set",
        run=command("run", f"{RIG}:QuarterCar", "--set", "body.mass"),
        names=("body.mass",),
        cure='--set body.mass="1500 kg"',
    ),
)
