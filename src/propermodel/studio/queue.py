"""The queue of jobs: so many at once, each in a process of its own, and what becomes of them told to who listens."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Any

from propermodel.diagnostics import parse_path
from propermodel.studio.faults import AnswerError, StudioError
from propermodel.studio.job import Fact, Job, JobKind, JobProgress, JobState
from propermodel.studio.listeners import Listeners
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER, ReductionOrder, RunOrder, order_data
from propermodel.studio.store import JobStore
from propermodel.studio.workers import Worker, Workers, most_at_once

Json = Any

_LOG = logging.getLogger("propermodel.studio")

CANCELLED_WITHIN_S = 1.5  # what does not stop by itself until then is ended
_WRITTEN_EVERY_S = 1.0
_FACT = ("name", "value", "note")
_LONGEST = 1500  # letters of a message


class Queue:
    """All jobs of a folder."""

    def __init__(self, root: FilePath, workers: Workers) -> None:
        self.store = JobStore(root)
        self._workers = workers
        self._jobs: dict[str, Job] = {}
        self._busy: dict[str, Worker] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._turn = asyncio.Semaphore(most_at_once())
        self.listeners = Listeners()
        self._written_at: dict[str, float] = {}

    def open(self) -> None:
        """Find the jobs of earlier servers.

        Raises:
            StudioError: another server has the folder.
        """
        self._jobs = {job.id: job for job in self.store.open()}

    @property
    def jobs(self) -> list[Job]:
        """All jobs, the newest first."""
        return sorted(self._jobs.values(), key=lambda job: -int(job.id))

    def get(self, number: str) -> Job:
        """The job of this number.

        Raises:
            StudioError: there is none.
        """
        job = self._jobs.get(number)
        if job is None:
            raise StudioError.with_status(
                404, "studio/job", f"there is no job '{number[:40]}'", help="it may have been deleted: reload the list"
            )
        return job

    def folder(self, job: Job) -> FilePath:
        """Where a job keeps what it makes."""
        return self.store.folder(job)

    def add_run(self, order: RunOrder, name: str) -> Job:
        """Have a run made."""
        return self._add(
            Job(
                id=self.store.new_id(),
                kind=JobKind.RUN,
                model=order.model,
                name=name,
                scenario=order.scenario,
                created=_now(),
                order=order,
                outputs=order.outputs,
            )
        )

    def add_reduction(self, order: ReductionOrder) -> Job:
        """Have a reduction made of a run that is complete."""
        full = self.get(order.run)
        return self._add(
            Job(
                id=self.store.new_id(),
                kind=JobKind.REDUCTION,
                model=full.model,
                name=full.name,
                scenario=full.scenario,
                created=_now(),
                reduction=order,
                run=full.id,
                window=full.window,
                outputs=order.outputs or full.outputs,
            )
        )

    async def cancel(self, number: str) -> Job:
        """Stop a job; what it has computed is kept. One that is over stays as it is."""
        job = self.get(number)
        if job.state is JobState.QUEUED:
            self._tasks[number].cancel()
            self._change(job, state=JobState.CANCELLED, message="cancelled before it began")
        elif job.state is JobState.RUNNING and not job.is_cancelling:
            self._change(job, is_cancelling=True, message="stopping")
            worker = self._busy.get(number)
            if worker is not None:
                worker.cancel()
            asyncio.get_running_loop().call_later(CANCELLED_WITHIN_S, self._end_if_busy, number)
        return self.get(number)

    async def delete(self, number: str) -> None:
        """Delete a job that is over, with all that it has made.

        Raises:
            StudioError: it is not over, or a reduction of it is not.
        """
        job = self.get(number)
        users = [other.id for other in self._jobs.values() if other.run == number and not other.state.is_over]
        if not job.state.is_over or users:
            raise StudioError.with_status(
                409,
                "studio/busy",
                f"job {number} is {'used by ' + ', '.join(users) if users else 'not over'}",
                help="cancel it first, or wait",
            )
        await asyncio.to_thread(self.store.delete, job)
        del self._jobs[number]
        self.listeners.tell("deleted", {"id": number})

    async def close(self) -> None:
        """Stop all jobs; they keep what they have."""
        for job in self.jobs:
            if not job.state.is_over:
                await self.cancel(job.id)
        tasks = list(self._tasks.values())
        if tasks:
            await asyncio.wait(tasks, timeout=2 * CANCELLED_WITHIN_S)
        self.listeners.close()
        self.store.close()

    # -- one job -------------------------------------------------------------------------------------------

    def add(self, job: Job) -> None:
        """Take a job in, without making it.

        Raises:
            OSError: it cannot be written down.
        """
        self.store.write(job)
        self._jobs[job.id] = job
        self.listeners.tell("job", job.data())

    def _add(self, job: Job) -> Job:
        self.add(job)
        task = asyncio.get_running_loop().create_task(self._make(job.id))
        self._tasks[job.id] = task
        task.add_done_callback(lambda _: self._tasks.pop(job.id, None))
        return job

    async def _make(self, number: str) -> None:
        """Wait for the turn of a job, and make it; however that ends, the job is over then."""
        async with self._turn:
            worker = None
            try:
                job = self._change(self.get(number), state=JobState.RUNNING, message="preparing")
                worker = self._busy[number] = await self._workers.take()
                if self.get(number).is_cancelling:  # while its process started
                    worker.kill()
                answer = json.loads(await worker.do(*self._task(job), self._hearer(number)))
                self._change(self.get(number), is_cancelling=False, **_result(answer))
            except AnswerError as error:
                fault = error.faults[0]
                self._failed(number, JobState.FAILED, fault["message"], tuple(fault["elements"]), fault["help"])
            except StudioError as error:
                self._failed(number, JobState.LOST, error.diagnostics[0].message, (), "")
            except Exception as error:  # noqa: BLE001 (as when no process can be started: a job must not be left open)
                _LOG.error("job %s failed", number, exc_info=error)
                self._failed(number, JobState.FAILED, f"{type(error).__name__}: {error}", (), "")
            finally:
                self._busy.pop(number, None)
                if worker is not None:
                    await worker.end()
                self._workers.prepare()

    def _task(self, job: Job) -> tuple[str, Json]:
        folder = str(self.folder(job))
        if job.order is not None:
            return "run", {"folder": folder, "order": order_data(RUN_ORDER, job.order)}
        assert job.reduction is not None
        full = self.get(job.reduction.run)
        return "reduce", {
            "folder": folder,
            "order": order_data(REDUCTION_ORDER, job.reduction),
            "full": str(self.folder(full)),
            "model": full.model,
            "outputs": [str(path) for path in job.outputs],
        }

    def _hearer(self, number: str) -> Callable[[Json], None]:
        def heard(said: Json) -> None:
            job = self._jobs.get(number)
            if job is None or job.state.is_over:
                return
            changes: dict[str, Any] = {}
            if "progress" in said:
                changes["progress"] = JobProgress(**said["progress"])
            if "scenario" in said:
                changes["scenario"] = shown(said["scenario"])
            if "window" in said:
                changes["window"] = (said["window"][0], said["window"][1])
            if "stage" in said and not job.is_cancelling:
                changes["message"] = said["stage"]
            self._change(job, **changes)

        return heard

    def _failed(self, number: str, state: JobState, message: str, elements: tuple[str, ...], help: str) -> None:
        job = self.get(number)
        if job.is_cancelling:
            state, message, help = JobState.CANCELLED, "cancelled; what was recorded until then can be seen", ""
        text = f"{message} ({help})" if help else message
        self._change(job, state=state, message=shown(text), elements=elements, is_cancelling=False)

    def _end_if_busy(self, number: str) -> None:
        worker = self._busy.get(number)
        if worker is not None:
            worker.kill()

    def _change(self, job: Job, **changes: Any) -> Job:
        """Change a job, tell it, and write it down now and then."""
        changed = replace(job, **changes)
        self._jobs[job.id] = changed
        now = time.monotonic()
        if changed.state is not job.state or now - self._written_at.get(job.id, 0.0) > _WRITTEN_EVERY_S:
            self._written_at[job.id] = now
            with contextlib.suppress(OSError):  # a full disk must not end the job, whose state is told anyway
                self.store.write(changed)
        self.listeners.tell("job", changed.data())
        return changed


def _result(answer: Json) -> dict[str, Any]:
    """What a worker's answer changes in its job."""
    spark = answer.get("spark")
    return {
        "state": JobState(answer["state"]),
        "message": shown(answer["message"]),
        "elements": tuple(answer.get("elements", ())),
        "spark": None if spark is None else tuple(spark),
        "summary": tuple(Fact(*(shown(fact[key]) for key in _FACT)) for fact in answer.get("summary", ())),
        "outputs": tuple(parse_path(text) for text in answer["outputs"]),
    }


def shown(text: str) -> str:
    """A text that somebody else's program may have written, as it can be shown and kept."""
    printable = "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in text)
    return printable if len(printable) <= _LONGEST else f"{printable[:_LONGEST]}..."


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
