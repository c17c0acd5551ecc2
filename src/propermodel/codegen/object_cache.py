"""A folder that keeps what was expensive to make, shared by all processes of one user.

What is read is what was written under the same key, or nothing: an entry carries a digest of its key and content.
Nobody waits for anybody: an entry is written aside and renamed into its place, so that readers see all of it or none,
and the last of several writers wins. Whatever the disk refuses costs only the saving, and is said once.
"""

from __future__ import annotations

import hashlib
import logging
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path as FilePath

VARIABLE = "PROPERMODEL_CACHE"  # a folder, or OFF
OFF = "off"
MOST_BYTES = 256 * 2**20

_LOG = logging.getLogger("propermodel.cache")
_MAGIC = b"propermodel cache 1\n"  # with the version of the format of an entry
_DIGEST_BYTES = hashlib.sha256().digest_size
_ENTRY, _UNFINISHED = ".entry", ".unfinished"
_ABANDONED_S = 3600.0  # an unfinished file of this age has lost its writer


@dataclass(frozen=True)
class Usage:
    """What a cache holds."""

    entries: int
    size: int  # bytes


@dataclass(frozen=True)
class _File:
    path: FilePath
    size: int
    used: float  # when it was read or written last, s since the epoch


class ObjectCache:
    """Entries by key; the keys are hexadecimal digests."""

    def __init__(self, folder: FilePath, most_bytes: int = MOST_BYTES) -> None:
        self.folder = folder
        self.most_bytes = most_bytes

    def get(self, key: str) -> bytes | None:
        """The content written under this key; None where there is none, or it is not as it was written."""
        path = self._path(key)
        try:
            if not self._is_private():
                return None
            found = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            _note(self.folder, error)
            return None
        content = found[len(_MAGIC) + _DIGEST_BYTES :]
        if found != _sealed(key, content):
            with suppress(OSError):
                path.unlink()
            return None
        with suppress(OSError):
            os.utime(path)  # used now: last to go
        return content

    def put(self, key: str, content: bytes) -> None:
        """Keep the content under this key, if the disk allows it; others go, the least recently used first."""
        unfinished = self.folder / f"{os.urandom(16).hex()}{_UNFINISHED}"
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not self._is_private():
                return
            try:
                unfinished.write_bytes(_sealed(key, content))
                unfinished.replace(self._path(key))
            except OSError:
                with suppress(OSError):
                    unfinished.unlink()
                raise
            self._make_room()
        except OSError as error:
            _note(self.folder, error)

    def usage(self) -> Usage:
        """How much there is."""
        files = list(self._files())
        return Usage(sum(file.path.suffix == _ENTRY for file in files), sum(file.size for file in files))

    def clear(self) -> Usage:
        """Delete everything this class has written, nothing else; returns what is gone.

        Raises:
            OSError: a file cannot be deleted.
        """
        files = list(self._files())
        for file in files:
            file.path.unlink(missing_ok=True)
        return Usage(sum(file.path.suffix == _ENTRY for file in files), sum(file.size for file in files))

    def _path(self, key: str) -> FilePath:
        return self.folder / f"{key}{_ENTRY}"

    def _files(self) -> Iterator[_File]:
        try:
            with os.scandir(self.folder) as listed:
                names = list(listed)
        except FileNotFoundError:
            return
        for name in names:
            if name.name.endswith((_ENTRY, _UNFINISHED)):
                with suppress(FileNotFoundError):  # another process has just deleted it
                    status = name.stat(follow_symlinks=False)
                    yield _File(FilePath(name.path), status.st_size, status.st_mtime)

    def _make_room(self) -> None:
        files = sorted(self._files(), key=lambda file: file.used)
        size = sum(file.size for file in files)
        now = time.time()
        for file in files:
            is_abandoned = file.path.suffix == _UNFINISHED and now - file.used > _ABANDONED_S
            if is_abandoned or (size > self.most_bytes and file.path.suffix == _ENTRY):
                file.path.unlink(missing_ok=True)
                size -= file.size

    def _is_private(self) -> bool:
        """Whether nobody else could have written into the folder: what it holds will be executed."""
        if os.name != "posix":
            return True  # below the user's own profile, whose rights are inherited
        status = self.folder.stat()
        is_private = status.st_uid == os.geteuid() and not status.st_mode & 0o022
        if not is_private:
            _note(self.folder, PermissionError("others own it or may write into it"))
        return is_private


def user_cache() -> ObjectCache | None:
    """The cache of the user, where the environment wants it; None where it is switched off."""
    wanted = os.environ.get(VARIABLE, "")
    if wanted.lower() == OFF:
        return None
    if wanted:
        return ObjectCache(FilePath(wanted).expanduser().absolute())
    import platformdirs

    return ObjectCache(platformdirs.user_cache_path("propermodel", appauthor=False))


def _sealed(key: str, content: bytes) -> bytes:
    digest = hashlib.sha256(key.encode() + b"\n" + content).digest()
    return b"".join((_MAGIC, digest, content))


_noted: set[FilePath] = set()


def _note(folder: FilePath, error: OSError) -> None:
    if folder not in _noted:
        _noted.add(folder)
        reason = error.strerror or str(error)
        _LOG.warning(
            "compiled code is not kept in %s: %s; %s names another folder, or is %s", folder, reason, VARIABLE, OFF
        )
