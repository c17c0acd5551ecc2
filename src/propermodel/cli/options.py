"""The options that commands share, and how their text becomes values."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from propermodel.cli.faults import CommandError
from propermodel.diagnostics import Diagnostic, Faults, Path, parse_path

if TYPE_CHECKING:
    from propermodel.catalogue.subject import Subject


class MethodName(StrEnum):
    """The integration methods, under the names of `propermodel.compiler.Method`, and the choice by a trial."""

    EULER = "euler"
    SEMI_IMPLICIT = "semi-implicit-euler"
    RK4 = "rk4"
    ROS2 = "ros2"
    RODAS = "rodas"
    DOPRI5 = "dopri5"
    CVODE = "cvode"
    AUTO = "auto"


ModelText = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A name of the library (truck, half-car), file.py:Class (file.py alone where it holds one system), or the "
        "JSON document of a model, or the file of a run (.npz).",
    ),
]
ScenarioText = Annotated[
    str | None,
    typer.Option(
        "--scenario", help="A name, file.py:function, or the JSON document of a scenario.", metavar="SCENARIO"
    ),
]
Until = Annotated[float | None, typer.Option("--until", help="End of the run, s.", metavar="S")]
UntilCondition = Annotated[
    str | None,
    typer.Option(
        "--until",
        help='End of the run, s, or a condition that ends it before: "body.flange.flow > 20 km/h and time > 2 s".',
        metavar="S|CONDITION",
    ),
]
MethodOption = Annotated[
    MethodName | None, typer.Option("--method", help="How a step is taken; auto: what a short trial shows to be best.")
]
ToleranceOption = Annotated[
    float | None,
    typer.Option(
        "--tolerance", help="Error of a step, as a share of each state, where the method controls it.", metavar="SHARE"
    ),
]
JacobianOption = Annotated[
    int | None,
    typer.Option("--jacobian-every", help="Steps that ros2 takes with one Jacobian.", metavar="N"),
]
StepOption = Annotated[float | None, typer.Option("--step", help="Largest step, s.", metavar="S")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", help='A parameter by path, with its unit: body.mass="1500 kg".', metavar="PATH=VALUE"),
]
OutputOption = Annotated[
    list[str] | None,
    typer.Option("--output", help="An output by path that must stay right: body.flange.flow.", metavar="PATH"),
]
OutFolder = Annotated[
    FilePath | None, typer.Option("--out", help="Folder for the files.", metavar="DIR", file_okay=False)
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON in place of tables.")]


def configured(
    subject: Subject,
    *,
    until: float | None = None,
    method: MethodName | None = None,
    step: float | None = None,
    jacobian_every: int | None = None,
    tolerance: float | None = None,
    settings: Iterable[str] | None = None,
    outputs: Iterable[str] | None = None,
) -> Subject:
    """The subject with the options of the command line in place of its own.

    Raises:
        CommandError: a parameter or option does not fit the model.
    """
    from propermodel.catalogue.subject import changed
    from propermodel.compiler import Method
    from propermodel.simulation.choosing import AUTO

    given = list(settings or ())
    return changed(
        subject,
        until=until,
        method=None if method is None else AUTO if method is MethodName.AUTO else Method(method.value),
        step=step,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        parameters=parse_settings(subject, given) if given else {},
        outputs=tuple(parse_path(text) for text in outputs or ()),
    )


def end_of(until: str | None) -> tuple[float | None, str | None]:
    """The end of a run in seconds, or the condition that ends it, whichever the text states."""
    if until is None:
        return None, None
    try:
        return float(until), None
    except ValueError:
        return None, until


def parse_settings(subject: Subject, texts: Iterable[str]) -> dict[Path, float]:
    """Values in SI of parameters written as `path=value unit`.

    Raises:
        CommandError: a text names no parameter, or its value or unit does not fit.
    """
    from propermodel.catalogue.settings import read_settings

    faults = Faults(CommandError)
    given: dict[str, str] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark:
            faults.add(Diagnostic("command/set", f"'--set {text}' has no '='", help='write --set body.mass="1500 kg"'))
        else:
            given[name.strip()] = value
    found = read_settings(subject.model, given, faults)
    faults.raise_if_any()
    return found
