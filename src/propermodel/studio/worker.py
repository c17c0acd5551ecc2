"""A process that does tasks for the server: `python -P -m propermodel.studio.worker FOLDER`.

It is told a task in a line of JSON on its standard input, and answers on its standard output: lines of JSON that say
how far it is, then a line with the length of the answer, and the answer. What else is printed, by a model of the user's
say, goes to the standard error. The line `cancel` asks it to stop with what it has; when its input ends, so does it.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any, BinaryIO

Json = Any

_PATIENCE_S = 5.0  # that a task has to stop after the server is gone


class Control:
    """The way back to the server."""

    def __init__(self, channel: BinaryIO) -> None:
        self._channel = channel
        self._lock = threading.Lock()
        self._cancelled = threading.Event()
        self._orders: queue.SimpleQueue[Json | None] = queue.SimpleQueue()

    def next(self) -> Json | None:
        """The next task, when it comes; None when there will be none."""
        return self._orders.get()

    @property
    def is_cancelled(self) -> bool:
        """Whether the task should stop."""
        return self._cancelled.is_set()

    def say(self, data: Json) -> None:
        """Tell how far the task is."""
        self._send({"said": data})

    def listen(self, stream: BinaryIO) -> None:
        """Hear tasks and the word to stop, until the server ends."""
        for line in stream:
            if line.strip() == b"cancel":
                self._cancelled.set()
            else:
                self._orders.put(json.loads(line))
        self._cancelled.set()
        self._orders.put(None)
        # Nobody is there to read an answer. A task that looks at its word stops by itself.
        threading.Timer(_PATIENCE_S, os._exit, [1]).start()

    def answer(self, content: bytes) -> None:
        """Give the result."""
        self._send({"answer": len(content)}, content)

    def refuse(self, status: int, faults: list[Json]) -> None:
        """Say why there is none."""
        self._send({"faults": faults, "status": status})

    def _send(self, head: Json, content: bytes = b"") -> None:
        with self._lock:
            self._channel.write(json.dumps(head).encode() + b"\n" + content)
            self._channel.flush()


def main() -> None:
    """Do the tasks that come on the standard input."""
    # A key that stops the server reaches the processes of its terminal; the server decides about this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    control = Control(channel)
    threading.Thread(target=control.listen, args=[sys.stdin.buffer], daemon=True).start()
    # Imported now, so that a task finds a process that is ready.
    import propermodel.studio.tasks

    os.chdir(sys.argv[1])
    while (order := control.next()) is not None:
        _do(propermodel.studio.tasks.do, order, control)
    channel.close()
    sys.stdout.flush()
    # Threads of a user's model need not let the process end.
    os._exit(0)


def _do(task: Callable[[str, Json, Control], bytes], order: Json, control: Control) -> None:
    from propermodel.diagnostics import ProperModelError
    from propermodel.studio.faults import faults_of, status_of, unexpected

    try:
        control.answer(task(order["task"], order["arguments"], control))
    except ProperModelError as error:
        control.refuse(status_of(error), faults_of(error))
    except Exception as error:  # noqa: BLE001 (a model is a program of the user's: whatever it raises is told)
        traceback.print_exc()
        control.refuse(500, faults_of(unexpected(error)))


if __name__ == "__main__":
    main()
