"""`propermodel partition`: which parts drive others without feeling them."""

from __future__ import annotations

import json
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


def partition(
    model: ModelText,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    settings: SetOption = None,
    output: OutputOption = None,
    junction_tolerance: Annotated[
        float, typer.Option(help="Largest share of a neglected term at its junction.", min=0.0)
    ] = 0.1,
    apart: Annotated[
        bool, typer.Option("--apart", help="Run the parts one after the other, each driven by recorded signals.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Find driving and driven parts of a model, and measure what one-way cuts do to its outputs."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.compiler import compile_model
    from propermodel.reduction.part_runs import simulate_parts
    from propermodel.reduction.partition import partition as find_parts
    from propermodel.simulation.simulate import simulate

    subject = configured(
        load_subject(model, scenario),
        until=until,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        settings=settings,
        outputs=output,
    )
    window = subject.scenario.stop - subject.scenario.start
    full = simulate(
        compile_model(subject.model),
        subject.scenario,
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        tolerance=subject.tolerance,
        record_every=window / 2000.0,
        integrals_every=window,
    )
    found = find_parts(full, tolerance=junction_tolerance, outputs=subject.outputs)
    runs = simulate_parts(found, full) if apart else None
    if as_json:
        document = found.document()
        if runs is not None:
            document["errors_apart"] = {str(error.path): error.rms for error in runs.errors}
        typer.echo(json.dumps(document, indent=2))
        return
    typer.echo(str(found))
    if runs is not None:
        typer.echo(f"run one after the other:\n{runs}")
