"""What the studio refuses or fails at, as data for its pages."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Sequence
from typing import Any

from propermodel.catalogue.faults import CatalogueError
from propermodel.diagnostics import (
    NO_SOURCE,
    Diagnostic,
    DocumentError,
    Path,
    ProperModelError,
    Source,
    parse_path,
    portable_file,
)

Json = Any

_TOO_LARGE = ("document/size", "document/limit")
_NOT_FOUND = ("command/unknown-model", "command/unknown-scenario", "command/unknown-name", "command/file")


class StudioError(ProperModelError):
    """A request that the studio refuses or cannot fulfil, with the status of HTTP that says so."""

    status: int = 400

    @classmethod
    def with_status(cls, status: int, code: str, message: str, *, help: str = "", where: str = "") -> StudioError:
        """An error with one diagnostic."""
        error = cls([Diagnostic(code, message, where, help=help)])
        error.status = status
        return error


def unexpected(error: Exception) -> StudioError:
    """The error for something that no stage has foreseen, such as an exception in a model's own code."""
    frames = list(traceback.walk_tb(error.__traceback__))
    frame, line = frames[-1] if frames else (None, 0)
    source = Source(portable_file(frame.f_code.co_filename), line) if frame is not None else NO_SOURCE
    help = "the terminal of the studio shows how it came to it; run the model from the command line to see more"
    found = StudioError([Diagnostic("studio/failed", f"{type(error).__name__}: {error}", source=source, help=help)])
    found.status = 500
    return found


class AnswerError(Exception):
    """What a worker answered instead of a result: a status and faults as plain data."""

    def __init__(self, status: int, faults: Sequence[Json]) -> None:
        self.status = status
        self.faults = tuple(faults)
        super().__init__(faults[0]["message"] if faults else "")


def status_of(error: ProperModelError) -> int:
    """The status of HTTP for an error."""
    codes = {diagnostic.code for diagnostic in error.diagnostics}
    if isinstance(error, StudioError):
        return error.status
    if isinstance(error, DocumentError) and codes & set(_TOO_LARGE):
        return 413
    if isinstance(error, CatalogueError) and codes & set(_NOT_FOUND):
        return 404
    return 422


def faults_of(error: ProperModelError) -> list[Json]:
    """The diagnostics of an error as plain data."""
    return [fault_data(diagnostic) for diagnostic in error.diagnostics]


def fault_data(diagnostic: Diagnostic) -> Json:
    """A diagnostic as plain data: the parts of the model that take part are `elements`, by path."""
    where = [parse_path(diagnostic.where)] if diagnostic.where and " " not in diagnostic.where else []
    elements = _distinct([*(parse_path(item.path) for item in diagnostic.involved), *where])
    return {
        "code": diagnostic.code,
        "message": diagnostic.message,
        "place": str(diagnostic.source),
        "elements": elements,
        "help": diagnostic.help,
    }


def error_body(faults: Sequence[Json]) -> Json:
    """The body of an answer that is an error: the first fault, and the others of the same stage."""
    return {"error": {**faults[0], "others": list(faults[1:])}}


def _distinct(paths: Iterable[Path]) -> list[str]:
    return [str(path) for path in dict.fromkeys(paths) if path]
