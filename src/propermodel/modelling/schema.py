"""How values become plain JSON data and back, with the place in the document in every complaint.

A `Codec` is a pair of functions; a document format is a declaration of codecs. The names in a file are those
written in the declaration, so a file format changes only where somebody changes it.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, Protocol, TypeVar, cast

from propermodel.diagnostics import Diagnostic, DocumentError, Path, ProperModelError, Source, nearest, portable_file
from propermodel.expressions.core import Expr
from propermodel.expressions.units import parse_unit
from propermodel.modelling.limits import Limits, exceeded

Json = Any
T = TypeVar("T")
E = TypeVar("E", bound=StrEnum)

CONTENT = "document/content"
MOST_FAULTS = 20  # told of one document

# What makes a screen do other things than to show a text, and halves of characters, which no file can hold.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")


class References(Protocol):
    """What the parts of a document share: expressions and definitions are stored once and referred to."""

    limits: Limits
    units: set[str]  # that have been read

    def write_expr(self, expr: Expr) -> Json: ...
    def read_expr(self, data: Json, place: Place) -> Expr: ...
    def write_definition(self, definition: Any) -> Json: ...
    def read_definition(self, data: Json, place: Place) -> Any: ...


@dataclass(frozen=True, slots=True)
class Place:
    """Where in a document we are, `definitions[3].ports[0].domain`, and what the document shares."""

    text: str
    references: References

    def key(self, name: str) -> Place:
        """The entry of this name."""
        return Place(f"{self.text}.{name}" if self.text else name, self.references)

    def item(self, index: int) -> Place:
        """The item at this index."""
        return Place(f"{self.text}[{index}]", self.references)

    def fault(self, message: str, help: str = "") -> DocumentError:
        """The error for what stands here."""
        return malformed(self.text, message, help)


class Unreadable:
    """What is wrong with a document, collected while it is read; beyond a limit reading stops at once."""

    def __init__(self) -> None:
        self.found: list[Diagnostic] = []

    def add(self, error: DocumentError) -> None:
        """Remember a fault, and go on unless there are many or it is no matter of content."""
        self.found.extend(error.diagnostics)
        if len(self.found) >= MOST_FAULTS or any(d.code != CONTENT for d in error.diagnostics):
            self.raise_if_any()

    def raise_if_any(self) -> None:
        """Raise what was found, as far as it is told."""
        if self.found:
            raise DocumentError(self.found[:MOST_FAULTS])


def malformed(where: str, message: str, help: str = "") -> DocumentError:
    """The error for a document with unreadable content."""
    cure = help or "correct the document here, or write it again with the program that made the model"
    return DocumentError.of(CONTENT, message, where=where or "the document", help=cure)


def described(data: Json) -> str:
    """What a piece of JSON is, for messages."""
    match data:
        case None:
            return "nothing"
        case bool():
            return "true" if data else "false"
        case int() | float():
            return f"the number {_digits(data)}"
        case str():
            return f"the text {data!r:.60}"
        case dict():
            return "an object"
        case list():
            return "a list"
        case _:
            return f"a {type(data).__name__}"


def _digits(data: float) -> str:
    if isinstance(data, int) and data.bit_length() > 256:
        return f"with {data.bit_length()} bits"
    return f"{data!r:.40}"


def as_list(data: Json, place: Place) -> list[Json]:
    """The data, if it is a list."""
    if not isinstance(data, list):
        raise place.fault(f"expected a list, found {described(data)}")
    return cast("list[Json]", data)


def as_object(data: Json, place: Place) -> dict[str, Json]:
    """The data, if it is an object with text keys."""
    if not isinstance(data, dict):
        raise place.fault(f"expected an object, found {described(data)}")
    entries = cast("dict[Any, Json]", data)
    for key in entries:
        if not isinstance(key, str):
            raise place.fault(f"expected text for the name of an entry, found {described(key)}")
    return entries


def as_index(data: Json, length: int, place: Place) -> int:
    """The data, if it is an index below `length`."""
    if isinstance(data, bool) or not isinstance(data, int):
        raise place.fault(f"expected the number of an earlier entry, found {described(data)}")
    if not 0 <= data < length:
        raise place.fault(f"refers to entry {described(data).removeprefix('the number ')}, which is not before it")
    return data


@dataclass(frozen=True, slots=True)
class Codec(Generic[T]):
    """How one kind of value is written and read."""

    write: Callable[[T, References], Json]
    read: Callable[[Json, Place], T]


# -- leaves ---------------------------------------------------------------------------------------------


def check_text(text: str, fault: Callable[[str], ProperModelError]) -> str:
    """The text, if it can be shown: without control characters."""
    if _CONTROL.search(text):
        raise fault(f"the text {text[:60]!r} has control characters")
    return text


def _write_text(value: str, _: References) -> Json:
    return check_text(value, lambda message: malformed("the model", message))


def _read_text(data: Json, place: Place) -> str:
    if not isinstance(data, str):
        raise place.fault(f"expected text, found {described(data)}")
    most = place.references.limits.text_characters
    if len(data) > most:
        raise exceeded("text_characters", f"a text has {len(data)} characters; at most {most} are read", place.text)
    return check_text(data, place.fault)


def _read_unit(data: Json, place: Place) -> str:
    text = _read_text(data, place)
    known, most = place.references.units, place.references.limits.units
    if text in known:
        return text
    if len(known) == most:
        raise exceeded("units", f"there are more than {most} different units", place.text)
    try:
        parse_unit(text)
    except ProperModelError as error:
        raise place.fault(error.diagnostics[0].message, error.diagnostics[0].help) from None
    known.add(text)
    return text


def check_name(text: str, fault: Callable[[str], ProperModelError]) -> str:
    """The text, if it can be one name of a path."""
    if not text or "." in text or not text.isprintable():
        raise fault(f"{text[:60]!r} cannot be a name: names are not empty, can be shown, and have no dots")
    return text


def _write_name(value: str, _: References) -> Json:
    return check_name(value, lambda message: malformed("the model", message))


def _read_name(data: Json, place: Place) -> str:
    return _short(check_name(_read_text(data, place), place.fault), place)


def _short(name: str, place: Place) -> str:
    most = place.references.limits.name_characters
    if len(name) > most:
        raise exceeded("name_characters", f"a name has {len(name)} characters; at most {most} are read", place.text)
    return name


def path_text(path: Path) -> str:
    """A path with dots; its names must have none."""
    for name in path:
        check_name(name, lambda message: malformed(str(path), message))
    return str(path)


def _read_path(data: Json, place: Place) -> Path:
    text = _read_text(data, place)
    path = Path(text.split(".")) if text else Path()
    for name in path:
        _short(check_name(name, place.fault), place)
    return path


def number_data(value: float) -> Json:
    """A number as JSON: exact, with infinities as text."""
    if math.isnan(value):
        raise malformed("the model", "a value is not a number (nan) and cannot be written")
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return float(value)


def read_number(data: Json, place: Place) -> float:
    """A number from JSON."""
    if data in ("inf", "-inf"):
        return float(data)
    if isinstance(data, bool) or not isinstance(data, (int, float)):
        raise place.fault(f"expected a number, found {described(data)}")
    try:
        value = float(data)
    except OverflowError:
        raise place.fault(f"{described(data)} is too large") from None
    if not math.isfinite(value):
        raise place.fault("expected a number, found one that is not finite", 'write infinities as "inf" or "-inf"')
    return value


def _read_finite(data: Json, place: Place) -> float:
    value = read_number(data, place)
    if not math.isfinite(value):
        raise place.fault("expected a finite number")
    return value


def _read_numbers(data: Json, place: Place) -> tuple[float, ...]:
    items = as_list(data, place)
    most = place.references.limits.table_points
    if len(items) > most:
        raise exceeded("table_points", f"a table has {len(items)} numbers; at most {most} are read", place.text)
    if set(map(type, items)) == {float} and all(map(math.isfinite, items)):
        return tuple(items)
    return tuple(_read_finite(item, place.item(index)) for index, item in enumerate(items))


def _write_numbers(values: tuple[float, ...]) -> list[Json]:
    return list(map(float if all(map(math.isfinite, values)) else number_data, values))


def _read_bool(data: Json, place: Place) -> bool:
    if not isinstance(data, bool):
        raise place.fault(f"expected true or false, found {described(data)}")
    return data


def _read_source(data: Json, place: Place) -> Source:
    match data:
        case [str() as file, line]:
            return Source(_read_text(file, place.item(0)), _read_count(line, place.item(1)))
        case _:
            raise place.fault("expected a file name and a line number", 'for example ["models/rig.py", 41]')


def _read_count(data: Json, place: Place) -> int:
    if isinstance(data, bool) or not isinstance(data, int) or not 0 <= data < 2**63:
        raise place.fault(f"expected a count, found {described(data)}")
    return data


TEXT: Codec[str] = Codec(_write_text, _read_text)
COUNT: Codec[int] = Codec(lambda value, _: value, _read_count)
UNIT: Codec[str] = Codec(_write_text, _read_unit)
NAME: Codec[str] = Codec(_write_name, _read_name)
PATH: Codec[Path] = Codec(lambda path, _: path_text(path), _read_path)
NUMBER: Codec[float] = Codec(lambda value, _: number_data(value), read_number)
FINITE: Codec[float] = Codec(lambda value, _: number_data(value), _read_finite)
BOOLEAN: Codec[bool] = Codec(lambda value, _: value, _read_bool)
NUMBERS: Codec[tuple[float, ...]] = Codec(lambda values, _: _write_numbers(values), _read_numbers)
SOURCE: Codec[Source] = Codec(
    lambda source, references: [_write_text(portable_file(source.file), references), source.line], _read_source
)
EXPR: Codec[Expr] = Codec(
    lambda expr, references: references.write_expr(expr),
    lambda data, place: place.references.read_expr(data, place),
)


# -- combinations ---------------------------------------------------------------------------------------


def choice(members: Iterable[E]) -> Codec[E]:
    """One of some members of an enumeration, by value."""
    known = {member.value: member for member in members}

    def read(data: Json, place: Place) -> E:
        text = _read_text(data, place)
        if text not in known:
            options = ", ".join(known)
            raise place.fault(f"expected one of {options}; found {described(data)}", nearest(text, known))
        return known[text]

    return Codec(lambda value, _: value.value, read)


def optional(inner: Codec[T]) -> Codec[T | None]:
    """A value or nothing."""
    return Codec(
        lambda value, references: None if value is None else inner.write(value, references),
        lambda data, place: None if data is None else inner.read(data, place),
    )


def many(inner: Codec[T]) -> Codec[tuple[T, ...]]:
    """Any number of values of one kind."""
    return Codec(
        lambda values, references: [inner.write(value, references) for value in values],
        lambda data, place: tuple(_each(place, ((inner, item) for item in as_list(data, place)))),
    )


def _each(place: Place, items: Iterable[tuple[Codec[Any], Json]]) -> list[Any]:
    """The items of a list, each with what reads it; all that cannot be read is told."""
    faults = Unreadable()
    values: list[Any] = []
    for index, (codec, item) in enumerate(items):
        try:
            values.append(codec.read(item, place.item(index)))
        except DocumentError as error:
            faults.add(error)
    faults.raise_if_any()
    return values


def together(*inner: Codec[Any]) -> Codec[Any]:
    """A fixed number of values, as a tuple."""

    def read(data: Json, place: Place) -> tuple[Any, ...]:
        items = as_list(data, place)
        if len(items) != len(inner):
            raise place.fault(f"expected a list of {len(inner)}, found one of {len(items)}")
        return tuple(_each(place, zip(inner, items, strict=True)))

    return Codec(
        lambda values, references: [c.write(value, references) for c, value in zip(inner, values, strict=True)],
        read,
    )


def by_path(inner: Codec[T]) -> Codec[Mapping[Path, T]]:
    """Values by path, as an object."""

    def read(data: Json, place: Place) -> dict[Path, T]:
        faults = Unreadable()
        values: dict[Path, T] = {}
        for key, value in as_object(data, place).items():
            try:
                values[_read_path(key, place)] = inner.read(value, place.key(key))
            except DocumentError as error:
                faults.add(error)
        faults.raise_if_any()
        return values

    return Codec(
        lambda values, references: {path_text(path): inner.write(v, references) for path, v in values.items()}, read
    )


def record(cls: type[T], **entries: Codec[Any]) -> Codec[T]:
    """A dataclass as an object; fields that have their default value are left out."""
    defaults = {f.name: _default(f) for f in dataclasses.fields(cast("Any", cls))}

    def write(value: T, references: References) -> Json:
        found: dict[str, Json] = {}
        for name, codec in entries.items():
            item = getattr(value, name)
            if defaults[name] is dataclasses.MISSING or item != defaults[name]:
                found[name] = codec.write(item, references)
        return found

    def read(data: Json, place: Place) -> T:
        given = as_object(data, place)
        faults = Unreadable()
        for name in given:
            if name not in entries:
                faults.add(place.fault(f"unknown entry {name[:60]!r}", nearest(name, entries)))
        values: dict[str, Any] = {}
        for name, codec in entries.items():
            try:
                if name in given:
                    values[name] = codec.read(given[name], place.key(name))
                elif defaults[name] is dataclasses.MISSING:
                    raise place.fault(f"the entry '{name}' is missing")
            except DocumentError as error:
                faults.add(error)
        faults.raise_if_any()
        return cls(**values)

    return Codec(write, read)


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def tagged(**alternatives: tuple[type, Codec[Any]]) -> Codec[Any]:
    """One of several types, told apart by the entry `type`."""

    def write(value: Any, references: References) -> Json:
        for tag, (cls, codec) in alternatives.items():
            if isinstance(value, cls):
                return {"type": tag, **codec.write(value, references)}
        raise TypeError(f"a document cannot hold a {type(value).__name__}")

    def read(data: Json, place: Place) -> Any:
        given = dict(as_object(data, place))
        tag = _read_text(given.pop("type", None), place.key("type"))
        if tag not in alternatives:
            options = ", ".join(alternatives)
            raise place.key("type").fault(f"expected one of {options}; found {tag[:60]!r}", nearest(tag, alternatives))
        return alternatives[tag][1].read(given, place)

    return Codec(write, read)
