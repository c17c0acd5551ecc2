"""`propermodel linearise`: modes and transfer functions of small deviations from a point."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propermodel.cli.faults import CommandError
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
    configured,
)

if TYPE_CHECKING:
    from propermodel.analysis.linear_model import LinearModel
    from propermodel.catalogue.subject import Subject
    from propermodel.compiler import CompiledModel


def linearise(
    model: ModelText,
    scenario: ScenarioText = None,
    at: Annotated[
        float | None, typer.Option(help="An instant of the scenario, s; its start without this.", metavar="S")
    ] = None,
    equilibrium: Annotated[
        bool, typer.Option("--equilibrium", help="At the equilibrium that the scenario's start leads to.")
    ] = False,
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", help="An input by path; by default those of the scenario.", metavar="PATH"),
    ] = None,
    output: OutputOption = None,
    matrices: Annotated[bool, typer.Option("--matrices", help="Print A, B, C and D too.")] = False,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    tolerance: ToleranceOption = None,
    settings: SetOption = None,
    as_json: AsJson = False,
) -> None:
    """Print modes, and with --output transfer functions, of small deviations from a point."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.tables import Screen
    from propermodel.compiler import compile_model

    if at is not None and equilibrium:
        raise CommandError.of(
            "command/point", "--at and --equilibrium are two points", help="give one of them, or neither for the start"
        )
    subject = configured(
        load_subject(model, scenario),
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        settings=settings,
        outputs=output,
    )
    compiled = compile_model(subject.model)
    linear = _linear_model(compiled, subject, at, equilibrium, inputs)
    if as_json:
        typer.echo(json.dumps(_report(linear), indent=2))
        return
    screen = Screen()
    if matrices:
        screen.print(str(linear))
    else:
        screen.print(f"{compiled.model.name} at {linear.point.time:g} s ({linear.point.description})")
    screen.print(str(linear.modes()))
    if output:
        for name in linear.inputs:
            for path in linear.outputs:
                screen.print("")
                screen.print(str(linear.transfer_function(name, path)))


def _linear_model(
    compiled: CompiledModel, subject: Subject, at: float | None, equilibrium: bool, inputs: list[str] | None
) -> LinearModel:
    from propermodel.analysis.linearise import linearise as linear_model
    from propermodel.simulation.equilibrium import find_equilibrium
    from propermodel.simulation.simulate import simulate

    scenario = subject.scenario
    point: Any = scenario
    if equilibrium:
        point = find_equilibrium(compiled, scenario)
    elif at is not None and at > scenario.start:
        until = replace(scenario, stop=at)
        point = simulate(
            compiled,
            until,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            tolerance=subject.tolerance,
            record=[],
        )
    return linear_model(compiled, point, inputs=inputs or None, outputs=subject.outputs or None)


def _report(linear: LinearModel) -> dict[str, Any]:
    return {
        "time_s": linear.point.time,
        "point": linear.point.description,
        "is_stable": linear.is_stable,
        "states": [str(path) for path in linear.states],
        "inputs": [str(path) for path in linear.inputs],
        "outputs": [str(path) for path in linear.outputs],
        "A": linear.A.tolist(),
        "B": linear.B.tolist(),
        "C": linear.C.tolist(),
        "D": linear.D.tolist(),
        "modes": [
            {
                "eigenvalue": [mode.eigenvalue.real, mode.eigenvalue.imag],
                "frequency_Hz": mode.frequency,
                "damping_ratio": mode.damping_ratio,
                "states": {str(path): share for path, share in mode.states.items()},
            }
            for mode in linear.modes()
        ],
    }
