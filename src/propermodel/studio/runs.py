"""Routes of runs: signals and their columns, also while a run goes on."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import numpy as np
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from propermodel.diagnostics import Path
from propermodel.report.buckets import Intervals
from propermodel.report.plain import finite
from propermodel.studio.job import Job
from propermodel.studio.queue import Queue
from propermodel.studio.recorded import RecordedRun, RecordedRuns, packed_series
from propermodel.studio.store import RUN_FILE
from propermodel.studio.words import number, signals, window

Json = Any
T = TypeVar("T")

_ROWS_AT_ONCE = 5000  # of a CSV file
_BYTES = "application/octet-stream; charset=binary"


class RunRoutes:
    """What pages ask of recorded runs; of a reduction, of the run of its reduced model."""

    def __init__(self, queue: Queue) -> None:
        self._queue = queue
        self.recorded = RecordedRuns()

    async def signals(self, request: Request) -> Response:
        """Which observables were recorded."""
        return JSONResponse(await self.of(self._job(request), RecordedRun.signals))

    async def series(self, request: Request) -> Response:
        """Columns in intervals, for plots."""
        job = self._job(request)
        paths, span = signals(request), window(request, *_window(job))
        times, columns = await self.of(job, lambda run: run.extremes(paths, *span))
        return _binary(packed_series(times, columns))

    async def difference(self, request: Request) -> Response:
        """What one run has more than another, at the instants of the first."""
        a, b = (self._queue.get(request.query_params.get(name, "")) for name in ("a", "b"))
        paths, span = signals(request), window(request, *_window(a))

        def differ() -> bytes:
            with self.recorded.lock:
                return _difference(self._run(a), self._run(b), paths, *span)

        return _binary(await run_in_threadpool(differ))

    async def values(self, request: Request) -> Response:
        """The recorded values nearest to an instant."""
        job, paths, time = self._job(request), signals(request), number(request, "time", 0.0)
        at, found = await self.of(job, lambda run: run.nearest(paths, time))
        values = dict(zip(map(str, paths), found, strict=True))
        return JSONResponse(finite({"time": at, "values": values}))

    async def csv(self, request: Request) -> Response:
        """Columns as CSV, in SI, all rows."""
        job, paths = self._job(request), signals(request)
        await self.of(job, lambda run: run.check(paths))
        name = f"run_{job.id}.csv"
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return StreamingResponse(self._csv(job, paths), media_type="text/csv; charset=utf-8", headers=headers)

    def _csv(self, job: Job, paths: list[Path]) -> Iterator[str]:
        first, count = 0, None
        while count is None or first < count:
            stream = io.StringIO()
            writer = csv.writer(stream, lineterminator="\n")
            with self.recorded.lock:
                run = self._run(job)
                if count is None:
                    count = len(run.rows.signals)
                    writer.writerow(["time_s", *(f"{path} [{run.unit(path)}]" for path in paths)])
                rows = np.column_stack(run.columns(paths, first, min(first + _ROWS_AT_ONCE, count))).tolist()
            writer.writerows([f"{value:.9g}" for value in row] for row in rows)
            first += _ROWS_AT_ONCE
            yield stream.getvalue()

    def _job(self, request: Request) -> Job:
        return self._queue.get(request.path_params["id"])

    def _run(self, job: Job) -> RecordedRun:
        return self.recorded.get(self._queue.folder(job) / RUN_FILE)

    async def of(self, job: Job, ask: Callable[[RecordedRun], T]) -> T:
        """What is asked of a run, in a thread: files are read."""

        def found() -> T:
            with self.recorded.lock:
                return ask(self._run(job))

        return await run_in_threadpool(found)

    def routes(self) -> list[Route]:
        """All of them."""
        return [
            Route("/api/runs/{id}/signals", self.signals),
            Route("/api/runs/{id}/series", self.series),
            Route("/api/runs/{id}/values", self.values),
            Route("/api/runs/{id}/csv", self.csv),
            Route("/api/compare/series", self.difference),
        ]


def _window(job: Job) -> tuple[float, float]:
    """The window of a job; of one whose scenario has not been read yet, a second."""
    start, stop = job.window
    return (start, stop) if stop > start else (start, start + 1.0)


def _difference(a: RecordedRun, b: RecordedRun, paths: list[Path], start: float, stop: float, count: int) -> bytes:
    edges = np.linspace(start, stop, count + 1)
    times = np.column_stack([edges[:-1], 0.5 * (edges[:-1] + edges[1:])]).ravel()
    one, other = a.columns(paths, 0, len(a.rows.signals)), b.columns(paths, 0, len(b.rows.signals))
    inside = slice(max(0, int(np.searchsorted(one[0], start)) - 1), int(np.searchsorted(one[0], stop, "right")) + 1)
    at = one[0][inside]
    intervals = Intervals(at, edges)
    columns = [
        intervals.extremes(np.interp(at, other[0], theirs, left=np.nan, right=np.nan) - own[inside])
        if len(other[0])
        else np.full(2 * count, np.nan)
        for own, theirs in zip(one[1:], other[1:], strict=True)
    ]
    return packed_series(times, columns)


def _binary(content: bytes) -> Response:
    return Response(content, headers={"Content-Type": _BYTES})
