"""`propermodel activity`: which elements matter in a scenario."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from propermodel.cli.faults import FAULTS_FOUND, INTERRUPTED, print_diagnostics
from propermodel.cli.options import (
    AsJson,
    MethodOption,
    ModelText,
    ScenarioText,
    SetOption,
    StepOption,
    Until,
    configured,
)


def activity(
    model: ModelText,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    settings: SetOption = None,
    window: Annotated[
        tuple[float, float] | None, typer.Option(help="The part of the run to rank, s.", metavar="FROM TO")
    ] = None,
    refine: Annotated[bool, typer.Option("--refine/--no-refine", help="Check with a run at half the step.")] = True,
    as_json: AsJson = False,
) -> None:
    """Rank the energy elements of a model by their activity in a scenario."""
    from propermodel.analysis.activity import rank_activity
    from propermodel.cli.models import load_subject
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import console, ranking_notes, ranking_table
    from propermodel.compiler import compile_model
    from propermodel.report.study import IncompleteStudy
    from propermodel.simulation.simulate import simulate
    from propermodel.simulation.trajectory import Trajectory

    subject = configured(load_subject(model, scenario), until=until, method=method, step=step, settings=settings)
    compiled = compile_model(subject.model)
    span = subject.scenario.stop - subject.scenario.start
    runs: dict[str, Trajectory] = {}
    with ProgressBars() as bars:
        for name, part in {"full": 1.0, "refined": 0.5}.items() if refine else {"full": 1.0}.items():
            runs[name] = simulate(
                compiled,
                subject.scenario,
                method=subject.method,
                step=subject.step * part,
                record=(),
                integrals_every=max(subject.step, min(1.0, span / 1000.0)),
                progress=lambda progress, name=name: bars(name, progress),
            )
            if not runs[name].ending.is_complete:
                error = IncompleteStudy.after(runs)
                print_diagnostics(error.diagnostics)
                raise typer.Exit(INTERRUPTED if error.was_interrupted else FAULTS_FOUND)
    ranking = rank_activity(runs["full"], refined=runs.get("refined"), window=window)
    if as_json:
        check = ranking.discretisation
        report = {
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
        typer.echo(json.dumps(report, indent=2))
        return
    screen = console()
    screen.print(ranking_table(ranking))
    for note in ranking_notes(ranking):
        screen.print(note, markup=False)
