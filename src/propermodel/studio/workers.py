"""Workers, as the server sees them: processes that are started, asked and ended."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any

from propermodel.studio.faults import AnswerError, StudioError

Json = Any
Heard = Callable[[Json], None]

ANSWER_WITHIN_S = 120.0
_MOST_TASKS = 30  # of one worker, so that what they leave in memory does not add up


def most_at_once() -> int:
    """How many workers may be busy: one core is left to the page and the server."""
    return max(1, (os.cpu_count() or 1) - 1)


class Worker:
    """A process that does tasks, one at a time."""

    def __init__(self, process: Process) -> None:
        self._process = process
        self.tasks = 0  # that it has done

    @classmethod
    async def start(cls, root: FilePath) -> Worker:
        """A process that works in a folder and waits for a task."""
        # -P: nothing in the folder is taken for a module of ours. Buffered lines are short; answers are read by length.
        command = (sys.executable, "-P", "-m", "propermodel.studio.worker", str(root))
        return cls(await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE, limit=2**20))

    @property
    def is_alive(self) -> bool:
        """Whether the process has not ended."""
        return self._process.returncode is None

    @property
    def process_id(self) -> int:
        """The number of the process."""
        return self._process.pid

    async def do(self, task: str, arguments: Json, heard: Heard | None = None) -> bytes:
        """Do a task; `heard` is called with what the worker tells on its way.

        Raises:
            AnswerError: the worker says why it cannot be done.
            StudioError: the process has ended without an answer.
        """
        written, read = self._process.stdin, self._process.stdout
        assert written is not None  # both are pipes
        assert read is not None
        self.tasks += 1
        try:
            written.write(json.dumps({"task": task, "arguments": arguments}).encode() + b"\n")
            await written.drain()
            while line := await read.readline():
                head = json.loads(line)
                if "said" in head:
                    if heard is not None:
                        heard(head["said"])
                elif "answer" in head:
                    return await read.readexactly(head["answer"])
                else:
                    raise AnswerError(head["status"], head["faults"])
        except (ConnectionError, asyncio.IncompleteReadError):
            pass  # it has ended, as is told below
        code = await self._process.wait()
        how = f"signal {-code}" if code < 0 else f"code {code}"
        raise StudioError.with_status(
            500,
            "studio/worker",
            f"the process that worked on this has ended ({how})",
            help="the terminal of the studio may say why; often memory was short. Ask again",
        )

    def cancel(self) -> None:
        """Ask the process to stop with what it has."""
        stream = self._process.stdin
        if stream is not None and self.is_alive:
            with contextlib.suppress(ConnectionError, RuntimeError):  # it ends by itself just now
                stream.write(b"cancel\n")

    def kill(self) -> None:
        """End the process, whatever it does."""
        if self.is_alive:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    async def end(self) -> None:
        """End the process, and wait until it has."""
        self.kill()
        await self._process.wait()


class Workers:
    """Workers for a folder; one that is ready stands by, as it takes a second to start."""

    def __init__(self, root: FilePath) -> None:
        self._root = root
        self._spare: asyncio.Task[Worker] | None = None
        self._turn = asyncio.Semaphore(most_at_once())
        self._idle: list[Worker] = []  # that have done tasks and can do more
        self._is_closed = False

    def prepare(self) -> None:
        """Have one stand by."""
        if self._spare is None and not self._idle and not self._is_closed:
            self._spare = asyncio.get_running_loop().create_task(Worker.start(self._root))

    async def take(self) -> Worker:
        """A worker that has run no program of the user's; whoever takes it ends it or gives it back."""
        while self._idle:
            worker = self._idle.pop()
            if worker.is_alive:
                return worker
        spare, self._spare = self._spare, None
        worker = None if spare is None else await spare
        if worker is None or not worker.is_alive:
            worker = await Worker.start(self._root)
        return worker

    async def ask(
        self, task: str, arguments: Json, *, runs_python: bool = False, within: float = ANSWER_WITHIN_S
    ) -> bytes:
        """The answer to a question, when it is its turn.

        Args:
            task: The name of the task.
            arguments: What it is about.
            runs_python: Whether it runs a program of the user's; such a worker is used once.
            within: The time for the answer, s.

        Raises:
            AnswerError: the worker says why there is none.
            StudioError: the process has ended without an answer, or has taken too long.
        """
        async with self._turn:
            worker, is_reusable = await self.take(), False
            try:
                answer = await asyncio.wait_for(worker.do(task, arguments), within)
                is_reusable = not runs_python and worker.tasks < _MOST_TASKS and not self._is_closed
            except TimeoutError:
                raise StudioError.with_status(
                    504,
                    "studio/timeout",
                    f"there is no answer after {within:g} s",
                    help="see whether the model's own code waits for something; the process was ended",
                ) from None
            finally:
                if is_reusable:
                    self._idle.append(worker)
                else:
                    await worker.end()
                    self.prepare()
            return answer

    async def close(self) -> None:
        """End those that stand by."""
        self._is_closed = True
        while self._idle:
            await self._idle.pop().end()
        spare, self._spare = self._spare, None
        if spare is not None:
            await (await spare).end()
