"""What listeners are told."""

from __future__ import annotations

import asyncio

from propermodel.studio import listeners
from propermodel.studio.listeners import Listeners


def test_all_who_listen_are_told_until_the_end():
    async def listen() -> list[list[bytes]]:
        told = Listeners()
        streams = [told.stream() for _ in range(2)]
        heard = [[await anext(stream)] for stream in streams]
        told.tell("job", {"id": "1", "message": "a\nb"})
        told.close()
        for stream, lines in zip(streams, heard, strict=True):
            lines.extend([line async for line in stream])
        return heard

    one, other = asyncio.run(listen())
    assert one == other == [b": the studio\n\n"]  # what was not read before the end is not told any more


def test_events_are_single_lines_of_json():
    async def listen() -> bytes:
        told = Listeners()
        stream = told.stream()
        await anext(stream)
        told.tell("job", {"message": "a\nb"})
        text = await anext(stream)
        await stream.aclose()
        told.tell("job", {})  # nobody listens
        return text

    assert asyncio.run(listen()) == b'event: job\ndata: {"message": "a\\nb"}\n\n'


def test_a_page_that_does_not_read_is_sent_away(monkeypatch):
    monkeypatch.setattr(listeners, "_WAITING", 3)

    async def listen() -> list[bytes]:
        told = Listeners()
        stream = told.stream()
        await anext(stream)
        for number in range(5):
            told.tell("job", {"id": number})
        return [line async for line in stream]

    assert asyncio.run(listen()) == []


def test_a_quiet_stream_shows_that_it_lives(monkeypatch):
    monkeypatch.setattr(listeners, "_QUIET_S", 0.01)

    async def listen() -> bytes:
        stream = Listeners().stream()
        await anext(stream)
        text = await anext(stream)
        await stream.aclose()
        return text

    assert asyncio.run(listen()) == b": still here\n\n"
