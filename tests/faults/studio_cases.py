"""Faults that the studio tells: at its door, about the folder that it serves, and about its jobs."""

from __future__ import annotations

import asyncio
import io
import json
import socket
from collections.abc import Callable, Coroutine
from dataclasses import replace
from pathlib import Path
from typing import Any

from starlette.types import Message
from typer.testing import CliRunner

from propermodel.cli.app import app
from propermodel.diagnostics import parse_path
from propermodel.studio.activity_task import compare
from propermodel.studio.app import Studio, make_app
from propermodel.studio.faults import StudioError, unexpected
from propermodel.studio.folder import Folder, Trust
from propermodel.studio.guard import MOST_BYTES, Door
from propermodel.studio.job import Job, JobKind, JobState
from propermodel.studio.orders import RunOrder
from propermodel.studio.recorded import RecordedRun, RecordedRuns
from propermodel.studio.results import bonds_of
from propermodel.studio.run_task import ordered_subject
from propermodel.studio.server import listening
from propermodel.studio.worker import Control
from propermodel.studio.workers import Worker, Workers
from tests.faults.case import Case
from tests.faults.document_cases import file_of
from tests.faults.quarter import STEP, quarter, run

DOOR = Door(8000, "secret")
JSON = ("content-type", "application/json")


def folder() -> Folder:
    """A folder with a model in Python."""
    return Folder(file_of("", "rig.py").parent)


def studio() -> Studio:
    served = folder()
    return Studio(served.root, Trust(served.root / "trust.json"))


def answer(
    path: str,
    *headers: tuple[str, str],
    method: str = "GET",
    cookie: str = "secret",
    data: object = None,
    prepare: Callable[[Studio], None] = lambda _: None,
) -> Callable[[], str]:
    """What the server answers, as it would be printed."""

    def ask() -> str:
        served = studio()
        prepare(served)
        status, body = asyncio.run(_ask(served, path, headers, method, cookie, json.dumps(data).encode()))
        assert status >= 400
        text = body.decode()
        if text.startswith("{"):
            error = json.loads(text)["error"]
            return f"error[{error['code']}]: {error['message']}\n  help: {error['help']}"
        return text

    return ask


async def _ask(
    served: Studio, path: str, headers: tuple[tuple[str, str], ...], method: str, cookie: str, content: bytes
) -> tuple[int, bytes]:
    given = {"host": "127.0.0.1:8000", "cookie": f"{DOOR.cookie}={cookie}", **dict(headers)}
    name, _, query = path.partition("?")
    scope = {
        "type": "http",
        "method": method,
        "path": name,
        "raw_path": name.encode(),
        "query_string": query.encode(),
        "headers": [(key.encode(), value.encode()) for key, value in given.items()],
    }
    sent: list[Message] = []

    async def receive() -> Message:
        return {"type": "http.request", "body": content, "more_body": False}

    async def send(message: Message) -> None:
        sent.append(message)

    await make_app(served, DOOR)(scope, receive, send)
    return sent[0]["status"], b"".join(message.get("body", b"") for message in sent[1:])


def with_worker(task: Callable[[Workers], Coroutine[Any, Any, object]]) -> Callable[[], object]:
    """What becomes of a question to a worker whose program is exchanged for another one."""

    def ask() -> object:
        async def asked() -> object:
            workers = Workers(Path.cwd())
            try:
                return await task(workers)
            finally:
                await workers.close()

        return asyncio.run(asked())

    return ask


async def killed(workers: Workers) -> object:
    worker = await Worker.start(Path.cwd())
    worker.kill()
    return await worker.do("model", {"model": "half-car"})


async def waited_for(workers: Workers) -> object:
    return await workers.ask("model", {"model": "half-car"}, within=0.0)


def recorded() -> RecordedRun:
    import propermodel as pm

    file = file_of("", "run.npz")
    pm.save_trajectory(run(), file)
    return RecordedRuns().get(file)


def saved(start: float, stop: float) -> str:
    """The file of a run."""
    import propermodel as pm

    file = file_of("", "run.npz")
    pm.simulate(
        quarter(), replace(STEP, start=start, stop=stop), record_every=0.01, integrals_every=0.05, record_to=file
    )
    return str(file)


def job(**changes: Any) -> Job:
    given: dict[str, Any] = {
        "id": "1",
        "kind": JobKind.RUN,
        "model": "half-car",
        "name": "Half car",
        "scenario": "",
        "created": "2026-01-01T00:00:00+00:00",
        "order": RunOrder(model="half-car"),
    }
    return Job(**{**given, **changes})


def busy() -> object:
    served = studio()
    (served.folder.root / "propermodel-runs" / "1").mkdir(parents=True)
    served.queue.add(job(state=JobState.RUNNING))
    return asyncio.run(served.queue.delete("1"))


def body(path: str, data: object) -> Callable[[], str]:
    """What is answered to an order, of a folder with a run that has failed."""
    return answer(path, JSON, method="POST", data=data, prepare=with_failed_run)


