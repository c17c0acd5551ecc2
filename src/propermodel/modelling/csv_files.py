"""Two columns of a CSV file, read line by line, with line and column in every complaint."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import BinaryIO

from propermodel.diagnostics import MOST_OFFERED, ModelError, Source, nearest, portable_file
from propermodel.modelling.files import FileName, check_size, open_file
from propermodel.modelling.limits import Limits, exceeded


@dataclass(frozen=True, slots=True)
class Columns:
    """Times and values as they stand in a file, with the headers of their columns."""

    times: list[float]
    values: list[float]
    time_header: str
    value_header: str


def read_columns(path: FileName, column: str | None, time: str | None, limits: Limits) -> Columns:
    """The column of values, by default the other of two, over the column of times, by default the first.

    Raises:
        DocumentError: the file cannot be read, or goes beyond a limit.
        ModelError: it is no CSV file, has no such column, or what stands there is no number or no time that grows.
    """
    name = portable_file(os.fspath(path))
    with open_file(path) as stream:
        check_size(os.fstat(stream.fileno()).st_size, limits.file_bytes, "file_bytes")
        rows = _rows(stream, name, limits)
        headers = [header.strip() for header in next(rows, (0, []))[1]]
        if not headers:
            raise _short(name)
        places = pick(headers, time, 0), pick(headers, column, 1 if len(headers) == 2 else None)
        found = Columns([], [], *(headers[place] for place in places))
        for line, row in rows:
            _add(found, row, places, headers, Source(name, line))
            if len(found.times) > limits.table_points:
                raise exceeded("table_points", f"more than {limits.table_points} rows")
    if len(found.times) < 2:
        raise _short(name)
    return found


def _rows(stream: BinaryIO, name: str, limits: Limits) -> Iterator[tuple[int, list[str]]]:
    """The rows that are not empty, with their lines; a row is one line, so that none grows without end."""
    line = 0
    try:
        while data := stream.readline(limits.text_characters + 1):
            line += 1
            if len(data) > limits.text_characters:
                raise exceeded("text_characters", f"line {line} has more than {limits.text_characters} characters")
            row = next(csv.reader([data.decode("utf-8-sig" if line == 1 else "utf-8")], strict=True))
            if any(row):
                yield line, row
    except UnicodeDecodeError:
        raise _no_csv(f"line {line} is not text in UTF-8", Source(name, line)) from None
    except csv.Error as error:
        raise _no_csv(f"line {line} cannot be read: {error}", Source(name, line)) from None


def _add(found: Columns, row: list[str], places: tuple[int, int], headers: list[str], source: Source) -> None:
    time, value = (_number(row, place, headers, source) for place in places)
    if found.times and not time > found.times[-1]:
        raise ModelError.of(
            "data/time",
            f"the time {time:g} in line {source.line} of '{source.file}' does not follow {found.times[-1]:g}",
            source=source,
            help="sort the lines by time, and leave out those that are there twice",
        )
    found.times.append(time)
    found.values.append(value)


def _number(row: list[str], place: int, headers: list[str], source: Source) -> float:
    text = row[place].strip() if place < len(row) else ""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ModelError.of(
            "data/number",
            f"line {source.line} of '{source.file}' has {ascii(text[:40]) if text else 'nothing'} in column "
            f"{_shown(headers[place])}, where a number is due",
            source=source,
            help="correct the line, or leave it out: what is missing is interpolated",
        )
    return number


def pick(headers: Sequence[str], name: str | None, default: int | None) -> int:
    """The place of the column of this name, with or without its unit.

    Raises:
        ModelError: there is none, or no name was given and there is no default.
    """
    if name is None and default is not None and default < len(headers):
        return default
    for index, header in enumerate(headers):
        if name in (header, _name_of(header)):
            return index
    more = f" and {len(headers) - MOST_OFFERED} more" if len(headers) > MOST_OFFERED else ""
    known = ", ".join(map(_shown, headers[:MOST_OFFERED])) + more
    raise ModelError.of(
        "data/column",
        f"there is no column '{name}'; there are {known}" if name else f"there are several columns: {known}",
        help=nearest(name or "", headers) or "say which column: measured(file, column)",
    )


def unit_of(header: str) -> str:
    """The unit in a header such as `speed [km/h]`."""
    opening, closing = header.rfind("["), header.rfind("]")
    return header[opening + 1 : closing].strip() if 0 <= opening < closing else ""


def _name_of(header: str) -> str:
    return header.split("[", maxsplit=1)[0].strip()


def _shown(header: str) -> str:
    short = header[:40]
    return f"'{short}'" if short.isprintable() else ascii(short)


def _short(name: str) -> ModelError:
    return ModelError.of(
        "data/short",
        f"'{name}' has fewer than two rows of data",
        source=Source(name, 0),
        help="a CSV file has a line of names and two or more lines of numbers",
    )


def _no_csv(message: str, source: Source) -> ModelError:
    return ModelError.of(
        "data/csv",
        message,
        source=source,
        help="save the table as CSV in UTF-8: a line of names, then lines of numbers, with commas between",
    )
