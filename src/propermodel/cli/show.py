"""`propermodel show`: what is in a model."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from propermodel.cli.options import ModelText, SetOption, parse_settings

if TYPE_CHECKING:
    from rich.table import Table
    from rich.tree import Tree

    from propermodel.catalogue.subject import Subject
    from propermodel.cli.tables import Screen
    from propermodel.compiler import CompiledModel
    from propermodel.equations.matrices import SymbolicMatrices
    from propermodel.equations.readable import ReadableEquations
    from propermodel.modelling import Model


class EquationFormat(StrEnum):
    """How equations are printed."""

    TEXT = "text"
    MARKDOWN = "markdown"
    LATEX = "latex"


def show(
    model: ModelText,
    tree: Annotated[bool, typer.Option("--tree", help="Parts inside parts.")] = False,
    causality: Annotated[
        bool, typer.Option("--causality", help="Who sets effort and flow of every bond, and why.")
    ] = False,
    explain: Annotated[bool, typer.Option("--explain", help="With --causality: step by step.")] = False,
    equations: Annotated[bool, typer.Option("--equations", help="The state equations with physical names.")] = False,
    matrices: Annotated[bool, typer.Option("--matrices", help="A linear model as matrices of symbols.")] = False,
    format: Annotated[
        EquationFormat, typer.Option("--format", help="Of equations and matrices.")
    ] = EquationFormat.TEXT,
    parameters: Annotated[bool, typer.Option("--parameters", help="Values, units, and where they are from.")] = False,
    settings: SetOption = None,
) -> None:
    """Show a model: its parts, causality, equations or parameters; or what a run recorded to a file."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.causality.report import explain_causality
    from propermodel.cli.tables import Screen
    from propermodel.compiler import compile_model
    from propermodel.equations.matrices import symbolic_matrices
    from propermodel.equations.readable import state_equations

    screen = Screen()
    if model.endswith(".npz") and not (tree or causality or equations or matrices or parameters):
        _show_run(model, screen)
        return
    subject = load_subject(model)
    if tree or not (causality or equations or matrices or parameters):
        screen.print(_tree(subject.model))
    if not (causality or equations or matrices or parameters):
        return
    compiled = compile_model(subject.model)
    if causality:
        report = explain_causality(compiled)
        typer.echo(f"{report.table()}\n\n{report.explanation()}" if explain else report.text())
    if equations:
        typer.echo(_written(state_equations(compiled), format))
    if matrices:
        typer.echo(_written(symbolic_matrices(compiled), format))
    if parameters:
        screen.print(_parameters(compiled, subject, settings or []))


def _show_run(file: str, screen: Screen) -> None:
    import numpy as np

    from propermodel.cli.tables import plain, table
    from propermodel.simulation.storage import load_trajectory

    run = load_trajectory(file)
    screen.print(plain(f"{run.model.name}, scenario {run.scenario.name}: {run.ending.message}"))
    screen.print(plain(f"{run.statistics.steps} steps of at most {run.step:g} s ({run.method})"))
    for note in run.notes:
        screen.print(plain(f"note: {note}"))
    screen.print(f"{len(run.signals)} rows, {len(run.events)} events")
    made = table("", "recorded", "least", "greatest", "unit", right=("least", "greatest"))
    for path in run.paths if len(run.signals) else ():
        seen = run.overview(path, points=1)
        made.add_row(
            plain(path), f"{np.fmin.reduce(seen.least):.6g}", f"{np.fmax.reduce(seen.greatest):.6g}", run.unit(path)
        )
    screen.print(made)


def _written(what: ReadableEquations | SymbolicMatrices, form: EquationFormat) -> str:
    written = {
        EquationFormat.TEXT: what.text,
        EquationFormat.MARKDOWN: what.markdown,
        EquationFormat.LATEX: what.latex,
    }
    return written[form]().rstrip("\n")


def _tree(model: Model) -> Tree:
    from rich.tree import Tree

    from propermodel.cli.tables import plain
    from propermodel.modelling.removal_words import removal_text

    root = Tree(plain(f"{model.name}  {model.root.definition.type_name}"))
    pending = [(root, model.root.definition)]
    while pending:
        branch, definition = pending.pop()
        for part in definition.parts:
            first = part.definition.doc.strip().partition("\n")[0]
            label = f"{part.name}  {part.definition.type_name}" + (f"  {first}" if first else "")
            pending.append((branch.add(plain(label)), part.definition))
    if model.removals:
        removed = root.add(plain("removals"))
        for removal in model.removals:
            removed.add(plain(removal_text(removal)))
    return root


def _parameters(compiled: CompiledModel, subject: Subject, settings: list[str]) -> Table:
    from propermodel.cli.tables import plain, table
    from propermodel.expressions.core import leaves
    from propermodel.expressions.printing import to_text
    from propermodel.expressions.units import parse_unit
    from propermodel.simulation.start import parameter_values

    given = {**subject.scenario.parameters, **parse_settings(subject, settings)}
    values = parameter_values(compiled, given)
    made = table(
        f"Parameters of {compiled.model.name}",
        "parameter",
        "value",
        "unit",
        "set by",
        "status",
        "source",
        right=("value",),
    )
    for path, parameter in compiled.graph.parameters.items():
        value = values[parameter.symbol] / parse_unit(parameter.unit).factor
        used = leaves(parameter.value)
        rule = "scenario" if path in given else to_text(parameter.value) if used else ""
        # The provenance is that of the declared value, which a surrounding component or the scenario may replace.
        is_declared = path not in given and all(leaf.data.path.parent == path.parent for leaf in used)
        status, source = (parameter.status, parameter.origin) if is_declared else ("", "")
        made.add_row(plain(path), f"{value:.6g}", parameter.unit or "1", plain(rule), status, plain(source))
    return made
