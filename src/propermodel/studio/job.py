"""Jobs: runs and reductions, from the wish to the result, as they are kept on the disk."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from propermodel.diagnostics import Path
from propermodel.modelling.schema import BOOLEAN, COUNT, FINITE, PATH, TEXT, choice, many, optional, record, together
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER, ReductionOrder, RunOrder

Json = Any


class JobKind(StrEnum):
    """What a job makes."""

    RUN = "run"
    REDUCTION = "reduction"


class JobState(StrEnum):
    """How far a job is, or how it ended."""

    QUEUED = "queued"
    RUNNING = "running"
    COMPLETE = "complete"
    FAILED = "failed"
    CANCELLED = "cancelled"
    LOST = "lost"  # its process has ended without a word

    @property
    def is_over(self) -> bool:
        """Whether nothing more will come of it."""
        return self not in (JobState.QUEUED, JobState.RUNNING)


@dataclass(frozen=True, slots=True, kw_only=True)
class JobProgress:
    """How far a run is."""

    time: float  # s
    end: float  # s
    steps: int
    rejected: int
    rate: float  # times real time
    left: float | None  # s


@dataclass(frozen=True, slots=True)
class Fact:
    """A number with its name, and what must be known of it."""

    name: str
    value: str
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A run or a reduction."""

    id: str
    kind: JobKind
    model: str  # what names the model
    name: str  # what the model is called
    scenario: str
    created: str  # ISO 8601
    order: RunOrder | None = None
    reduction: ReductionOrder | None = None
    run: str | None = None  # of a reduction: its full run
    window: tuple[float, float] = (0.0, 0.0)  # s, as asked for
    state: JobState = JobState.QUEUED
    is_cancelling: bool = False
    progress: JobProgress | None = None
    message: str = ""
    elements: tuple[str, ...] = ()
    outputs: tuple[Path, ...] = ()
    spark: tuple[float, ...] | None = None
    summary: tuple[Fact, ...] = field(default=())

    def data(self) -> Json:
        """What pages see of it."""
        return {
            "id": self.id,
            "kind": self.kind.value,
            "model": self.model,
            "name": self.name,
            "scenario": self.scenario,
            "run": self.run,
            "window": list(self.window),
            "state": self.state.value,
            "created": self.created,
            "progress": None if self.progress is None else asdict(self.progress),
            "message": self.message,
            "elements": list(self.elements),
            "outputs": [str(path) for path in self.outputs],
            "spark": None if self.spark is None else list(self.spark),
            "summary": [asdict(fact) for fact in self.summary],
        }


JOB = record(
    Job,
    id=TEXT,
    kind=choice(JobKind),
    model=TEXT,
    name=TEXT,
    scenario=TEXT,
    created=TEXT,
    order=optional(RUN_ORDER),
    reduction=optional(REDUCTION_ORDER),
    run=optional(TEXT),
    window=together(FINITE, FINITE),
    state=choice(JobState),
    is_cancelling=BOOLEAN,
    progress=optional(
        record(JobProgress, time=FINITE, end=FINITE, steps=COUNT, rejected=COUNT, rate=FINITE, left=optional(FINITE))
    ),
    message=TEXT,
    elements=many(TEXT),
    outputs=many(PATH),
    spark=optional(many(FINITE)),
    summary=many(record(Fact, name=TEXT, value=TEXT, note=TEXT)),
)
