"""Arrays in `.npz` archives: read member by member, with their sizes known before anything is unpacked.

An archive is a ZIP file of `.npy` members. Only what `numpy.savez` writes of bytes and of floating-point numbers is
read: no objects, hence no pickles, and no header that has to be evaluated.
"""

from __future__ import annotations

import math
import re
import struct
import zipfile
import zlib
from collections.abc import Mapping
from typing import IO, Any, BinaryIO

import numpy as np
import numpy.typing as npt

from propermodel.diagnostics import DocumentError
from propermodel.modelling.limits import exceeded

Array = npt.NDArray[Any]

_MAGIC = b"\x93NUMPY\x01\x00"
_HEADER = re.compile(
    rb"\{'descr': '([<>|][fu]\d)', 'fortran_order': (True|False), 'shape': \((\d+(?:, \d+)*),?\), \} *\n"
)
_KINDS = {b"<f8": np.dtype("<f8"), b">f8": np.dtype(">f8"), b"|u1": np.dtype("u1")}
_END = struct.Struct("<4s4H2LH")  # the end of a ZIP file
_LOCATOR_BYTES = 20  # before the end, where a directory of ZIP64 is announced
_LARGEST_DIRECTORY = 4096  # bytes
_CHUNK = 2**20  # bytes


def read_arrays(stream: BinaryIO, names: tuple[str, ...], most_bytes: int) -> Mapping[str, Array]:
    """The arrays of these names, which are all that the archive holds.

    Raises:
        DocumentError: the file is no such archive, or unpacks to more bytes than are allowed.
    """
    try:
        _check_directory(stream)
        with zipfile.ZipFile(stream) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            if sorted(members) != sorted(names) or len(archive.infolist()) != len(names):
                raise _damaged(f"it holds {_listed(list(members))}, not {_listed(list(names))}")
            size = sum(info.file_size for info in members.values())
            if size > most_bytes:
                raise exceeded(
                    "trajectory_bytes",
                    f"the file unpacks to {size} bytes; at most {most_bytes} are read",
                    code="document/size",
                )
            return {name: _read_array(archive, members[name], name) for name in names}
    except (OSError, EOFError, ValueError, RuntimeError, struct.error, zipfile.BadZipFile, zlib.error) as error:
        # RuntimeError: encrypted, or compressed in a way that is not known here.
        raise _damaged(f"{error}") from error


def _check_directory(stream: BinaryIO) -> None:
    """The directory of the archive must be as small as ours, because it is read as a whole."""
    length = stream.seek(0, 2)
    stream.seek(max(0, length - _END.size - _LOCATOR_BYTES))
    tail = stream.read()
    if len(tail) < _END.size:
        raise _damaged("it is too short")
    mark, *_, directory, _, comment = _END.unpack(tail[-_END.size :])
    if mark != b"PK\x05\x06" or comment:
        raise _damaged("its end is missing")
    if directory > _LARGEST_DIRECTORY or tail.startswith(b"PK\x06\x07"):
        raise _damaged("its directory is too large")


def _read_array(archive: zipfile.ZipFile, info: zipfile.ZipInfo, name: str) -> Array:
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise _damaged(f"'{name}' is packed in a way that is not read here")
    with archive.open(info) as member:
        start = member.read(len(_MAGIC) + 2)
        if not start.startswith(_MAGIC):
            raise _damaged(f"'{name}' is no array")
        header = _HEADER.fullmatch(member.read(int.from_bytes(start[-2:], "little")))
        kind = _KINDS.get(header[1]) if header else None
        if header is None or kind is None:
            raise _damaged(f"'{name}' is no array of numbers")
        shape = tuple(map(int, header[3].split(b",")))
        if member.tell() + math.prod(shape) * kind.itemsize != info.file_size:
            raise _damaged(f"'{name}' has another size than its shape tells")
        found = np.empty(shape, kind, order="F" if header[2] == b"True" else "C")
        _fill(found, member)
        return found.astype(kind.newbyteorder("="), copy=False)


def _fill(array: Array, member: IO[bytes]) -> None:
    target = array.reshape(-1, order="A").view(np.uint8)
    done = 0
    while done < len(target):
        chunk = member.read(min(_CHUNK, len(target) - done))
        if not chunk:
            raise EOFError("it is cut off")
        target[done : done + len(chunk)] = np.frombuffer(chunk, np.uint8)
        done += len(chunk)
    member.read()  # nothing is left; the checksum is looked at here


def _listed(names: list[str]) -> str:
    shown = ", ".join(ascii(name[:40]) for name in names[:8])
    return f"{shown} and {len(names) - 8} more" if len(names) > 8 else shown or "nothing"


def _damaged(reason: str) -> DocumentError:
    return DocumentError.of(
        "document/archive",
        f"the file cannot be read as a trajectory: {reason}",
        help="open a file that save_trajectory wrote, complete and unchanged",
    )
