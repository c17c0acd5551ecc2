"""Files that somebody names: only regular ones are opened, and only so much is read."""

from __future__ import annotations

import os
import stat
from dataclasses import replace
from pathlib import Path as FilePath
from typing import BinaryIO

from propermodel.diagnostics import DocumentError, ProperModelError, Source, portable_file
from propermodel.modelling.limits import exceeded

FileName = str | os.PathLike[str]


def open_file(path: FileName) -> BinaryIO:
    """A regular file, open for reading.

    Raises:
        DocumentError: there is no such file, it may not be read, or it is a folder, a pipe or a device.
    """
    try:
        # A pipe that nobody writes to must not keep us waiting.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        stream = os.fdopen(number, "rb") if stat.S_ISREG(os.fstat(number).st_mode) else None
    except OSError as error:
        raise _unreadable(error.strerror or str(error)) from error
    except ValueError as error:  # a null character in the path
        raise _unreadable(str(error)) from error
    if stream is None:
        folder = stat.S_ISDIR(os.fstat(number).st_mode)
        os.close(number)
        raise _unreadable("it is a folder" if folder else "it is a pipe or a device")
    return stream


def read_bytes(path: FileName, most: int, limit: str) -> bytes:
    """What a regular file holds, if it has at most `most` bytes; `limit` is the name of that limit.

    Raises:
        DocumentError: the file cannot be read, or is larger.
    """
    with open_file(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        check_size(size, most, limit)
        return stream.read(size)


def check_size(size: int, most: int, limit: str) -> None:
    """Refuse a file of too many bytes."""
    if size > most:
        raise exceeded(limit, f"the file has {size} bytes; at most {most} are read", code="document/size")


def of_file(error: ProperModelError, path: FileName) -> DocumentError:
    """The faults of an error, said of a file."""
    source = Source(portable_file(os.fspath(path)), 0)
    return DocumentError([replace(diagnostic, source=source) for diagnostic in error.diagnostics])


def partial_file(path: FileName) -> FilePath:
    """Where a file is written before it takes the place of another."""
    return FilePath(path).with_name(f"{FilePath(path).name}.part")


def _unreadable(reason: str) -> DocumentError:
    return DocumentError.of("document/file", f"the file cannot be read: {reason}", help="check the path")
