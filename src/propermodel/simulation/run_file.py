"""Reads the file of a run, also of one that is still being written or whose process was killed."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import BinaryIO

import numpy as np

from propermodel.diagnostics import Path, ProperModelError
from propermodel.modelling.documents import SharedEntries, opened
from propermodel.modelling.files import FileName, check_size, of_file, open_file
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import Limits
from propermodel.modelling.schema import FINITE, Json, Place, as_object, malformed
from propermodel.simulation.archives import Member, damaged, is_sound, read_array, scan
from propermodel.simulation.overview import GROUP
from propermodel.simulation.series import FileSeries
from propermodel.simulation.trajectory import Ending, EventRecord, RunStatus, Statistics
from propermodel.simulation.trajectory_format import (
    COLUMNS,
    FORMAT,
    HEADER,
    POWERS,
    PROGRESS,
    VERSION,
    Header,
    StoredProgress,
)


@dataclass(frozen=True, eq=False)
class Contents:
    """Which rows the file of a run holds; what is read of its header by who asks for rows only."""

    start: float  # s
    columns: tuple[tuple[Path, str, int], ...]  # observable, unit, column
    powers: tuple[tuple[str, Path], ...]  # kind and path of each integral


def _read_contents(data: Json, place: Place) -> Contents:
    """The part of a header that tells of rows."""
    given = as_object(data, place)
    scenario = as_object(given.get("scenario"), place.key("scenario"))
    return Contents(
        start=FINITE.read(scenario.get("start", 0.0), place.key("scenario").key("start")),
        columns=COLUMNS.read(given.get("columns"), place.key("columns")),
        powers=POWERS.read(given.get("powers"), place.key("powers")),
    )


@dataclass(frozen=True, eq=False)
class RunRows:
    """The rows of a run in a file: which they are, where, and how far it has come."""

    contents: Contents
    progress: StoredProgress  # with all events
    signals: FileSeries
    integrals: FileSeries
    extremes: FileSeries | None


@dataclass(frozen=True, eq=False)
class RunFile:
    """A run in a file: what is known of it, and where its rows are."""

    header: Header
    rows: RunRows

    @property
    def ending(self) -> Ending:
        """How the run ended, or that the file does not tell."""
        if self.rows.progress.ending is not None:
            return self.rows.progress.ending
        time = self.rows.progress.time
        return Ending(RunStatus.INTERRUPTED, f"the recording was cut off after {time:.6g} s", time)


def read_run(file: FileName, limits: Limits, header: Header | None = None) -> RunFile:
    """What the file of a run holds; of its rows only where they are.

    Args:
        file: The file.
        limits: The most that is read.
        header: Its header, where this process has written it.

    Raises:
        DocumentError: the file cannot be read, is no trajectory of this version, or goes beyond a limit.
    """
    with _about(file) as name, open_file(name) as stream:
        members = _members(stream, limits)
        header = header or _header(stream, members[0], limits)
        contents = Contents(header.scenario.start, header.columns, header.powers)
        return RunFile(header, _rows(name, stream, members, contents, limits))


def read_rows(file: FileName, limits: Limits, contents: Contents | None = None) -> RunRows:
    """Where the rows of a run are, without its model and scenario, which take long to read.

    Args:
        file: The file.
        limits: The most that is read.
        contents: What an earlier reading of the same file, which may have grown since, found in its header.

    Raises:
        DocumentError: the file cannot be read, is no trajectory of this version, or goes beyond a limit.
    """
    with _about(file) as name, open_file(name) as stream:
        members = _members(stream, limits)
        if contents is None:
            top = Place("", SharedEntries(limits))
            contents = _read_contents(opened(_json(stream, members[0], limits), FORMAT, top, VERSION), top)
        return _rows(name, stream, members, contents, limits)


@contextmanager
def _about(file: FileName) -> Generator[FileName]:
    """Says of which file an error is."""
    file = os.path.abspath(os.fspath(file))  # noqa: PTH100 (a Path would make a text of a path in bytes)
    try:
        yield file
    except ProperModelError as error:
        raise of_file(error, file) from error


def _members(stream: BinaryIO, limits: Limits) -> Sequence[Member]:
    members = scan(stream, limits)
    if not members or members[0].name != "header":
        raise damaged("it has no header")
    return members


def _rows(file: FileName, stream: BinaryIO, members: Sequence[Member], contents: Contents, limits: Limits) -> RunRows:
    kept, progress = _reported(stream, members, contents.start, limits)
    return RunRows(contents, progress, *_series(file, kept, contents))


def _header(stream: BinaryIO, member: Member, limits: Limits) -> Header:
    top = Place("", SharedEntries(limits))
    return HEADER.read(opened(_json(stream, member, limits), FORMAT, top, VERSION), top)


def _reported(
    stream: BinaryIO, members: Sequence[Member], start: float, limits: Limits
) -> tuple[Sequence[Member], StoredProgress]:
    """The rows up to the last sound report, and what the reports say together."""
    ends = [place for place, member in enumerate(members) if member.name.startswith("progress/")]
    texts = [_json(stream, members[place], limits) for place in ends[-1:]]
    # Whatever was killed while it was written, or never reached the disk, is at the end.
    if not texts or _progress(texts[0], len(ends) - 1, limits).ending is None:
        while ends and not _is_sound_group(stream, members, ends):
            ends.pop()
    events: list[EventRecord] = []
    told = StoredProgress(time=start, statistics=Statistics(0, 0.0, 0.0))
    for number, place in enumerate(ends):
        if members[place].name != f"progress/{number}":
            raise damaged(f"'progress/{number}' is missing")
        told = _progress(_json(stream, members[place], limits), number, limits)
        events += told.events
    last = ends[-1] if ends else 0
    rows = [member for member in members[1:last] if not member.name.startswith("progress/")]
    return rows, replace(told, events=tuple(events))


def _is_sound_group(stream: BinaryIO, members: Sequence[Member], ends: Sequence[int]) -> bool:
    begin = ends[-2] + 1 if len(ends) > 1 else 0
    return all(is_sound(stream, member) for member in members[begin : ends[-1] + 1])


def _progress(data: Json, number: int, limits: Limits) -> StoredProgress:
    return PROGRESS.read(data, Place(f"progress/{number}", SharedEntries(limits)))


def _json(stream: BinaryIO, member: Member, limits: Limits) -> Json:
    if member.kind != np.uint8 or len(member.shape) != 1:
        raise damaged(f"'{member.name}' is no text")
    check_size(member.size, limits.file_bytes, "file_bytes")
    return parse_json(read_array(stream, member).tobytes(), limits)


def _series(
    file: FileName, members: Iterable[Member], contents: Contents
) -> tuple[FileSeries, FileSeries, FileSeries | None]:
    """The signals, integrals and extremes of a file."""
    parts: dict[str, list[Member]] = {}
    for member in members:
        name, _, number = member.name.partition("/")
        found = parts.setdefault(name, [])
        if number != str(len(found)):
            raise damaged(f"'{name}/{len(found)}' is missing")
        found.append(member)
    columns = 1 + max((column for _, _, column in contents.columns), default=-1)
    stored = parts.pop("signals", [])
    width = stored[0].shape[-1] - 1 if stored else columns
    if width < columns:
        raise malformed("columns", f"expected at least {columns} columns of signals, found {width}")
    signals = _with_levels(file, parts, "signals", _checked(file, stored, width, "signals"), width)
    extremes = None
    if "extremes" in parts:
        intervals = _checked(file, parts.pop("extremes"), 2 * width, "extremes")
        extremes = _with_levels(file, parts, "extremes", intervals, width)
    integrals = _checked(file, parts.pop("integrals", []), 2 * len(contents.powers), "integrals")
    if parts:
        raise damaged(f"it holds '{next(iter(parts))}', which is not known")
    return signals, integrals, extremes


def _with_levels(
    file: FileName, parts: dict[str, list[Member]], base: str, series: FileSeries, width: int
) -> FileSeries:
    """Rows or intervals of so many signals with the levels of their overviews, which are taken from the parts."""
    levels: list[FileSeries] = []
    below = series
    while (name := f"{base}.{len(levels) + 1}") in parts:
        level = _checked(file, parts.pop(name), 2 * width, name)
        if len(level) > len(below) // GROUP:
            raise damaged(f"'{name}' has more groups than there are")
        levels.append(level)
        below = level
    return replace(series, levels=tuple(levels))


def _checked(file: FileName, members: Sequence[Member], width: int, name: str) -> FileSeries:
    for member in members:
        if member.kind != np.float64 or len(member.shape) != 2 or member.shape[0] < 1 or member.shape[1] != 1 + width:
            raise malformed(name, f"expected arrays of {1 + width} columns of numbers, found one of {member.shape}")
    return FileSeries(file, tuple(members), width)
