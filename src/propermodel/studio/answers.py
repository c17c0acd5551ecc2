"""Answers of workers, kept until a file that they rest on changes; who asks the same at the same time waits for one."""

from __future__ import annotations

import asyncio
import json
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

Json = Any
Stamp = tuple[tuple[str, int, int], ...]

MOST_KEPT = 64


@dataclass(frozen=True, slots=True)
class _Kept:
    content: Json
    stamp: Stamp


class Answers:
    """Answers by question."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, _Kept] = OrderedDict()
        self._asked: dict[str, asyncio.Future[Json]] = {}

    async def get(self, question: str, files: Sequence[FilePath], ask: Callable[[], Awaitable[bytes]]) -> Json:
        """The answer to a question about files, asked for where it is not known or no longer holds.

        Raises:
            AnswerError: there is none.
            StudioError: there is none.
        """
        kept = self._kept.get(question)
        if kept is not None and kept.stamp == _stamp(name for name, _, _ in kept.stamp):
            self._kept.move_to_end(question)
            return kept.content
        asked = self._asked.get(question)
        if asked is None:
            asked = self._asked[question] = asyncio.ensure_future(self._find(question, files, ask))
            asked.add_done_callback(lambda done: self._forget(question, done))
        # Who goes away must not take the answer with it from the others.
        return await asyncio.shield(asked)

    def _forget(self, question: str, done: asyncio.Future[Json]) -> None:
        self._asked.pop(question, None)
        if not done.cancelled():
            done.exception()  # it is told to those who wait, of whom there may be none left

    async def _find(self, question: str, files: Sequence[FilePath], ask: Callable[[], Awaitable[bytes]]) -> Json:
        before = _stamp(map(str, files))
        answer = json.loads(await ask())
        stamp = _stamp([*(name for name, _, _ in before), *answer["files"]])
        if stamp[: len(before)] == before:
            self._kept[question] = _Kept(answer["sheet"], stamp)
            while len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)
        return answer["sheet"]


def _stamp(files: Iterable[str]) -> Stamp:
    """What tells whether files have changed."""
    found: list[tuple[str, int, int]] = []
    for name in dict.fromkeys(files):
        try:
            status = FilePath(name).stat()
            found.append((name, status.st_mtime_ns, status.st_size))
        except OSError:  # gone: that is a change
            found.append((name, 0, -1))
    return tuple(found)
