"""Models written as scripts of Python, executed, and compared with what they were."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import propermodel as pm
from propermodel.catalogue.finding import load_subject
from propermodel.cli.app import app
from propermodel.diagnostics import parse_path
from propermodel.exchange.python import to_python
from propermodel.expressions.core import Op, SymbolKind, constant, intern_node, symbol
from propermodel.modelling.model import Definition, ParameterData, Part
from tests.examples.runs import NAMES, subject


def made(text: str) -> pm.Model:
    """What a script makes."""
    names: dict[str, Any] = {"__name__": "script"}
    exec(compile(text, "script.py", "exec"), names)
    return names["model"]


@pytest.mark.parametrize("name", NAMES)
def test_every_example_is_equal_again(name: str):
    model = subject(name).model
    assert made(to_python(model)) == model


def test_the_truck_is_equal_again_also_without_some_of_its_elements():
    truck = load_subject("truck").model
    rigid = pm.ZeroFlow(parse_path("output_shaft.spring.port"))
    reduced = truck.without([rigid, pm.Freeze(parse_path("hydraulics.reservoir_pressure"), 6e5)])
    assert made(to_python(reduced)) == reduced
    assert len(to_python(truck).splitlines()) < 8000


@pytest.mark.parametrize("name", ["quarter_car", "bouncing_ball", "cruise_control"])
def test_a_script_is_written_in_words_of_the_field(name: str):
    text = to_python(subject(name).model)
    assert all(len(line) < 160 for line in text.splitlines() if "doc=" not in line and "lookup" not in line)
    assert "intern_node" not in text


def odd(value: Any) -> pm.Model:
    """A model whose one parameter has this default."""
    definition = Definition(
        type_name="class'; import os #",
        doc='""" + 1/0 + """',
        parameters=(
            ParameterData(name="lambda", unit="1", default=constant(3.0)),
            ParameterData(name="x y", unit="1", default=value),
        ),
    )
    return pm.Model(name="m\\'\n", root=Part(name="m", definition=definition), domains=())


X = symbol(SymbolKind.PARAMETER, parse_path("lambda"), "1")


@pytest.mark.parametrize(
    "value",
    [
        X - (X - 1.0),
        -(X**2.0),
        (-X) ** 3.0,
        2.0 / (X / 3.0),
        pm.where((X > 1.0) & ~(X < 2.0) | pm.equals(X, 5.0), -X, X * -2.5e-300),
        intern_node(Op.ADD, (constant(1.0), constant(2.0))),  # as a document may hold it
        intern_node(Op.MULTIPLY, (constant(1.0), X)),
        intern_node(Op.SQUARE_ROOT, (constant(-1.0),)),
        intern_node(Op.NEGATE, (intern_node(Op.NEGATE, (X,)),)),
        constant(9.81, "m/s2") * X,
        constant(float("inf")),
        pm.minimum(X, pm.atan2(X, 2.0), pm.floor(abs(X))),
    ],
)
def test_formulas_are_the_very_same_expressions(value: Any):
    again = made(to_python(odd(value)))
    assert again == odd(value)
    assert again.root.definition.parameters[1].default is value


def test_shared_parts_are_written_once():
    value = X
    for _ in range(200):
        value = pm.sin(value) * value + 1.0
    text = to_python(odd(value))
    assert len(text) < 40_000
    assert made(text).root.definition.parameters[1].default is value


def test_a_reduced_model_is_exported_shown_and_reduced_again(tmp_path: Path):
    model = subject("quarter_car").model.without([pm.ZeroEffort(parse_path("tyre.damper.port"))])
    document, script = tmp_path / "less.json", tmp_path / "less.py"
    pm.write_model(model, document)

    def typed(*arguments: object) -> str:
        done = CliRunner().invoke(app, [str(argument) for argument in arguments])
        assert done.exit_code == 0, done.output
        return done.stdout

    assert "run it with propermodel run" in typed("export", document, "-o", script)
    subprocess.run([sys.executable, str(script)], check=True, timeout=60)
    assert "no effort at tyre.damper.port" in typed("show", f"{script}:model")
    scenario = tmp_path / "scenario.json"
    pm.write_scenario(subject("quarter_car").scenario, scenario)
    options = [
        "--scenario",
        scenario,
        "--tolerance",
        "body.flange.flow=5%",
        "--step",
        "0.001",
        "--out",
        tmp_path / "out",
    ]
    typed("reduce", f"{script}:model", *options)
    smaller = pm.read_model(tmp_path / "out" / "reduced_model.json")
    assert smaller.removals[:1] == model.removals
    assert len(smaller.removals) > 1
    typed("export", tmp_path / "out" / "reduced_model.json", "-o", tmp_path / "again.json")
    assert pm.read_model(tmp_path / "again.json") == smaller


def test_a_file_of_no_kind_is_refused(tmp_path: Path):
    done = CliRunner().invoke(app, ["export", "truck", "-o", str(tmp_path / "truck.txt")])
    assert done.exit_code == 2
    assert "neither Python nor a document" in done.stderr
