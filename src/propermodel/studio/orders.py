"""What pages ask to be run or reduced: read from JSON, checked, and written down with the job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from propermodel.compiler import Method
from propermodel.diagnostics import Path
from propermodel.modelling.documents import SharedEntries
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import Limits
from propermodel.modelling.schema import (
    FINITE,
    PATH,
    TEXT,
    Codec,
    Json,
    Place,
    as_object,
    by_path,
    many,
    optional,
    record,
)
from propermodel.simulation.choosing import AUTO, Choice

T = TypeVar("T")

LIMITS = Limits(file_bytes=2**20, values=50_000, depth=8, text_characters=2000)


@dataclass(frozen=True, kw_only=True)
class RunOrder:
    """A run to be made; what is not said is as the model has it."""

    model: str
    scenario: str = ""
    until: float | None = None  # s
    method: str = ""
    step: float | None = None  # s
    tolerance: float | None = None
    settings: Mapping[Path, str] = field(default_factory=dict[Path, str])  # values of parameters with their units
    outputs: tuple[Path, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ReductionOrder:
    """A reduction to be made of a full run."""

    run: str
    threshold: float
    begin: float | None = None  # of the window that is ranked, s
    end: float | None = None
    keep: tuple[Path, ...] = ()  # rows that stay whatever they do
    go: tuple[Path, ...] = ()  # rows that may go whatever they do
    outputs: tuple[Path, ...] = ()


def _renamed(inner: Codec[T], names: Mapping[str, str]) -> Codec[T]:
    """Entries under other names in the text than in the type."""
    back = {value: key for key, value in names.items()}

    def read(data: Json, place: Place) -> T:
        return inner.read({names.get(key, key): value for key, value in as_object(data, place).items()}, place)

    def write(value: T, references: Any) -> Json:
        return {back.get(key, key): item for key, item in inner.write(value, references).items()}

    return Codec(write, read)


RUN_ORDER = record(
    RunOrder,
    model=TEXT,
    scenario=TEXT,
    until=optional(FINITE),
    method=TEXT,
    step=optional(FINITE),
    tolerance=optional(FINITE),
    settings=by_path(TEXT),
    outputs=many(PATH),
)
REDUCTION_ORDER = _renamed(
    record(
        ReductionOrder,
        run=TEXT,
        threshold=FINITE,
        begin=optional(FINITE),
        end=optional(FINITE),
        keep=many(PATH),
        go=many(PATH),
        outputs=many(PATH),
    ),
    {"from": "begin", "to": "end"},
)


def read_order(codec: Codec[T], body: bytes) -> T:
    """The order in the body of a request.

    Raises:
        DocumentError: it is none.
    """
    return read_order_data(codec, parse_json(body, LIMITS))


def read_order_data(codec: Codec[T], data: Json) -> T:
    """The order that plain data hold.

    Raises:
        DocumentError: they hold none.
    """
    return codec.read(data, Place("", SharedEntries(LIMITS)))


def order_data(codec: Codec[T], order: T) -> Json:
    """An order as plain data."""
    return codec.write(order, SharedEntries(LIMITS))


def method_of(text: str) -> Choice | None:
    """The method of this name; None for no name."""
    return None if not text else AUTO if text == AUTO else Method(text)
