"""The application: routes, and what becomes of errors."""

from __future__ import annotations

import contextlib
import json
import logging
from collections.abc import AsyncGenerator
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

import propermodel
from propermodel.diagnostics import ProperModelError
from propermodel.studio.answers import Answers
from propermodel.studio.faults import AnswerError, StudioError, error_body, faults_of, status_of, unexpected
from propermodel.studio.folder import Folder, Named, Trust
from propermodel.studio.guard import Door, Guard
from propermodel.studio.jobs import JobRoutes
from propermodel.studio.listing import Listing
from propermodel.studio.pages import asset, index
from propermodel.studio.queue import Queue
from propermodel.studio.results import ResultRoutes
from propermodel.studio.runs import RunRoutes
from propermodel.studio.words import asked
from propermodel.studio.workers import Workers

Json = Any

_LOG = logging.getLogger("propermodel.studio")


class Studio:
    """The parts of a server, which its routes share."""

    def __init__(self, root: FilePath, trust: Trust | None = None) -> None:
        self.folder = Folder(root)
        self.trust = Trust() if trust is None else trust
        self.listing = Listing(self.folder.root)
        self.workers = Workers(self.folder.root)
        self.answers = Answers()
        self.queue = Queue(self.folder.root, self.workers)
        self.runs = RunRoutes(self.queue)
        self.results = ResultRoutes(self.folder, self.trust, self.workers, self.answers, self.queue, self.runs)
        self.jobs = JobRoutes(self.folder, self.trust, self.listing, self.queue, self.runs.recorded)

    async def start(self, _: Request) -> Response:
        """What the first page shows."""
        entries = await run_in_threadpool(self.listing.entries)
        return JSONResponse(
            {
                "version": propermodel.__version__,
                "folder": str(self.folder.root),
                "trusted": self.trust.covers(self.folder),
                "models": [asdict(entry) for entry in entries],
                "jobs": [job.data() for job in self.queue.jobs],
            }
        )

    async def trust_folder(self, _: Request) -> Response:
        """Remember that Python files of the folder may be run."""
        self.trust.add(self.folder)
        return JSONResponse({"trusted": True})

    async def model(self, request: Request) -> Response:
        """What is known of a model."""
        named = self.folder.model(asked(request, "id"))
        return await self._told("model", {"model": named.text}, named)

    async def equations(self, request: Request) -> Response:
        """The equations of a model as text."""
        named = self.folder.model(asked(request, "model"))
        return await self._told("equations", {"model": named.text}, named)

    async def scenario(self, request: Request) -> Response:
        """What is known of a scenario of a model."""
        model = self.folder.model(asked(request, "model"))
        scenario = self.folder.scenario(request.query_params.get("scenario", ""))
        return await self._told("scenario", {"model": model.text, "scenario": scenario.text or None}, model, scenario)

    async def _told(self, task: str, arguments: dict[str, str | None], *named: Named) -> Response:
        """What a worker tells of models and scenarios, kept until their files change."""
        self.trust.check(self.folder, *named)

        async def ask() -> bytes:
            return await self.workers.ask(task, arguments, runs_python=any(item.is_python for item in named))

        return JSONResponse(await self.answers.get(json.dumps([task, arguments]), _files(*named), ask))

    def routes(self) -> list[Route]:
        """All that is answered."""
        return [
            Route("/", index),
            Route("/assets/{name}", asset),
            Route("/api/start", self.start),
            Route("/api/trust", self.trust_folder, methods=["POST"]),
            Route("/api/model", self.model),
            Route("/api/equations", self.equations),
            Route("/api/scenario", self.scenario),
            *self.jobs.routes(),
            *self.runs.routes(),
            *self.results.routes(),
        ]

    @contextlib.asynccontextmanager
    async def running(self, _: Starlette) -> AsyncGenerator[None]:
        """From the start of the server to its end."""
        self.workers.prepare()
        yield
        await self.queue.close()
        await self.workers.close()


def make_app(studio: Studio, door: Door) -> Guard:
    """The application behind its door."""
    handlers = {
        ProperModelError: _told,
        AnswerError: _passed_on,
        HTTPException: _no_route,
        OSError: _failed,
        Exception: _failed,
    }
    return Guard(Starlette(routes=studio.routes(), exception_handlers=handlers, lifespan=studio.running), door)


def _files(*named: Named) -> list[FilePath]:
    """The files that an answer about these rests on."""
    return [item.file for item in named if item.file is not None]


async def _told(_: Request, error: Exception) -> Response:
    assert isinstance(error, ProperModelError)
    return JSONResponse(error_body(faults_of(error)), status_code=status_of(error))


async def _passed_on(_: Request, error: Exception) -> Response:
    assert isinstance(error, AnswerError)
    return JSONResponse(error_body(error.faults), status_code=error.status)


async def _no_route(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    refused = StudioError.with_status(
        error.status_code,
        "studio/page",
        f"there is no {request.method} of '{request.url.path[:200]}' here",
        help="open the page of the studio, /",
    )
    return await _told(request, refused)


async def _failed(request: Request, error: Exception) -> Response:
    _LOG.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return await _told(request, unexpected(error))
