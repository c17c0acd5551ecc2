"""`propermodel draw`: the bond graph of a model as an SVG file."""

from __future__ import annotations

from contextlib import suppress
from enum import StrEnum
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from propermodel.cli.options import (
    JacobianOption,
    MethodOption,
    ModelText,
    ScenarioText,
    SetOption,
    StepOption,
    ToleranceOption,
    Until,
    configured,
)

if TYPE_CHECKING:
    from propermodel.drawing.picture import Picture


class ThemeName(StrEnum):
    """Colours."""

    LIGHT = "light"
    DARK = "dark"


def draw(
    model: ModelText,
    output: Annotated[FilePath, typer.Option("-o", "--output", help="The SVG file to write.", metavar="FILE")],
    depth: Annotated[int, typer.Option("--depth", min=0, help="Levels of the hierarchy that are open.")] = 1,
    open: Annotated[
        list[str] | None, typer.Option("--open", help="A group that is open beside those; again for more.")
    ] = None,
    activity: Annotated[
        bool, typer.Option("--activity", help="Run the scenario, and show activity as fill and width.")
    ] = False,
    scenario: ScenarioText = None,
    until: Until = None,
    method: MethodOption = None,
    step: StepOption = None,
    jacobian_every: JacobianOption = None,
    tolerance: ToleranceOption = None,
    settings: SetOption = None,
    theme: Annotated[ThemeName, typer.Option("--theme", help="Colours.")] = ThemeName.LIGHT,
    signals: Annotated[bool, typer.Option("--signals/--no-signals", help="Draw who has information from whom.")] = True,
    legend: Annotated[bool, typer.Option("--legend/--no-legend", help="Explain the signs.")] = True,
) -> None:
    """Draw the bond graph of a model; of a reduced one everything, with a sign at what is gone.

    A model without causality is drawn too, what contradicts each other in red, and the command ends with its faults.
    """
    from propermodel.analysis.activity import bond_activities, rank_activity
    from propermodel.catalogue.finding import load_subject
    from propermodel.compiler import compile_model
    from propermodel.diagnostics import ProperModelError
    from propermodel.drawing.depict import depict, depict_model
    from propermodel.drawing.svg import to_svg
    from propermodel.simulation.simulate import simulate

    subject = configured(
        load_subject(model, scenario),
        until=until,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=tolerance,
        settings=settings,
    )

    def write(picture: Picture) -> None:
        text = to_svg(picture, depth=depth, open=open or (), theme=theme.value, legend=legend, signals=signals)
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text + "\n", encoding="utf-8")
        typer.echo(f"{output.as_posix()}  {len(picture.nodes)} nodes, {len(picture.bonds)} bonds")

    try:
        compiled = compile_model(subject.model)
    except ProperModelError as error:
        with suppress(ProperModelError):  # there may be no graph to draw
            write(depict_model(subject.model, error.diagnostics))
        raise
    ranking, bonds = None, None
    if activity:
        run = simulate(
            compiled,
            subject.scenario,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            tolerance=subject.tolerance,
            record=[],
        )
        ranking, bonds = rank_activity(run), bond_activities(run)
    write(depict(compiled, ranking, bonds))
