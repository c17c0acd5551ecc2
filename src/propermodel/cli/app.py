"""Puts the commands together, and prints errors for the person who can fix them."""

from __future__ import annotations

from typing import Annotated

import typer

from propermodel.cli.cache import cache
from propermodel.cli.check import check
from propermodel.cli.compare_methods import compare_methods
from propermodel.cli.demo import demo
from propermodel.cli.draw import draw
from propermodel.cli.export import export
from propermodel.cli.faults import Commands
from propermodel.cli.linearise import linearise
from propermodel.cli.partition import partition
from propermodel.cli.rank import rank
from propermodel.cli.reduce import reduce
from propermodel.cli.report import report
from propermodel.cli.run import run
from propermodel.cli.sensitivities import sensitivities
from propermodel.cli.show import show
from propermodel.cli.studio import studio
from propermodel.cli.verify import verify
from propermodel.cli.version import print_version

app = typer.Typer(
    name="propermodel",
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", help="Say which versions are used.", callback=print_version, is_eager=True)
    ] = False,
) -> None:
    """Physical models from bond graphs, and the simplest of them whose answers are still good."""


app.command()(reduce)
app.command()(verify)
app.command()(compare_methods)
app.command()(run)
app.command()(rank)
app.command()(partition)
app.command()(linearise)
app.command()(sensitivities)
app.command()(show)
app.command()(draw)
app.command()(report)
app.command()(export)
app.command()(check)
app.command()(studio)
app.command()(demo)
app.command()(cache)
