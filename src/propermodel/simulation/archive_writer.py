"""Writes arrays into an `.npz` archive one by one, so that all that was written can be read whatever happens next.

Each array is a member of a ZIP file with its sizes and checksum in front of it, and reaches the operating system before
the next is begun: a process that is killed leaves a file that `archives.py` reads up to there. The directory of the
archive, with which other programs open it, is written at the end. The same arrays give the same bytes.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

# What stands in front of a member: mark, version, flags, method, time, date, checksum, both sizes, length of its name
# and of what else is told. PKWARE, APPNOTE.TXT - .ZIP File Format Specification, 6.3.10, 4.3.7.
LOCAL = struct.Struct("<4s5H3L2H")
LOCAL_MARK = b"PK\x03\x04"
STORED = 0

_ENTRY = struct.Struct("<4s6H3L5H2L")  # of the directory, 4.3.12
_END_64 = struct.Struct("<4sQ2H2L4Q")  # 4.3.14
_LOCATOR_64 = struct.Struct("<4sLQL")  # 4.3.15
_END = struct.Struct("<4s4H2LH")  # 4.3.16
_PLACE_64 = struct.Struct("<2HQ")  # a place beyond 4 GiB, 4.5.3
_VERSION, _DEFLATED = 45, 8
_MIDNIGHT, _FIRST_DAY = 0, 0x21  # of 1980; no time of writing, so that the same run is the same file
_MOST_32, _MOST_16 = 0xFFFFFFFF, 0xFFFF


class ArchiveWriter:
    """An archive that grows member by member; a member whose writing was interrupted is written over."""

    def __init__(self, stream: BinaryIO, *, is_packed: bool) -> None:
        self._stream = stream
        self._is_packed = is_packed
        self._end = 0  # of what is written whole
        self._entries = bytearray()  # of the directory
        self._count = 0

    def add(self, name: str, array: npt.NDArray[Any]) -> None:
        """Add an array of bytes or of floating-point numbers as a member."""
        content = _npy(array)
        check, size = zlib.crc32(content), len(content)
        if self._is_packed:
            packer = zlib.compressobj(wbits=-zlib.MAX_WBITS)
            content = packer.compress(content) + packer.flush()
        method = _DEFLATED if self._is_packed else STORED
        label = f"{name}.npy".encode("ascii")
        facts = (0, method, _MIDNIGHT, _FIRST_DAY, check, len(content), size, len(label))
        self._stream.seek(self._end)
        self._stream.write(LOCAL.pack(LOCAL_MARK, _VERSION, *facts, 0) + label)
        self._stream.write(content)
        self._stream.flush()
        is_far = self._end >= _MOST_32
        extra = _PLACE_64.pack(1, 8, self._end) if is_far else b""
        place = _MOST_32 if is_far else self._end
        entry = _ENTRY.pack(b"PK\x01\x02", _VERSION, _VERSION, *facts, len(extra), 0, 0, 0, 0, place)
        self._entries += entry + label + extra
        self._count += 1
        self._end = self._stream.tell()

    def finish(self) -> None:
        """Write the directory, and have all of the file on the disk."""
        place, size, count = self._end, len(self._entries), self._count
        self._stream.seek(place)
        self._stream.write(self._entries)
        if place >= _MOST_32 or size >= _MOST_32 or count >= _MOST_16:
            end = (44, _VERSION, _VERSION, 0, 0, count, count, size, place)
            self._stream.write(_END_64.pack(b"PK\x06\x06", *end))
            self._stream.write(_LOCATOR_64.pack(b"PK\x06\x07", 0, place + size, 1))
        short = min(count, _MOST_16)
        numbers = (0, 0, short, short, min(size, _MOST_32), min(place, _MOST_32), 0)
        self._stream.write(_END.pack(b"PK\x05\x06", *numbers))
        self._stream.truncate()
        self._stream.flush()
        os.fsync(self._stream.fileno())


def _npy(array: npt.NDArray[Any]) -> bytes:
    """The array as a file of NumPy's format 1.0, the first index fastest."""
    kind = np.dtype("<f8") if array.dtype.kind == "f" else np.dtype("u1")
    stream = io.BytesIO()
    header = {"descr": kind.str, "fortran_order": array.ndim > 1, "shape": array.shape}
    np.lib.format.write_array_header_1_0(stream, header)
    stream.write(array.astype(kind, copy=False).tobytes(order="F"))
    return stream.getvalue()
