"""`propermodel --version`: what a bug report and a measurement need."""

from __future__ import annotations

import typer


def print_version(wanted: bool) -> None:
    """Print versions and leave."""
    if not wanted:
        return
    from propermodel.codegen.versions import versions

    found = versions()
    typer.echo(f"propermodel {found['propermodel']}")
    typer.echo(f"platform {found['platform']}, Python {found['python']}, NumPy {found['numpy']}")
    typer.echo(f"CPU {found['cpu']}")
    typer.echo(f"LLVM {found['llvm']}, llvmlite {found['llvmlite']}")
    raise typer.Exit
