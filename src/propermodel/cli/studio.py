"""`propermodel studio`: see models, run and reduce them in the browser."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path as FilePath
from typing import Annotated
from urllib.parse import quote

import typer

from propermodel.cli.faults import CommandError


def studio(
    what: Annotated[
        str,
        typer.Argument(
            metavar="[FOLDER|MODEL]",
            help="The folder with models, by default the working directory; or a model as other commands take it.",
        ),
    ] = ".",
    port: Annotated[int, typer.Option(help="Where to listen; by default a free port.", min=0, max=65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Open a page, served from this machine alone, to see models, run them and reduce them."""
    from importlib.util import find_spec

    if find_spec("starlette") is None or find_spec("uvicorn") is None:
        raise CommandError.of(
            "command/studio",
            "the studio needs packages that are not installed",
            help='install them with: pip install "propermodel[studio]"',
        )
    from propermodel.studio.server import listening

    folder, model = served(what)

    with listening(folder, port=port) as server:
        view = f"#/model?model={quote(model, safe='')}" if model else ""
        typer.echo(
            f"propermodel studio of {folder}, for this machine alone; Ctrl-C ends it\n{server.door.address}{view}"
        )
        if browser:
            import webbrowser

            webbrowser.open(server.door.address_for_once() + view)
        with suppress(KeyboardInterrupt):  # how it is meant to end
            server.answer()
    typer.echo("the studio has ended; its runs are kept")


def served(what: str) -> tuple[FilePath, str]:
    """The folder to serve and the model to open, if one is named."""
    from propermodel.catalogue.named import NAMED_MODELS

    path = FilePath(what)
    if path.is_dir():
        return path.resolve(), ""
    if what in NAMED_MODELS:
        return FilePath.cwd(), what
    file, mark, member = what.rpartition(":")
    name, member = (file, f":{member}") if mark and file.endswith(".py") else (what, "")
    path = FilePath(name).resolve()
    if not path.is_file() or path.suffix not in (".py", ".json"):
        raise CommandError.of(
            "command/studio",
            f"'{what}' is no folder and no model",
            help=f"give a folder, {', '.join(NAMED_MODELS)}, file.py:Class, or a JSON document",
        )
    here = FilePath.cwd()
    folder = here if path.is_relative_to(here) else path.parent
    return folder, path.relative_to(folder).as_posix() + member
