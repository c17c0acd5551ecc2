"""Routes of results: activity and histories of runs, reductions with their reports, comparisons, and scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from propermodel.diagnostics import Path, one_of, parse_path
from propermodel.report.buckets import Intervals, packed
from propermodel.report.run_data import history_data, instants
from propermodel.studio.answers import Answers
from propermodel.studio.faults import StudioError
from propermodel.studio.folder import Folder, Trust
from propermodel.studio.job import Job, JobKind, JobState
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER, RunOrder, order_data
from propermodel.studio.queue import Queue
from propermodel.studio.recorded import RecordedRun
from propermodel.studio.runs import RunRoutes
from propermodel.studio.store import PAGE_FILE, REPORT_FILE, RUN_FILE
from propermodel.studio.words import asked
from propermodel.studio.workers import Workers

Json = Any

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
        """The Python that does what a job did, or that opens a model."""
        number = request.query_params.get("job", "")
        if number:
            job = self._queue.get(number)
            full = job if job.run is None else self._queue.get(job.run)
            order, reduction, outputs = full.order, job.reduction, job.outputs
        else:
            words = asked(request, "model"), request.query_params.get("scenario", "")
            order, reduction, outputs = RunOrder(model=words[0], scenario=words[1]), None, ()
        assert order is not None  # a run has one
        model, scenario = self._folder.model(order.model), self._folder.scenario(order.scenario)
        self._trust.check(self._folder, model, scenario)
        arguments = {
            "order": order_data(RUN_ORDER, order),
            "reduction": None if reduction is None else order_data(REDUCTION_ORDER, reduction),
            "outputs": [str(path) for path in outputs],
            "is_run": bool(number),
        }

        async def ask() -> bytes:
            return await self._workers.ask("script", arguments)

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
