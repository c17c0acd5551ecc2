"""Pages that are told what happens, as server-sent events: one way is enough, and a browser asks again by itself."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncGenerator
from typing import Any

Json = Any

_WAITING = 1000  # events for a page that does not read them
_QUIET_S = 15.0  # after which a line is sent, as nobody else notices that a page has gone


class Listeners:
    """Who listens."""

    def __init__(self) -> None:
        self._waiting: set[asyncio.Queue[bytes | None]] = set()

    def tell(self, event: str, data: Json) -> None:
        """Tell all who listen now."""
        text = f"event: {event}\ndata: {json.dumps(data, allow_nan=False)}\n\n".encode()
        for waiting in list(self._waiting):
            if waiting.full():
                self._end(waiting)
            else:
                waiting.put_nowait(text)

    async def stream(self) -> AsyncGenerator[bytes]:
        """What is told from now on."""
        waiting: asyncio.Queue[bytes | None] = asyncio.Queue(_WAITING)
        self._waiting.add(waiting)
        try:
            yield b": the studio\n\n"
            while True:
                try:
                    text = await asyncio.wait_for(waiting.get(), _QUIET_S)
                except TimeoutError:
                    text = b": still here\n\n"
                if text is None:
                    return
                yield text
        finally:
            self._waiting.discard(waiting)

    def close(self) -> None:
        """End all streams."""
        for waiting in list(self._waiting):
            self._end(waiting)

    def _end(self, waiting: asyncio.Queue[bytes | None]) -> None:
        """End a stream; a page that lives asks for a new one, and for what it has missed."""
        self._waiting.discard(waiting)
        while not waiting.empty():
            waiting.get_nowait()
        waiting.put_nowait(None)
