"""`propermodel run`: simulate a scenario."""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import Annotated

import typer

from propermodel.cli.faults import FAULTS_FOUND, INTERRUPTED
from propermodel.cli.options import (
    AsJson,
    JacobianOption,
    MethodOption,
    ModelText,
    OutFolder,
    OutputOption,
    ScenarioText,
    SetOption,
    StepOption,
    ToleranceOption,
    UntilCondition,
    configured,
    end_of,
)


def run(
    model: ModelText,
    scenario: ScenarioText = None,
    until: UntilCondition = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    tolerance: ToleranceOption = None,
    output: OutputOption = None,
    settings: SetOption = None,
    record_every: Annotated[float | None, typer.Option(help="Period of recording, s.", metavar="S")] = None,
    record_to: Annotated[
        FilePath | None,
        typer.Option(
            help="A file (.npz) to which rows go as they are made, for long runs; it can be shown meanwhile.",
            metavar="FILE",
            dir_okay=False,
        ),
    ] = None,
    record_extremes: Annotated[
        bool,
        typer.Option(
            "--record-extremes",
            help="Keep the least and greatest values between rows, from every step, so that no peak is lost.",
        ),
    ] = False,
    out: OutFolder = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a scenario; print how it went, and write what was recorded as CSV and npz."""
    from propermodel.analysis.balance import energy_balance
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import Screen, plain, table
    from propermodel.compiler import compile_model
    from propermodel.report.options import StudyOptions, check_outputs
    from propermodel.simulation.simulate import simulate
    from propermodel.simulation.storage import save_trajectory
    from propermodel.simulation.trajectory import RunStatus

    stop, condition = end_of(until)
    subject = configured(
        load_subject(model, scenario),
        until=stop,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        settings=settings,
        outputs=output,
    )
    compiled = compile_model(subject.model)
    check_outputs(compiled, subject.outputs)
    period = record_every or StudyOptions(method=subject.method, step=subject.step).record_every(subject.scenario)
    with ProgressBars() as bars:
        answer = simulate(
            compiled,
            subject.scenario,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            tolerance=subject.tolerance,
            record_every=period,
            record_to=record_to,
            record_extremes=record_extremes,
            until=condition,
            progress=lambda progress: bars("simulating", progress),
        )
    shown = subject.outputs or tuple(state.path for state in compiled.system.states)
    balance = energy_balance(answer)
    files = [] if record_to is None else [record_to.as_posix()]
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        save_trajectory(answer, out / "trajectory.npz")
        answer.to_csv(out / "outputs.csv", shown)
        files += [(out / name).as_posix() for name in ("trajectory.npz", "outputs.csv")]
    if as_json:
        values = {
            str(path): {"unit": answer.unit(path), "start": answer.at_start(path), "end": answer.at_end(path)}
            for path in shown
        }
        report = {
            "model": compiled.model.name,
            "scenario": subject.scenario.name,
            "status": answer.ending.status.value,
            "message": answer.ending.message,
            "time_s": answer.ending.time,
            "method": answer.method.value,
            "steps": answer.statistics.steps,
            "rejected": answer.statistics.rejected,
            "notes": list(answer.notes),
            "wall_s": answer.statistics.wall_s,
            "energy_balance_residual": balance.relative_residual,
            "outputs": values,
        }
        typer.echo(json.dumps(report, indent=2))
    else:
        screen = Screen()
        screen.print(str(answer))
        screen.print(str(balance))
        for use in answer.outside_tables:
            screen.print(f"outside the table {use.path} for {use.seconds:.3g} s")
        made = table(
            "", "output", "start", "end", "least", "greatest", "unit", right=("start", "end", "least", "greatest")
        )
        for path in shown:
            ends = answer.at_start(path), answer.at_end(path)
            seen = answer.overview(path, points=1)
            numbers = (*ends, min(*ends, *seen.least.tolist()), max(*ends, *seen.greatest.tolist()))
            made.add_row(plain(path), *(f"{number:.6g}" for number in numbers), answer.unit(path))
        screen.print(made)
        for file in files:
            screen.print(file)
    if answer.ending.status is RunStatus.INTERRUPTED:
        raise typer.Exit(INTERRUPTED)
    if not answer.ending.is_complete:
        raise typer.Exit(FAULTS_FOUND)
