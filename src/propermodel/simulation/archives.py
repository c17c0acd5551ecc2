"""Arrays in `.npz` archives that grow: what has been written whole can be read, also where the writing was cut off.

An archive is a ZIP file of `.npy` members, which NumPy and any program for ZIP files can open. Here it is read from its
start, from one member to the next, so its directory, which is written last, is not needed. Sizes are known before
anything is unpacked. Only arrays of bytes and of floating-point numbers are read, in the form in which `ArchiveWriter`
writes them: no objects, hence no pickles, and no header that has to be evaluated.
"""

from __future__ import annotations

import math
import os
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from propermodel.diagnostics import DocumentError
from propermodel.modelling.files import FileName, open_file
from propermodel.modelling.limits import Limits, exceeded
from propermodel.simulation.archive_writer import LOCAL, LOCAL_MARK, STORED

Array = npt.NDArray[Any]

_MAGIC = b"\x93NUMPY\x01\x00"
_HEADER = re.compile(
    rb"\{'descr': '(<f8|\|u1)', 'fortran_order': (?:True|False), 'shape': \((\d{1,18}(?:, \d{1,18})*),?\), \} *\n"
)
_KINDS = {b"<f8": np.dtype("<f8"), b"|u1": np.dtype("u1")}
_NAME = re.compile(rb"([a-z]+(?:\.\d{1,2})?(?:/\d{1,9})?)\.npy")
_END = struct.Struct("<4s4H2LH")  # the end of a ZIP file
_DIRECTORY_MARKS = (b"PK\x01\x02", b"PK\x05\x06")
_DEFLATED = 8
_HEAD_BYTES = 512  # more than a member has before its numbers
_MOST_HEADER = 256  # bytes of an array before its numbers


@dataclass(frozen=True, slots=True)
class Member:
    """An array of an archive and where it stands; several dimensions are stored with the first index fastest."""

    name: str
    begin: int  # of its header in the file
    data: int  # of its bytes in the file
    packed_size: int
    size: int
    check: int  # CRC-32 of its unpacked bytes
    is_packed: bool
    head: int  # bytes before the numbers
    shape: tuple[int, ...]
    kind: np.dtype[Any]


def scan(stream: BinaryIO, limits: Limits) -> tuple[Member, ...]:
    """All members that are there as a whole, in the order in which they were written.

    Raises:
        DocumentError: the file is no such archive, has been changed, or goes beyond a limit.
    """
    length = stream.seek(0, os.SEEK_END)
    members: list[Member] = []
    unpacked = 0
    for member in _members(stream, length):
        members.append(member)
        unpacked += member.size if member.is_packed else 0
        if unpacked > limits.trajectory_bytes:
            raise exceeded(
                "trajectory_bytes",
                f"the file unpacks to more than {limits.trajectory_bytes} bytes",
                code="document/size",
            )
        if len(members) > limits.trajectory_parts:
            raise exceeded("trajectory_parts", f"the file has more than {limits.trajectory_parts} parts")
    return tuple(members)


def _members(stream: BinaryIO, length: int) -> Iterator[Member]:
    place = 0
    while True:
        stream.seek(place)
        head = stream.read(_HEAD_BYTES)
        if place == 0 and not head.startswith(LOCAL_MARK):
            raise damaged("it is no archive")
        member = _member(head, place) if head.startswith(LOCAL_MARK) and len(head) >= LOCAL.size else None
        if member is None or member.data + member.packed_size > length:
            break
        yield member
        place = member.data + member.packed_size
    if not head.startswith(_DIRECTORY_MARKS) and _has_end(stream, length):
        raise damaged("a part of it has been changed")


