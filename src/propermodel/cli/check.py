"""`propermodel check`: is the model sound."""

from __future__ import annotations

import typer

from propermodel.cli.faults import FAULTS_FOUND, print_diagnostics
from propermodel.cli.options import ModelText


def check(model: ModelText) -> None:
    """Elaborate and compile a model, and print every fault and warning."""
    from propermodel.catalogue.faults import CatalogueError
    from propermodel.catalogue.finding import load_subject
    from propermodel.compiler import compile_model
    from propermodel.diagnostics import ProperModelError

    try:
        compiled = compile_model(load_subject(model).model)
    except CatalogueError:
        raise
    except ProperModelError as error:
        print_diagnostics(error.diagnostics)
        count = len(error.diagnostics)
        typer.echo(f"{count} fault{'s' if count > 1 else ''}", err=True)
        raise typer.Exit(FAULTS_FOUND) from None
    system = compiled.system
    count = len(compiled.warnings)
    warned = f", {count} warning{'s' if count > 1 else ''}" if count else ""
    typer.echo(f"{compiled.model.name}: no faults{warned}")
    typer.echo(
        f"{len(compiled.graph.normal.elements)} elements, {len(system.rows)} of them rows of a ranking, "
        f"{len(compiled.graph.normal.bonds)} bonds, {len(system.states)} states"
    )
    dependent = ", ".join(str(path) for path in system.causal.derivative)
    typer.echo(f"dependent storage: {dependent or 'none'}")
    loops = sum(len(block.unknowns) for block in system.blocks)
    typer.echo(f"unknowns solved by Newton's method: {loops or 'none'}")
