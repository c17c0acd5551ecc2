"""Routes of jobs: what is ordered, how far it is, and how it is stopped and deleted."""

from __future__ import annotations

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from propermodel.studio.faults import StudioError
from propermodel.studio.folder import Folder, Trust
from propermodel.studio.job import JobKind, JobState
from propermodel.studio.listing import Listing
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER
from propermodel.studio.queue import Queue
from propermodel.studio.recorded import RecordedRuns
from propermodel.studio.store import RUN_FILE
from propermodel.studio.words import ordered


class JobRoutes:
    """What pages ask of the queue."""

    def __init__(self, folder: Folder, trust: Trust, listing: Listing, queue: Queue, recorded: RecordedRuns) -> None:
        self._folder = folder
        self._trust = trust
        self._listing = listing
        self._queue = queue
        self._recorded = recorded

    async def order_run(self, request: Request) -> Response:
        """Order a run."""
        order = await ordered(request, RUN_ORDER)
        model = self._folder.model(order.model)
        self._trust.check(self._folder, model, self._folder.scenario(order.scenario))
        entries = await run_in_threadpool(self._listing.entries)
        entry = next((entry for entry in entries if entry.id == model.text), None)
        return JSONResponse(self._queue.add_run(order, model.text if entry is None else entry.name).data(), 201)

    async def order_reduction(self, request: Request) -> Response:
        """Order a reduction of a complete run."""
        order = await ordered(request, REDUCTION_ORDER)
        full = self._queue.get(order.run)
        if full.kind is not JobKind.RUN or full.state is not JobState.COMPLETE:
            raise StudioError.with_status(
                409,
                "studio/incomplete",
                f"job {full.id} is no complete run, and only those can be reduced",
                help="run the full model to its end first",
            )
        return JSONResponse(self._queue.add_reduction(order).data(), 201)

    async def jobs(self, _: Request) -> Response:
        """All jobs, the newest first."""
        return JSONResponse([job.data() for job in self._queue.jobs])

    async def job(self, request: Request) -> Response:
        """One job."""
        return JSONResponse(self._queue.get(request.path_params["id"]).data())

    async def cancel(self, request: Request) -> Response:
        """Stop a job."""
        return JSONResponse((await self._queue.cancel(request.path_params["id"])).data())

    async def delete(self, request: Request) -> Response:
        """Delete a job with all it has made."""
        job = self._queue.get(request.path_params["id"])
        await self._queue.delete(job.id)
        self._recorded.drop(self._queue.folder(job) / RUN_FILE)
        return Response(status_code=204)

    async def events(self, _: Request) -> Response:
        """What happens to jobs, as it happens."""
        return StreamingResponse(self._queue.listeners.stream(), media_type="text/event-stream; charset=utf-8")

    def routes(self) -> list[Route]:
        """All of them."""
        return [
            Route("/api/runs", self.order_run, methods=["POST"]),
            Route("/api/reductions", self.order_reduction, methods=["POST"]),
            Route("/api/jobs", self.jobs),
            Route("/api/jobs/{id}", self.job),
            Route("/api/jobs/{id}", self.delete, methods=["DELETE"]),
            Route("/api/jobs/{id}/cancel", self.cancel, methods=["POST"]),
            Route("/api/events", self.events),
        ]
