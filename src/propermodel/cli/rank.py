"""`propermodel rank`: which elements matter in a scenario, by activity and for outputs."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from propermodel.cli.faults import FAULTS_FOUND, INTERRUPTED, print_diagnostics
from propermodel.cli.options import (
    AsJson,
    JacobianOption,
    MethodOption,
    ModelText,
    OutputOption,
    ScenarioText,
    SetOption,
    StepOption,
    ToleranceOption,
    Until,
    configured,
)


def rank(
    model: ModelText,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    tolerance: ToleranceOption = None,
    settings: SetOption = None,
    output: OutputOption = None,
    window: Annotated[
        tuple[float, float] | None, typer.Option(help="The part of the run to rank, s.", metavar="FROM TO")
    ] = None,
    refine: Annotated[
        bool,
        typer.Option("--refine/--no-refine", help="Check with a run at half the step, or a tenth of the tolerance."),
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Rank the energy elements of a model by activity, and with --output by what their removal would change."""
    from propermodel.analysis.activity import rank_activity
    from propermodel.cli.models import load_subject
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import Screen, prediction_table, ranking_notes, ranking_table
    from propermodel.compiler import compile_model
    from propermodel.diagnostics import SimulationError, parse_path
    from propermodel.modelling.removal_words import removal_text
    from propermodel.reduction.prediction import predict_errors
    from propermodel.report.study import StudyOptions, StudySoFar

    subject = configured(
        load_subject(model, scenario),
        until=until,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        settings=settings,
    )
    compiled = compile_model(subject.model)
    so_far = StudySoFar()
    options = StudyOptions(
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        step_tolerance=subject.tolerance,
    )
    with ProgressBars() as bars:
        try:
            full = so_far.run("full", compiled, subject.scenario, options, bars)
            refined = so_far.refine(full, options, bars) if refine else None
        except SimulationError as error:
            if not so_far.runs:
                raise
            print_diagnostics(error.diagnostics)
            raise typer.Exit(INTERRUPTED if so_far.was_interrupted else FAULTS_FOUND) from None
    ranking = rank_activity(full, refined=refined, window=window)
    prediction = predict_errors(full, map(parse_path, output)) if output else None
    if as_json:
        check = ranking.discretisation
        report: dict[str, object] = {
            "model": compiled.model.name,
            "scenario": ranking.scenario,
            "window_s": list(ranking.window),
            "total_activity_J": ranking.total,
            "datums": list(ranking.datums),
            "discretisation_check_points": None if check is None else check.largest_change_points,
            "elements": [
                {
                    "path": str(row.path),
                    "kind": row.kind,
                    "activity_J": row.activity,
                    "index": row.index,
                    "cumulative": row.cumulative,
                }
                for row in ranking.rows
            ],
        }
        if prediction is not None:
            report["predicted_errors"] = [
                {
                    "path": str(row.row),
                    "ways": [
                        {
                            "removals": [removal_text(removal) for removal in way.removals],
                            "rms_over_range": {str(path): error for path, error in way.errors.items()},
                        }
                        for way in row.ways
                    ],
                }
                for row in prediction.rows()
            ]
            report["notes"] = list(prediction.notes)
        typer.echo(json.dumps(report, indent=2))
        return
    screen = Screen()
    screen.print(ranking_table(ranking))
    for note in ranking_notes(ranking):
        screen.print(note)
    if prediction is not None:
        screen.print("", prediction_table(prediction, ranking), *prediction.notes)
