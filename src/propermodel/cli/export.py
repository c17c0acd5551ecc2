"""`propermodel export`: a model as a document or as a script of Python."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from propermodel.cli.faults import CommandError
from propermodel.cli.options import ModelText


def export(
    model: ModelText,
    out: Annotated[
        FilePath,
        typer.Option(
            "--out", "-o", help="The file: .py for Python, .json for a document.", metavar="FILE", dir_okay=False
        ),
    ],
) -> None:
    """Write a model, with what it does without, as a script of Python that makes it again, or as a document."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.exchange.python import write_python
    from propermodel.modelling.documents import write_model

    writers = {".py": write_python, ".json": write_model}
    if out.suffix not in writers:
        raise CommandError.of(
            "command/export",
            f"'{out.name}' says neither Python nor a document",
            help="name a file that ends with .py or .json: propermodel export truck -o truck.py",
        )
    found = load_subject(model).model
    writers[out.suffix](found, out)
    run = f"; run it with propermodel run {out.as_posix()}:model" if out.suffix == ".py" else ""
    typer.echo(f"{out.as_posix()}: {found.name}{run}")
