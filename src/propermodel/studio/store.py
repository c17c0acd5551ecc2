"""The folder of jobs: each has a folder of its own, with its state and what it has made.

Two servers of one folder would end each other's jobs, so the first of them holds a lock until its process ends.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path as FilePath
from typing import BinaryIO

from propermodel.diagnostics import DocumentError
from propermodel.modelling.documents import SharedEntries, opened
from propermodel.modelling.files import partial_file, read_bytes
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.schema import Place
from propermodel.studio.faults import StudioError
from propermodel.studio.folder import RUNS
from propermodel.studio.job import JOB, Job, JobState
from propermodel.studio.orders import LIMITS

FORMAT, VERSION = "propermodel-job", 1
STATE_FILE, RUN_FILE, PAGE_FILE, REPORT_FILE = "job.json", "run.npz", "page.json", "report.html"

_ID = re.compile(r"[1-9][0-9]{0,8}")


class JobStore:
    """Jobs on the disk."""

    def __init__(self, root: FilePath) -> None:
        self._folder = root / RUNS
        self._lock: BinaryIO | None = None

    def open(self) -> list[Job]:
        """Take the folder over; gives the jobs that are there, of which none is alive.

        Raises:
            StudioError: another server has it.
        """
        if self._folder.is_symlink() or (self._folder.exists() and not self._folder.is_dir()):
            raise StudioError.with_status(
                503, "studio/folder", f"'{RUNS}' is no folder of its own", help="move it out of the way"
            )
        if self._folder.is_dir():
            self._take()
        return sorted(self._read(), key=lambda job: int(job.id))

    def close(self) -> None:
        """Let another server have the folder."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def new_id(self) -> str:
        """The number of a new job, whose folder is there now.

        Raises:
            OSError: the folder cannot be written to.
        """
        self._folder.mkdir(exist_ok=True)
        self._take()
        number = max((int(path.name) for path in self._folder.iterdir() if _ID.fullmatch(path.name)), default=0) + 1
        (self._folder / str(number)).mkdir()
        return str(number)

    def folder(self, job: Job) -> FilePath:
        """The folder of a job."""
        return self._folder / job.id

    def write(self, job: Job) -> None:
        """Write the state of a job.

        Raises:
            OSError: it cannot be written.
        """
        file = self.folder(job) / STATE_FILE
        partial = partial_file(file)
        document = {"format": FORMAT, "version": VERSION, **JOB.write(job, SharedEntries(LIMITS))}
        partial.write_text(json.dumps(document) + "\n", encoding="utf-8")
        partial.replace(file)

    def delete(self, job: Job) -> None:
        """Delete a job with all that it has made.

        Raises:
            OSError: something cannot be deleted.
        """
        shutil.rmtree(self.folder(job))

    def _read(self) -> Iterator[Job]:
        if not self._folder.is_dir():
            return
        for path in self._folder.iterdir():
            if not _ID.fullmatch(path.name) or not (path / STATE_FILE).is_file() or _leads_out(path):
                continue
            try:
                data = parse_json(read_bytes(path / STATE_FILE, LIMITS.file_bytes, "file_bytes"), LIMITS)
                top = Place("", SharedEntries(LIMITS))
                job = JOB.read(opened(data, FORMAT, top, VERSION), top)
            except DocumentError:
                continue  # not what a studio has written: it is left alone
            yield self._ended(replace(job, id=path.name))

    def _ended(self, job: Job) -> Job:
        """A job of an earlier server: what had not ended then never will."""
        if job.state.is_over:
            return job
        message = "the studio has ended before this job did; what was recorded until then can be seen"
        lost = replace(job, state=JobState.LOST, message=message, is_cancelling=False)
        self.write(lost)
        return lost

    def _take(self) -> None:
        if self._lock is not None:
            return
        file = self._folder / ".lock"
        if file.is_symlink():
            raise StudioError.with_status(503, "studio/folder", f"'{RUNS}/.lock' is a link", help="delete it")
        stream = file.open("ab")
        try:
            _lock(stream)
        except OSError:
            stream.close()
            raise StudioError.with_status(
                503,
                "studio/folder",
                "another studio serves this folder",
                help="use its page, or end it first",
            ) from None
        self._lock = stream


def _leads_out(folder: FilePath) -> bool:
    """Whether a folder is a link or holds one, which no studio makes: somebody else may want it followed."""
    return folder.is_symlink() or any(path.is_symlink() for path in folder.iterdir())


def _lock(stream: BinaryIO) -> None:
    """Hold a file until this process ends, however it does."""
    if sys.platform == "win32":
        import msvcrt

        stream.seek(0)
        msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
