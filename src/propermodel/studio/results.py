"""Routes of results: activity and histories of runs, reductions with their reports, comparisons, and scripts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from propermodel.diagnostics import Path, one_of, parse_path
from propermodel.report.buckets import Intervals, packed
from propermodel.report.run_data import USUAL_THRESHOLD, history_data, instants
from propermodel.studio.answers import Answers
from propermodel.studio.faults import StudioError
from propermodel.studio.folder import Folder, Trust
from propermodel.studio.job import Job, JobKind, JobState
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER, RunOrder, order_data, read_order
from propermodel.studio.queue import Queue
from propermodel.studio.recorded import RecordedRun
from propermodel.studio.runs import RunRoutes
from propermodel.studio.store import PAGE_FILE, REPORT_FILE, RUN_FILE
from propermodel.studio.words import asked, number
from propermodel.studio.workers import Workers

Json = Any

_RUN_WORDS = ("scenario", "until", "method", "step", "tolerance", "set", "run")
INTERVALS = 500  # of a history


class ResultRoutes:
    """What pages ask of what jobs have made."""

    def __init__(
        self, folder: Folder, trust: Trust, workers: Workers, answers: Answers, queue: Queue, runs: RunRoutes
    ) -> None:
        self._folder = folder
        self._trust = trust
        self._workers = workers
        self._answers = answers
        self._queue = queue
        self._runs = runs

    async def activity(self, request: Request) -> Response:
        """The ranking of a run with what belongs to it."""
        return JSONResponse(await self._activity(self._job(request)))

    async def history(self, request: Request) -> Response:
        """Effort, flow and power of a row over time."""
        job, row = self._job(request), asked(request, "row")
        bonds = bonds_of((await self._activity(job))["bonds"], row)
        return JSONResponse(await self._runs.of(job, lambda run: _history(run, bonds)))

    async def reduction(self, request: Request) -> Response:
        """All that is known of a reduction."""
        return self._file(request, PAGE_FILE, media="application/json; charset=utf-8")

    async def report(self, request: Request) -> Response:
        """The page of a reduction, to be kept and mailed."""
        job = self._job(request)
        return self._file(request, REPORT_FILE, media="text/html; charset=utf-8", name=f"reduction_{job.id}.html")

    async def comparison(self, request: Request) -> Response:
        """Two runs side by side."""
        a, b = (self._queue.get(asked(request, name)) for name in ("a", "b"))
        outputs = [str(path) for path in dict.fromkeys((*a.outputs, *b.outputs))]
        files = {name: str(self._queue.folder(job) / RUN_FILE) for name, job in (("a", a), ("b", b))}
        for job in (a, b):
            await self._runs.of(job, RecordedRun.signals)  # there is something to compare

        async def ask() -> bytes:
            return await self._workers.ask("compare", {**files, "outputs": outputs})

        stamped = [self._queue.folder(job) / RUN_FILE for job in (a, b)]
        return JSONResponse(await self._answers.get(f"compare {a.id} {b.id}", stamped, ask))

    async def python(self, request: Request) -> Response:
        """The Python that does what a page did: with a job, or with a model that is to be opened or run."""
        words = request.query_params
        job = self._queue.get(words["job"]) if words.get("job") else None
        reduction = None if job is None else job.reduction
        if job is None:
            order = _order_in(request)
        else:
            full = job if job.run is None else self._queue.get(job.run)
            assert full.order is not None  # a run has one
            order = full.order
        model, scenario = self._folder.model(order.model), self._folder.scenario(order.scenario)
        self._trust.check(self._folder, model, scenario)
        is_ranked = reduction is None and bool(words.get("activity"))
        arguments = {
            "order": order_data(RUN_ORDER, order),
            "reduction": None if reduction is None else order_data(REDUCTION_ORDER, reduction),
            "outputs": [] if job is None else [str(path) for path in job.outputs],
            "signals": [] if job is None else [str(parse_path(text)) for text in words.getlist("signal")],
            "threshold": number(request, "threshold", USUAL_THRESHOLD) if is_ranked else None,
            "is_run": job is not None or any(words.get(name) for name in _RUN_WORDS),
        }

        async def ask() -> bytes:
            is_python = model.is_python or scenario.is_python
            return await self._workers.ask("script", arguments, runs_python=is_python)

        files = [item.file for item in (model, scenario) if item.file is not None]
        return PlainTextResponse(await self._answers.get(f"script {arguments}", files, ask))

    async def _activity(self, job: Job) -> Json:
        file = self._queue.folder(job) / RUN_FILE

        async def ask() -> bytes:
            return await self._workers.ask("activity", {"file": str(file)})

        await self._runs.of(job, lambda _: None)  # there is something to rank
        return await self._answers.get(f"activity {job.id}", [file], ask)

    def _job(self, request: Request) -> Job:
        return self._queue.get(request.path_params["id"])

    def _file(self, request: Request, file: str, *, media: str, name: str | None = None) -> Response:
        """A file that a complete reduction has written."""
        job = self._job(request)
        path = self._queue.folder(job) / file
        if job.kind is not JobKind.REDUCTION or job.state is not JobState.COMPLETE or not path.is_file():
            raise StudioError.with_status(
                409,
                "studio/no-reduction",
                f"job {job.id} is no complete reduction",
                help="ask when it is complete; the message of the job says how far it is, or why it failed",
            )
        return FileResponse(path, media_type=media, filename=name)

    def routes(self) -> list[Route]:
        """All of them."""
        return [
            Route("/api/runs/{id}/activity", self.activity),
            Route("/api/runs/{id}/history", self.history),
            Route("/api/reductions/{id}", self.reduction),
            Route("/api/reductions/{id}/report.html", self.report),
            Route("/api/compare", self.comparison),
            Route("/api/python", self.python),
        ]


def _order_in(request: Request) -> RunOrder:
    """The run that a page is about to order.

    Raises:
        StudioError: a word is not what it should be.
    """
    words = request.query_params
    given: dict[str, Json] = {"model": asked(request, "model")}
    given |= {name: words[name] for name in ("scenario", "method") if words.get(name)}
    given |= {name: number(request, name, 0.0) for name in ("until", "step", "tolerance") if words.get(name)}
    given["settings"] = {name: value for name, _, value in (text.partition("=") for text in words.getlist("set"))}
    return read_order(RUN_ORDER, json.dumps(given).encode())


def bonds_of(rows: Mapping[str, Sequence[str]], row: str) -> list[Path]:
    """The bonds of a row.

    Raises:
        StudioError: there is no such row.
    """
    if row not in rows:
        raise StudioError.with_status(
            404, "studio/row", f"the run has no row '{row[:200]}'", help=one_of(row[:200], rows)
        )
    return [parse_path(bond) for bond in rows[row]]


def _history(run: RecordedRun, bonds: list[Path]) -> Json:
    time = run.time
    edges, times = instants(float(time[0]), float(time[-1]), INTERVALS)
    return {"times": packed(times), "items": history_data(run, bonds, Intervals(time, edges))}
