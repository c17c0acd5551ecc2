"""`propermodel sensitivities`: what parameters change in a scenario."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propermodel.cli.faults import FAULTS_FOUND
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
    from propermodel.analysis.sensitivities import Sensitivities
    from propermodel.simulation.tangent_run import Along


def sensitivities(
    model: ModelText,
    scenario: ScenarioText = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", help="A parameter by path: body.mass.", metavar="PATH")
    ] = None,
    output: OutputOption = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    settings: SetOption = None,
    equilibrium: Annotated[
        bool, typer.Option("--equilibrium", help="Begin at the equilibrium that the scenario's start leads to.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Say how outputs, activities and their indices change with parameters."""
    from propermodel.analysis.sensitivities import sensitivities as find_sensitivities
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.tables import Screen
    from propermodel.compiler import compile_model

    subject = configured(
        load_subject(model, scenario),
        until=until,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        settings=settings,
        outputs=output,
    )
    found = find_sensitivities(
        compile_model(subject.model),
        subject.scenario,
        parameters=parameter or [],
        outputs=subject.outputs,
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        record_every=subject.scenario.stop - subject.scenario.start,
        start="equilibrium" if equilibrium else "declared",
    )
    if as_json:
        typer.echo(json.dumps(_report(found), indent=2))
    else:
        Screen().print(str(found))
    if not found.ending.is_complete:
        raise typer.Exit(FAULTS_FOUND)


def _report(found: Sensitivities) -> dict[str, Any]:
    indices = found.indices
    return {
        "model": found.compiled.model.name,
        "scenario": found.scenario.name,
        "status": found.ending.status.value,
        "message": found.ending.message,
        "notes": list(found.notes),
        "parameters": [
            {"path": str(path), "value": float(value), "unit": unit}
            for path, value, unit in zip(found.parameters, found.parameter_values, found.parameter_units, strict=True)
        ],
        "outputs": [
            {"path": str(path), "unit": unit, **_entry(found, found.final, i)}
            for i, (path, unit) in enumerate(zip(found.outputs, found.output_units, strict=True))
        ],
        "elements": [
            {
                "path": str(path),
                "work_J": _entry(found, found.row_work, i),
                "activity_J": _entry(found, found.row_activity, i),
                "index": _entry(found, indices, i),
            }
            for i, path in enumerate(found.rows)
        ],
    }


def _entry(found: Sensitivities, quantity: Along, place: int) -> dict[str, Any]:
    """A value, and its derivatives in the order of the parameters; numbers that are none as null."""
    return {
        "value": _number(quantity.values[place]),
        "derivatives": [_number(slope) for slope in quantity.slopes[place]],
        "relative": [_number(slope) for slope in found.relative(quantity)[place]],
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
