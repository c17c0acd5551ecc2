"""The texts in a saved trajectory: what is run, and how far it has come or how it ended."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from propermodel.codegen.machine import IntArray, Method
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import DocumentError, Path
from propermodel.modelling.documents import (
    from_document,
    from_scenario_document,
    to_document,
    to_scenario_document,
)
from propermodel.modelling.model import Model, Scenario
from propermodel.modelling.schema import (
    COUNT,
    FINITE,
    TEXT,
    Codec,
    Json,
    Place,
    choice,
    many,
    optional,
    read_number,
    record,
    together,
)
from propermodel.simulation.stepping import DEFAULT_TOLERANCE, Stepping
from propermodel.simulation.trajectory import Ending, EventRecord, RunStatus, Statistics, TableUse

T = TypeVar("T")


FORMAT = "propermodel-trajectory"
VERSION = 2


@dataclass(frozen=True, kw_only=True)
class Header:
    """What is known of a run when it begins."""

    method: Method
    step: float
    columns: tuple[tuple[Path, str, int], ...]  # observable, unit, column
    powers: tuple[tuple[str, Path], ...]  # kind and path of each integral
    scenario: Scenario
    model: Model
    jacobian_every: int = 1
    tolerance: float = DEFAULT_TOLERANCE
    notes: tuple[str, ...] = ()


def header_of(
    compiled: CompiledModel,
    scenario: Scenario,
    selected: IntArray,
    notes: tuple[str, ...],
    stepping: Stepping,
) -> Header:
    """The header of a run of which these entries of the program's signals are recorded, one in each column."""
    place = {int(entry): column for column, entry in enumerate(selected)}
    known = compiled.lowered.observables
    return Header(
        method=stepping.method,
        step=stepping.longest(),
        jacobian_every=stepping.jacobian_every,
        tolerance=stepping.tolerance,
        notes=notes,
        columns=tuple((path, seen.unit, place[seen.index]) for path, seen in known.items() if seen.index in place),
        powers=tuple((power.kind, power.path) for power in compiled.lowered.powers),
        scenario=scenario,
        model=compiled.model,
    )


@dataclass(frozen=True, kw_only=True)
class StoredProgress:
    """How far a run has come, with the events since this was last told; the last one tells how it ended."""

    time: float
    statistics: Statistics
    events: tuple[EventRecord, ...] = ()
    outside_tables: tuple[TableUse, ...] = ()
    notes: tuple[str, ...] = ()  # on what was found on the way
    ending: Ending | None = None


def _inner(write: Callable[[T], Json], read: Callable[..., T]) -> Codec[T]:
    """A document within this one."""

    def read_inner(data: Json, place: Place) -> T:
        try:
            return read(data, limits=place.references.limits)
        except DocumentError as error:
            faults = [replace(d, where=f"{place.text}: {d.where}".rstrip(": ")) for d in error.diagnostics]
            raise DocumentError(faults) from error

    return Codec(lambda value, _: write(value), read_inner)


def _read_any_number(data: Json, place: Place) -> float:
    return math.nan if data == "nan" else read_number(data, place)


# A failed run ends in numbers that are none.
_ANY_NUMBER: Codec[float] = Codec(lambda value, _: value if math.isfinite(value) else str(value), _read_any_number)
# Names of observables may hold dots, so their paths are lists.
_NAMES: Codec[Path] = Codec(lambda path, _: list(path), lambda data, place: Path(many(TEXT).read(data, place)))

# What tells of the rows of a run, in its header.
COLUMNS: Codec[tuple[tuple[Path, str, int], ...]] = many(together(_NAMES, TEXT, COUNT))
POWERS: Codec[tuple[tuple[str, Path], ...]] = many(together(TEXT, _NAMES))

HEADER = record(
    Header,
    method=choice(Method),
    step=FINITE,
    jacobian_every=COUNT,
    tolerance=FINITE,
    notes=many(TEXT),
    columns=COLUMNS,
    powers=POWERS,
    scenario=_inner(to_scenario_document, from_scenario_document),
    model=_inner(to_document, from_document),
)

PROGRESS = record(
    StoredProgress,
    time=_ANY_NUMBER,
    statistics=record(Statistics, steps=COUNT, wall_s=FINITE, build_s=FINITE, rejected=COUNT),
    events=many(record(EventRecord, time=FINITE, element=_NAMES, energy_before=_ANY_NUMBER, energy_after=_ANY_NUMBER)),
    notes=many(TEXT),
    outside_tables=many(record(TableUse, path=_NAMES, seconds=FINITE)),
    ending=optional(record(Ending, status=choice(RunStatus), message=TEXT, time=_ANY_NUMBER, path=_NAMES)),
)