def _member(head: bytes, place: int) -> Member | None:
    """The member that begins here; None where its beginning was not written as a whole."""
    _, _, flags, method, _, _, check, packed, size, name_length, extra_length = LOCAL.unpack_from(head)
    start = LOCAL.size + name_length + extra_length
    name = _NAME.fullmatch(head[LOCAL.size : LOCAL.size + name_length])
    if flags or extra_length or method not in (STORED, _DEFLATED) or name is None:
        raise damaged("it is encrypted, packed in a way that is not read here, or was made by another program")
    content = head[start:]
    if method == _DEFLATED:
        try:
            content = zlib.decompressobj(-zlib.MAX_WBITS).decompress(content, _HEAD_BYTES)
        except zlib.error as error:
            raise damaged(str(error)) from error
    text = name[1].decode()
    first = len(_MAGIC) + 2
    if len(content) < first:
        return None
    end = first + int.from_bytes(content[first - 2 : first], "little")
    if end > _MOST_HEADER:
        raise damaged(f"'{text}' is no array of numbers")
    if len(content) < end:
        return None
    header = _HEADER.fullmatch(content[first:end])
    if not content.startswith(_MAGIC) or header is None:
        raise damaged(f"'{text}' is no array of numbers")
    kind, shape = _KINDS[header[1]], tuple(map(int, header[2].split(b",")))
    if end + math.prod(shape) * kind.itemsize != size or (method == STORED and packed != size):
        raise damaged(f"'{text}' has another size than its shape tells")
    return Member(text, place, place + start, packed, size, check, method == _DEFLATED, end, shape, kind)


def _has_end(stream: BinaryIO, length: int) -> bool:
    """Whether the last bytes are those of an archive that was finished."""
    stream.seek(max(0, length - _END.size))
    return stream.read().startswith(_DIRECTORY_MARKS[1])


def read_array(stream: BinaryIO, member: Member) -> Array:
    """The whole array of a member, with its checksum.

    Raises:
        DocumentError: it is damaged.
    """
    content = _content(stream, member)
    if zlib.crc32(content) != member.check:
        raise damaged(f"the checksum of '{member.name}' is wrong")
    return np.frombuffer(content, member.kind, offset=member.head).reshape(member.shape, order="F")


def read_column(stream: BinaryIO, member: Member, index: int, first: int, last: int) -> npt.NDArray[np.float64]:
    """Rows of a column of a matrix; of one that is not packed nothing else is read, and its checksum not looked at.

    Raises:
        DocumentError: it is damaged.
    """
    if member.is_packed:
        return read_array(stream, member)[first:last, index]
    _check_unchanged(stream, member)
    size = member.kind.itemsize
    stream.seek(member.data + member.head + (index * member.shape[0] + first) * size)
    content = stream.read((last - first) * size)
    if len(content) != (last - first) * size:
        raise damaged("it has been cut off since it was opened")
    return np.frombuffer(content, member.kind)


def is_sound(stream: BinaryIO, member: Member) -> bool:
    """Whether the checksum of a member is right."""
    try:
        read_array(stream, member)
    except DocumentError:
        return False
    return True


def _content(stream: BinaryIO, member: Member) -> bytes:
    _check_unchanged(stream, member)
    stream.seek(member.data)
    content = stream.read(member.packed_size)
    if member.is_packed:
        try:
            content = zlib.decompressobj(-zlib.MAX_WBITS).decompress(content, member.size + 1)
        except zlib.error as error:
            raise damaged(str(error)) from error
    if len(content) != member.size:
        raise damaged(f"'{member.name}' has another size than it tells")
    return content


def _check_unchanged(stream: BinaryIO, member: Member) -> None:
    """Refuse to read where another file has taken the place of the one that was opened."""
    stream.seek(member.begin)
    head = stream.read(LOCAL.size)
    if len(head) < LOCAL.size or LOCAL.unpack(head)[6:9] != (member.check, member.packed_size, member.size):
        raise damaged("it has been changed since it was opened")


def open_archive(file: FileName, limits: Limits) -> tuple[Member, ...]:
    """The members of an archive."""
    with open_file(file) as stream:
        return scan(stream, limits)


def damaged(reason: str) -> DocumentError:
    """The error for a file that is no trajectory."""
    return DocumentError.of(
        "document/archive",
        f"the file cannot be read as a trajectory: {reason}",
        help="open a file that save_trajectory or simulate(..., record_to=...) wrote, unchanged",
    )
