"""`propermodel reduce`: the simplest model whose answers are still good."""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from propermodel.cli.faults import FAULTS_FOUND, INTERRUPTED, CommandError, print_diagnostics
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

if TYPE_CHECKING:
    from propermodel.catalogue.subject import Subject
    from propermodel.report.options import StudyOptions


def reduce(
    model: ModelText,
    out: Annotated[FilePath, typer.Option("--out", help="Folder for the files.", metavar="DIR", file_okay=False)],
    threshold: Annotated[float, typer.Option(help="The share of activity to keep.", min=0.0, max=1.0)] = 0.99,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    step_tolerance: Annotated[
        float | None,
        typer.Option(help="Error of a step, as a share of each state, where the method controls it.", metavar="SHARE"),
    ] = None,
    output: OutputOption = None,
    settings: SetOption = None,
    keep_driven: Annotated[
        bool,
        typer.Option(
            "--keep-driven", help="Keep every row above the threshold, also in parts that act back on nothing."
        ),
    ] = False,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            "--tolerance",
            help="Find the smallest model in which an output changes by less than this share of its range (rms): "
            "body.flange.flow=2%. Or name features: fuel=final:0.2%,largest:1% (mean, rms, largest, final, peak, "
            "peak-time, rise, settling).",
            metavar="PATH=SHARE",
        ),
    ] = None,
    ranges: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            help="With --tolerance: a parameter for whose values the tolerances must hold as well, body.mass=10% or "
            "body.mass=0.9t..1.5t.",
            metavar="PATH=RANGE",
        ),
    ] = None,
    results: Annotated[
        FilePath | None,
        typer.Option(
            "--results",
            help="With --tolerance: a file that keeps what runs came to, to go on from it and for other tolerances.",
        ),
    ] = None,
    junction_tolerance: Annotated[
        float, typer.Option(help="Largest share of a neglected term at its junction, with --threshold.", min=0.0)
    ] = 0.1,
    speed: Annotated[bool, typer.Option("--speed/--no-speed", help="Measure how much faster it is.")] = True,
    best_steps: Annotated[
        bool, typer.Option("--best-steps/--no-best-steps", help="Measure also at the largest good steps.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Rank the activity of a model, remove what does not matter, and compare the reduced model with it.

    With --tolerance, find the smallest model whose outputs stay within tolerances instead.
    """
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.within import reduce_within
    from propermodel.report.options import StudyOptions

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
    if tolerance:
        reduce_within(subject, tolerance, ranges or [], out, results=results, as_json=as_json)
        return
    if ranges:
        raise CommandError.of(
            "command/range",
            "ranges of parameters say how far tolerances must hold, and there are none",
            help="give at least one, --tolerance body.flange.flow=2%",
        )
    options = StudyOptions(
        threshold=threshold,
        tolerance=junction_tolerance,
        drop_driven=not keep_driven,
        outputs=subject.outputs,
        totals=subject.totals,
        panels=subject.panels,
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        step_tolerance=subject.tolerance,
        speed_repeats=5 if speed else 0,
        best_steps=best_steps,
    )
    reduce_subject(subject, options, out, as_json=as_json)


def reduce_subject(subject: Subject, options: StudyOptions, out: FilePath, *, as_json: bool) -> None:
    """Run the study, write its files, and print it."""
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import Screen, comparison_table, decisions_table, ranking_notes, study_lines
    from propermodel.report.files import write_incomplete, write_study
    from propermodel.report.study import IncompleteStudy, run_study

    out.mkdir(parents=True, exist_ok=True)
    try:
        with ProgressBars() as bars:
            study = run_study(subject.model, subject.scenario, options, bars)
            bars("writing files")
            summary, files = write_study(study, out)
    except IncompleteStudy as error:
        if error.so_far.reduction is not None and not as_json:
            Screen().print(decisions_table(error.so_far.reduction))
        print_diagnostics(error.diagnostics)
        for name in write_incomplete(error.so_far, out):
            typer.echo(f"what was made until then: {(out / name).as_posix()}", err=True)
        raise typer.Exit(INTERRUPTED if error.was_interrupted else FAULTS_FOUND) from None
    if as_json:
        typer.echo(json.dumps(summary, indent=2))
        return
    screen = Screen()
    screen.print(decisions_table(study.reduction))
    screen.print("")
    screen.print(comparison_table(study.comparison))
    screen.print("")
    for line in (*study_lines(study), *ranking_notes(study.ranking)):
        screen.print(line)
    screen.print("")
    width = max(len((out / file.name).as_posix()) for file in files)
    for file in files:
        screen.print(f"{(out / file.name).as_posix():<{width}}  {file.meaning}")
