"""A client of a real server, which says what a page would say."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from propermodel.studio.folder import Trust
from propermodel.studio.server import Listening, listening

Json = Any


@dataclass(frozen=True)
class Answer:
    """What a server has answered."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Json:
        return json.loads(self.body)

    @property
    def code(self) -> str:
        """The code of the error that it is."""
        return self.json["error"]["code"]


@dataclass
class Client:
    """Talks to the server of a folder."""

    folder: Path
    server: Listening
    cookie: str = ""
    default: dict[str, str] = field(default_factory=dict[str, str])

    def ask(
        self,
        method: str,
        path: str,
        body: bytes | None = None,
        headers: Mapping[str, str] | None = None,
        *,
        host: str = "",
    ) -> Answer:
        """One request, with the cookie unless the headers say otherwise."""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.door.port, timeout=60)
        try:
            connection.putrequest(method, path, skip_host=True)
            connection.putheader("Host", host or f"127.0.0.1:{self.server.door.port}")
            given = {"Cookie": self.cookie, **self.default, **(headers or {})}
            for name, value in given.items():
                if value:
                    connection.putheader(name, value)
            if body is not None:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders(body)
            response = connection.getresponse()
            return Answer(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        finally:
            connection.close()

    def get(self, path: str) -> Answer:
        return self.ask("GET", path)

    def post(self, path: str, data: Json) -> Answer:
        return self.ask("POST", path, json.dumps(data).encode(), {"Content-Type": "application/json"})

    def enter(self) -> Answer:
        """Come in through the address that the command prints."""
        answer = self.ask("GET", f"/?token={self.server.door.token}")
        self.cookie = answer.headers["set-cookie"].partition(";")[0]
        return answer

    def job(self, number: str) -> Json:
        return self.get(f"/api/jobs/{number}").json

    def wait(self, number: str, ready: Callable[[Json], bool], within: float = 60.0) -> Json:
        """The job when it is as it should be."""
        until = time.monotonic() + within
        while time.monotonic() < until:
            job = self.job(number)
            if ready(job):
                return job
            time.sleep(0.05)
        raise AssertionError(f"still {self.job(number)}")

    def wait_until_over(self, number: str) -> Json:
        return self.wait(number, lambda job: job["state"] not in ("queued", "running"))


class Running:
    """A server in a thread."""

    def __init__(self, folder: Path, trust: Path) -> None:
        self._context = listening(folder, trust=Trust(trust))
        self._folder = folder

    def __enter__(self) -> Client:
        self._server = self._context.__enter__()
        self._thread = threading.Thread(target=self._server.answer)
        self._thread.start()
        client = Client(self._folder, self._server)
        client.enter()
        return client

    def __exit__(self, *_: object) -> None:
        self._server.stop()
        self._thread.join(30)
        assert not self._thread.is_alive()
        self._context.__exit__(None, None, None)
