"""Progress on stderr, when that is a terminal: simulated time, speed against real time, time left."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, TaskID, TextColumn
from rich.progress import Progress as RichProgress

if TYPE_CHECKING:
    from propermodel.simulation.simulate import Progress


class ProgressBars:
    """One bar for each stage; call it with the name of a stage and, during a run, how far it has come."""

    def __init__(self) -> None:
        console = Console(stderr=True)
        self._bars = RichProgress(
            TextColumn("{task.description:<24}"),
            BarColumn(),
            TextColumn("{task.fields[detail]}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()

    def __call__(self, stage: str, progress: Progress | None = None) -> None:
        if stage not in self._tasks:
            for task in self._tasks.values():
                self._bars.update(task, visible=False)
            self._tasks[stage] = self._bars.add_task(stage, total=None, detail="")
        if progress is not None:
            detail = (
                f"{progress.time:.0f} of {progress.stop:.0f} s, {progress.times_real_time:.0f} x real time, "
                f"{progress.seconds_left:.0f} s left"
            )
            self._bars.update(self._tasks[stage], total=1.0, completed=progress.fraction, detail=detail)
