"""`propermodel compare-methods`: size against error, by this package's method and by those of others."""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import Annotated

import typer

from propermodel.cli.options import (
    AsJson,
    JacobianOption,
    MethodOption,
    ModelText,
    OutputOption,
    ScenarioText,
    SetOption,
    StepOption,
    Until,
    configured,
)


def compare_methods(
    model: ModelText,
    out: Annotated[FilePath, typer.Option("--out", help="Folder for the files.", metavar="DIR", file_okay=False)],
    output: OutputOption = None,
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance", help="Error at which sizes are compared, rms as a share of an output's range.", min=0.0
        ),
    ] = 0.02,
    threshold: Annotated[
        float, typer.Option(help="The share of activity that rankings keep by their own rule.", min=0.0, max=1.0)
    ] = 0.99,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    step_tolerance: Annotated[
        float | None,
        typer.Option(help="Error of a step, as a share of each state, where the method controls it.", metavar="SHARE"),
    ] = None,
    settings: SetOption = None,
    as_json: AsJson = False,
) -> None:
    """Reduce a model by several methods, measure every smaller model, and draw size against error."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import Screen
    from propermodel.reduction.methods.compare import compare_methods as compared
    from propermodel.report.methods import as_data, write_comparison

    subject = configured(
        load_subject(model, scenario),
        until=until,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=step_tolerance,
        settings=settings,
        outputs=output,
    )
    with ProgressBars() as bars:
        found = compared(
            subject.model,
            subject.scenario,
            subject.outputs,
            tolerance=tolerance,
            threshold=threshold,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            step_tolerance=subject.tolerance,
            progress=lambda curve: bars(curve.method),
        )
    files = write_comparison(found, out)
    if as_json:
        typer.echo(json.dumps(as_data(found), indent=2))
        return
    screen = Screen()
    screen.print(*str(found).splitlines(), "")
    for file in files:
        screen.print(f"{(out / file.name).as_posix()}  {file.meaning}")
