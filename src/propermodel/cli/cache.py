"""`propermodel cache`: what is kept of compiled code, and where."""

from __future__ import annotations

from typing import Annotated

import typer

from propermodel.cli.faults import CommandError
from propermodel.cli.options import AsJson


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Delete what is kept.")] = False, as_json: AsJson = False
) -> None:
    """Say where compiled code is kept and how much there is, or delete it."""
    import json

    from propermodel.codegen.object_cache import VARIABLE, user_cache

    found = user_cache()
    if found is None:
        typer.echo(json.dumps({"folder": None}) if as_json else f"compiled code is not kept: {VARIABLE} is off")
        return
    try:
        usage = found.clear() if clear else found.usage()
    except OSError as error:
        raise CommandError.of(
            "command/cache",
            f"the cache of compiled code cannot be read or cleared: {error.strerror}",
            help=f"look at {found.folder}, or set {VARIABLE} to another folder or to off",
        ) from None
    if as_json:
        numbers = {"entries": usage.entries, "bytes": usage.size, "most_bytes": found.most_bytes, "cleared": clear}
        typer.echo(json.dumps({"folder": str(found.folder), **numbers}))
        return
    typer.echo(f"folder: {found.folder}")
    what = f"{usage.entries} {'entry' if usage.entries == 1 else 'entries'}, {_megabytes(usage.size)}"
    typer.echo(f"deleted: {what}" if clear else f"kept: {what} of at most {_megabytes(found.most_bytes)}")


def _megabytes(size: int) -> str:
    return f"{size / 2**20:.1f} MiB"
