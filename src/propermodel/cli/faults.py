"""How errors leave the command line: as diagnostics on stderr and an exit code, without a traceback."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from typing import Any, TextIO

import typer
from rich.console import Console
from rich.text import Text
from typer.core import TyperGroup

from propermodel.diagnostics import Diagnostic, ModelWarning, ProperModelError, Severity

FAULTS_FOUND = 1  # the model has faults, or a run failed
MISUSE = 2  # what was asked for cannot be done
INTERRUPTED = 130


class CommandError(ProperModelError):
    """A command was given something it cannot use."""


class Commands(TyperGroup):
    """The group of commands; ends with diagnostics where a command raises an error of this package."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command."""
        try:
            with printed_warnings():
                return super().invoke(ctx)
        except ProperModelError as error:
            print_diagnostics(error.diagnostics)
            raise typer.Exit(MISUSE) from None
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:
            # The reader of a pipe has had enough; Python must not flush into it at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from None
        except OSError as error:
            print_diagnostics(
                [
                    Diagnostic(
                        "command/file", f"{error.strerror or error}: {error.filename or ''}", help="check the path"
                    )
                ]
            )
            raise typer.Exit(MISUSE) from None


@contextmanager
def printed_warnings() -> Generator[None, None, None]:
    """Warnings about a model are printed as errors are, each time."""
    with warnings.catch_warnings():
        show_other = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if isinstance(message, ModelWarning):
                print_diagnostics([message.diagnostic])
            else:
                show_other(message, category, filename, lineno, file, line)

        warnings.simplefilter("always", ModelWarning)
        warnings.showwarning = show
        yield


def print_diagnostics(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics on stderr, each as it stands, with the severity in colour."""
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    for diagnostic in diagnostics:
        text = Text(str(diagnostic))
        colour = "red" if diagnostic.severity is Severity.ERROR else "yellow"
        text.stylize(f"bold {colour}", 0, str(diagnostic).find(":"))
        console.print(text)
