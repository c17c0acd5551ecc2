"""Starts the studio's server on the loopback of this machine."""

from __future__ import annotations

import socket
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path as FilePath

import uvicorn

from propermodel.studio.app import Studio, make_app
from propermodel.studio.faults import StudioError
from propermodel.studio.folder import Trust
from propermodel.studio.guard import Door

_SECONDS_TO_CLOSE = 2  # that open streams get when the server ends


@dataclass(frozen=True)
class Listening:
    """A server that listens, and does not answer yet."""

    door: Door
    _server: uvicorn.Server
    _listener: socket.socket

    def answer(self) -> None:
        """Answer requests until somebody stops the server, by Ctrl-C or otherwise."""
        self._server.run(sockets=[self._listener])

    def stop(self) -> None:
        """Have the server end, from another thread; jobs keep what they have."""
        self._server.should_exit = True


@contextmanager
def listening(root: FilePath, *, port: int = 0, trust: Trust | None = None) -> Generator[Listening]:
    """A server of a folder.

    Args:
        root: The folder whose models can be opened, and in which runs are kept.
        port: Where to listen; by default a free port.
        trust: In which folders Python files may be run; by default what the user has agreed to.

    Raises:
        StudioError: the port is taken, or another server has the folder.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        try:
            listener.bind(("127.0.0.1", port))
        except OSError as error:
            raise StudioError.with_status(
                503,
                "studio/port",
                f"port {port} cannot be used: {error.strerror}",
                help="name another port, or none to have a free one",
            ) from error
        studio = Studio(root, trust)
        studio.queue.open()
        listener.listen(512)
        door = Door(listener.getsockname()[1])
        config = uvicorn.Config(
            make_app(studio, door),
            log_level="warning",
            access_log=False,
            server_header=False,
            ws="none",
            lifespan="on",
            timeout_graceful_shutdown=_SECONDS_TO_CLOSE,
        )
        try:
            yield Listening(door, uvicorn.Server(config), listener)
        finally:
            studio.queue.store.close()