def with_failed_run(served: Studio) -> None:
    (served.folder.root / "propermodel-runs" / "1").mkdir(parents=True)
    served.queue.add(job(state=JobState.FAILED))


def taken_port() -> str:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen(1)
        port = other.getsockname()[1]
        try:
            with listening(folder().root, port=port):
                return "it listens"
        except StudioError as error:
            return str(error).replace(str(port), "8000")


def two_servers() -> object:
    served, other = studio(), None
    (served.folder.root / "propermodel-runs").mkdir()
    served.queue.open()
    try:
        other = Studio(served.folder.root, served.trust)
        return other.queue.open()
    finally:
        served.queue.store.close()


def raised() -> object:
    try:
        return int("seven")
    except ValueError as error:
        raise unexpected(error) from None


def command() -> str:
    return CliRunner().invoke(app, ["studio", "nowhere"]).stderr


CASES = (
    Case(
        code="command/studio",
        run=command,
        names=("'nowhere' is no folder and no model",),
        cure="give a folder",
    ),
    Case(code="studio/busy", run=busy, names=("job 1 is not over",), cure="cancel it first"),
    Case(
        code="studio/content-type",
        run=answer("/api/runs", ("content-type", "text/plain"), method="POST"),
        names=("'text/plain'",),
        cure="send it as",
    ),
    Case(code="studio/failed", run=raised, names=("ValueError",), cure="the terminal of the studio"),
    Case(code="studio/file", run=lambda: folder().model("gone.py:Rig"), names=("gone.py",), cure="reload the list"),
    Case(code="studio/folder", run=two_servers, names=("another studio",), cure="use its page"),
    Case(
        code="studio/host",
        run=answer("/api/start", ("host", "evil.example")),
        names=("evil.example",),
        cure="open http://127.0.0.1:8000/",
    ),
    Case(
        code="studio/incomplete",
        run=body("/api/reductions", {"run": "1", "threshold": 0.9}),
        names=("job 1 is no complete run",),
        cure="to its end first",
    ),
    Case(code="studio/job", run=lambda: studio().queue.get("12"), names=("'12'",), cure="reload the list"),
    Case(
        code="studio/method",
        run=lambda: ordered_subject(RunOrder(model="half-car", method="magic")),
        names=("'magic'",),
        cure="semi-implicit-euler",
    ),
    Case(code="studio/model", run=lambda: folder().model("half-kar"), names=("half-kar",), cure="'half-car'"),
    Case(
        code="studio/no-reduction",
        run=answer("/api/reductions/1", prepare=with_failed_run),
        names=("job 1 is no complete reduction",),
        cure="ask when it is complete",
    ),
    Case(
        code="studio/no-rows",
        run=lambda: RecordedRuns().get(folder().root / "run.npz"),
        names=("nothing is recorded",),
        cure="ask again",
    ),
    Case(
        code="studio/origin",
        run=answer("/api/start", ("origin", "http://evil.example")),
        names=("evil.example",),
        cure="the studio's own page",
    ),
    Case(code="studio/outside", run=lambda: folder().file("../rig.py"), names=("../rig.py",), cure="name a file below"),
    Case(code="studio/page", run=answer("/api/nowhere"), names=("/api/nowhere",), cure="open the page"),
    Case(code="studio/port", run=taken_port, names=("cannot be used",), cure="name another port"),
    Case(code="studio/request", run=answer("/api/model"), names=("'id'",), cure="?id="),
    Case(
        code="studio/nothing-common",
        run=lambda: compare({"a": saved(0.0, 0.1), "b": saved(2.0, 2.1), "outputs": []}, Control(io.BytesIO())),
        names=("no time in common", "0.1 s"),
        cure="of one scenario",
    ),
    Case(
        code="studio/row",
        run=lambda: bonds_of({"suspension.spring": ["suspension.spring.port"]}, "suspension.spirng"),
        names=("suspension.spirng",),
        cure="did you mean 'suspension.spring'?",
    ),
    Case(
        code="studio/signal",
        run=lambda: recorded().nearest([parse_path("seat.momentum")], 0.0),
        names=("seat.momentum",),
        cure="body.momentum",
    ),
    Case(code="studio/timeout", run=with_worker(waited_for), names=("after 0 s",), cure="the process was ended"),
    Case(code="studio/token", run=answer("/api/start", cookie="no"), names=("not been let in",), cure="the token"),
    Case(
        code="studio/too-large",
        run=answer("/api/runs", JSON, ("content-length", str(MOST_BYTES + 1)), method="POST"),
        names=(str(MOST_BYTES),),
        cure="into a file",
    ),
    Case(code="studio/untrusted", run=answer("/api/model?id=rig.py:Rig"), names=("rig.py:Rig",), cure="agree once"),
    Case(code="studio/worker", run=with_worker(killed), names=("has ended",), cure="Ask again"),
)
