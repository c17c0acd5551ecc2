"""`propermodel rank`: which elements matter in a scenario, by activity and for outputs."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from propermodel.cli.faults import CommandError
from propermodel.cli.options import (
    AsJson,
    JacobianOption,
    MethodOption,
    ModelText,
    OutputOption,
    SetOption,
    StepOption,
    ToleranceOption,
    Until,
    configured,
)
from propermodel.cli.rank_windows import parse_windows

if TYPE_CHECKING:
    from propermodel.analysis.ranking import ActivityRanking
    from propermodel.catalogue.finding import Subject
    from propermodel.compiler import CompiledModel
    from propermodel.modelling.model import Scenario
    from propermodel.reduction.prediction import Prediction
    from propermodel.simulation.equilibrium import Equilibrium


class Point(StrEnum):
    """About what storage is measured."""

    EQUILIBRIUM = "equilibrium"  # of the first scenario
    START = "start"


def rank(
    model: ModelText,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            "--scenario",
            help="A name, file.py:function, or the JSON document of a scenario; given more than once, all are ranked.",
            metavar="SCENARIO",
        ),
    ] = None,
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
    windows: Annotated[
        str | None,
        typer.Option(
            help='Windows ranked by themselves: how many, their length ("10 s"), or pairs: 0:5,20:22.',
            metavar="N|LENGTH|PAIRS",
        ),
    ] = None,
    threshold: Annotated[
        float | None, typer.Option(help="Tell what is kept at this share of the activity.", min=0.0, max=1.0)
    ] = None,
    map_file: Annotated[
        FilePath | None,
        typer.Option(
            "--map",
            help="Rank what another tool has recorded: MODEL is its CSV, Parquet or netCDF file, and this TOML file "
            "gives its columns to elements.",
            metavar="FILE",
        ),
    ] = None,
    refine: Annotated[
        bool,
        typer.Option("--refine/--no-refine", help="Check with a run at half the step, or a tenth of the tolerance."),
    ] = True,
    about: Annotated[
        Point | None,
        typer.Option(help="Measure storage about this point: a spring that carries a weight counts by how it moves."),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option("--about-of", help="Only storage of this part or element; may be given again.", metavar="PATH"),
    ] = None,
    frequencies: Annotated[
        str | None,
        typer.Option(
            help="Rank small deviations from a point by frequency responses, without simulation; in Hz.",
            metavar="FROM:TO[:COUNT]",
        ),
    ] = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            help="With --frequencies: what moves the model, and its spectral density; may be given again.",
            metavar="PATH[=DENSITY]",
        ),
    ] = None,
    bonds: Annotated[
        bool,
        typer.Option("--bonds", help="Rank every bond, and each among those of its junctions; tell idle junctions."),
    ] = False,
    as_json: AsJson = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print CSV in place of tables.")] = False,
) -> None:
    """Rank the energy elements of a model by activity, and with --output by what their removal would change.

    Several scenarios and windows are ranked each by itself, too: rows are sorted by their largest index. With --map,
    efforts and flows that another tool has recorded are ranked; with --frequencies, small deviations.
    """
    wanted = None if windows is None else parse_windows(windows)
    if map_file is not None:
        from propermodel.cli.rank_recorded import rank_file

        _show(rank_file(model, map_file, wanted), threshold, None, {"recording": model}, as_json, as_csv)
        return
    from propermodel.analysis.activity import rank_activity
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.rank_runs import runs_of
    from propermodel.compiler import compile_model
    from propermodel.diagnostics import parse_path
    from propermodel.reduction.prediction import predict_errors

    subjects = [
        configured(
            load_subject(model, name),
            until=until,
            method=method,
            step=step,
            jacobian_every=jacobian_every,
            tolerance=tolerance,
            settings=settings,
        )
        for name in (scenario or [None])
    ]
    compiled = compile_model(subjects[0].model)
    if frequencies is not None:
        from propermodel.cli.rank_frequencies import rank_between

        found = rank_between(compiled, _point(compiled, subjects[0], about), frequencies, inputs)
        _show(found, threshold, None, {"model": compiled.model.name}, as_json, as_csv)
        return
    compiled = _measured(compiled, subjects[0], about, of)
    found = runs_of(compiled, subjects, window, wanted, refine)
    if bonds:
        from propermodel.cli.rank_bonds import show_bonds

        show_bonds(found, window, as_json, as_csv)
        return
    ranking = rank_activity(found.runs, refined=found.refined, window=window, windows=wanted)
    prediction = predict_errors(found.runs[0], map(parse_path, output)) if output else None
    _show(ranking, threshold, prediction, {"model": compiled.model.name}, as_json, as_csv)


def _measured(compiled: CompiledModel, subject: Subject, about: Point | None, of: list[str] | None) -> CompiledModel:
    """The model that measures storage about a point, where one is asked for."""
    if about is None and of:
        raise CommandError.of(
            "command/about", "--about-of needs a point", help="say about what: --about equilibrium, or --about start"
        )
    if about is None:
        return compiled
    from propermodel.analysis.datum import measure_about

    return measure_about(compiled, _point(compiled, subject, about), of=of or None)


def _point(compiled: CompiledModel, subject: Subject, about: Point | None) -> Scenario | Equilibrium:
    """The start of the scenario, or the equilibrium that it leads to."""
    from propermodel.simulation.equilibrium import find_equilibrium

    return find_equilibrium(compiled, subject.scenario) if about is Point.EQUILIBRIUM else subject.scenario


def _show(
    ranking: ActivityRanking,
    threshold: float | None,
    prediction: Prediction | None,
    of_what: dict[str, object],
    as_json: bool,
    as_csv: bool,
) -> None:
    """Print a ranking in the form that is asked for."""
    from propermodel.cli.ranking_report import prediction_report, ranking_report, write_ranking_csv
    from propermodel.cli.tables import Screen, prediction_table, ranking_notes, ranking_table

    kept = None if threshold is None else [str(row.path) for row in ranking.kept_by(threshold)]
    if as_csv:
        write_ranking_csv(ranking)
        return
    if as_json:
        report = {**of_what, **ranking_report(ranking)}
        if kept is not None:
            report |= {"threshold": threshold, "kept": kept}
        if prediction is not None:
            report["predicted_errors"] = prediction_report(prediction)
            report["notes"] = [*ranking.notes, *prediction.notes]
        typer.echo(json.dumps(report, indent=2))
        return
    screen = Screen()
    screen.print(ranking_table(ranking), *ranking_notes(ranking))
    if kept is not None:
        screen.print(f"a threshold of {threshold:g} keeps {len(kept)} of {len(ranking.rows)}: {', '.join(kept)}")
    if prediction is not None:
        screen.print("", prediction_table(prediction, ranking), *prediction.notes)
