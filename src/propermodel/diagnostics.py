"""Paths, sources, diagnostics and exceptions: what every room uses to say where and why."""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Self


class Path(tuple[str, ...]):
    """The place of a part or port below the root of a model; printed with dots."""

    __slots__ = ()

    def __truediv__(self, name: str) -> Path:
        return Path((*self, name))

    def __add__(self, other: tuple[str, ...]) -> Path:  # pyright: ignore[reportIncompatibleMethodOverride]
        return Path((*tuple(self), *other))

    @property
    def parent(self) -> Path:
        """The path without its last name."""
        return Path(self[:-1])

    @property
    def name(self) -> str:
        """The last name."""
        return self[-1] if self else ""

    def is_below(self, ancestor: Path) -> bool:
        """Whether this path is `ancestor` or lies inside it."""
        return self[: len(ancestor)] == tuple(ancestor)

    def __str__(self) -> str:
        return ".".join(self)

    def __repr__(self) -> str:
        return f"Path({str(self)!r})"


def parse_path(text: str) -> Path:
    """The path written with dots, `axles[0].hub.flange`."""
    return Path(part for part in text.split(".") if part)


def shortest_endings(paths: Iterable[Path]) -> dict[Path, Path]:
    """Every path by its last names, as many as it takes to tell it from the others."""
    paths = list(paths)
    users: dict[tuple[str, ...], int] = {}
    for path in paths:
        for length in range(1, len(path) + 1):
            ending = path[-length:]
            users[ending] = users.get(ending, 0) + 1
    return {
        path: next((Path(end) for length in range(1, len(path)) if users[end := path[-length:]] == 1), path)
        for path in paths
    }


@dataclass(frozen=True, slots=True)
class Source:
    """Where something was written: file (relative to the project where possible) and line."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else self.file


NO_SOURCE = Source("", 0)
MOST_OFFERED = 8  # names listed where none is near
MOST_COMPARED = 30_000_000  # pairs of letters, some seconds' work


def portable_file(file: str) -> str:
    """A file name that means the same elsewhere: relative to the working directory or an import path.

    A file outside both keeps only its own name, so that no document tells where somebody's home is.
    """
    # Every part that is declared asks: look-ups must be quick where neither folder nor path has changed.
    return _relative_to(file, os.getcwd(), tuple(sys.path))  # noqa: PTH109


@lru_cache(maxsize=4096)
def _relative_to(file: str, here: str, import_path: tuple[str, ...]) -> str:
    path = FilePath(file)
    if not path.is_absolute():
        return path.as_posix() if file else ""
    for base in map(FilePath, (here, *sorted(import_path, key=len, reverse=True))):
        if len(base.parts) > 1 and path.is_relative_to(base):
            return path.relative_to(base).as_posix()
    return path.name


class Severity(StrEnum):
    """How serious a diagnostic is."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Involved:
    """One part that takes part in a fault, and how."""

    path: str
    role: str
    source: Source = NO_SOURCE


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One fault: its code, what is wrong, where, who is involved, and the usual cure."""

    code: str
    message: str
    where: str = ""
    source: Source = NO_SOURCE
    involved: tuple[Involved, ...] = ()
    help: str = ""
    severity: Severity = Severity.ERROR

    def __str__(self) -> str:
        lines = [f"{self.severity}[{self.code}]: {self.message}"]
        place = "  ".join(text for text in (str(self.source), self.where) if text)
        if place:
            lines.append(f"  --> {place}")
        width = max((len(item.path) for item in self.involved), default=0)
        for item in self.involved:
            tail = f"   {item.source}" if str(item.source) else ""
            lines.append(f"      {item.path:<{width}}  {item.role}{tail}".rstrip())
        if self.help:
            lines.append(f"  help: {self.help}")
        return "\n".join(lines)


class ModelWarning(UserWarning):
    """A model can be simulated, but perhaps it is not what its author means; carries the diagnostic that says why."""

    diagnostic: Diagnostic

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(str(diagnostic))


class ProperModelError(Exception):
    """Base of every error of this package; carries the diagnostics it reports."""

    diagnostics: tuple[Diagnostic, ...]

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(item) for item in self.diagnostics))

    @classmethod
    def of(
        cls,
        code: str,
        message: str,
        *,
        where: str = "",
        source: Source = NO_SOURCE,
        involved: Iterable[Involved] = (),
        help: str = "",
    ) -> Self:
        """An error with one diagnostic."""
        return cls([Diagnostic(code, message, where, source, tuple(involved), help)])


class ModelError(ProperModelError):
    """The description of a model is wrong: names, ports, units, connections."""


class UnknownNameError(ModelError, AttributeError):
    """A component or port has nothing of this name; an `AttributeError` too, so that Python's own look-ups work."""


class StructureError(ProperModelError):
    """The bond graph cannot be given causality or equations."""


class DocumentError(ProperModelError):
    """A file is not a document of this package, is damaged, or has another version."""


class SimulationError(ProperModelError):
    """A run was asked for that cannot be made."""


class ReductionError(ProperModelError):
    """A ranking or reduction was asked for that cannot be made."""


@dataclass
class Faults:
    """Collects the diagnostics of a stage, so that it raises once with all of them."""

    error: type[ProperModelError]
    found: list[Diagnostic] = field(default_factory=list)

    def add(self, diagnostic: Diagnostic) -> None:
        """Remember one fault."""
        self.found.append(diagnostic)

    @contextmanager
    def collecting(self) -> Generator[None, None, None]:
        """Remember what is raised inside, and go on after it."""
        try:
            yield
        except self.error as error:
            self.found.extend(error.diagnostics)

    def raise_if_any(self) -> None:
        """Raise all faults found so far, each once."""
        if self.found:
            raise self.error(list(dict.fromkeys(self.found)))


def in_words(number: int) -> str:
    """A small number as it is written in a sentence."""
    return {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}.get(number, str(number))


def nearest(name: str, known: Iterable[str]) -> str:
    """A sentence that offers the nearest known name, or nothing."""
    names = list(known)
    if len(name) * sum(map(len, names)) > MOST_COMPARED:
        return ""
    matches = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    return f"did you mean '{matches[0]}'?" if matches else ""


def one_of(name: str, known: Iterable[str], otherwise: str = "there are none") -> str:
    """A sentence that offers the nearest known name, or a few of those there are."""
    names = list(known)
    rest = f" and {len(names) - MOST_OFFERED} more" if len(names) > MOST_OFFERED else ""
    listed = f"there are {', '.join(names[:MOST_OFFERED])}{rest}" if names else otherwise
    return nearest(name, names) or listed
