"""Models and scenarios as documents: versioned JSON of plain data, safe to open.

A document holds every expression node and every definition once. Reading it checks all it says, within limits; nothing
in it is executed.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar, cast

from propermodel.diagnostics import DocumentError, ProperModelError
from propermodel.expressions.core import Expr
from propermodel.modelling.checks import faults_of
from propermodel.modelling.expression_documents import ExpressionTable, read_expressions
from propermodel.modelling.files import FileName, of_file, partial_file, read_bytes
from propermodel.modelling.formats import DEFINITION, DOMAIN, PART, REMOVAL, SCENARIO
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import LIMITS, Limits, exceeded
from propermodel.modelling.model import Definition, Model, Scenario
from propermodel.modelling.schema import (
    MOST_FAULTS,
    TEXT,
    Json,
    Place,
    Unreadable,
    as_index,
    as_list,
    as_object,
    described,
    many,
    record,
)

MODEL_FORMAT = "propermodel-model"
SCENARIO_FORMAT = "propermodel-scenario"
VERSION = 1

T = TypeVar("T")


MODEL = record(Model, name=TEXT, root=PART, domains=many(DOMAIN), removals=many(REMOVAL))


# -- models ---------------------------------------------------------------------------------------------


class SharedEntries:
    """The expressions, definitions and units of a document that is being written or has been read."""

    def __init__(self, limits: Limits = LIMITS) -> None:
        self.limits = limits
        self.units: set[str] = set()
        self.table = ExpressionTable()
        self.expressions: list[Expr] = []
        self.definitions: list[Definition] = []
        self.written: list[Json] = []
        self._by_identity: dict[int, int] = {}
        self._by_text: dict[str, int] = {}

    def write_expr(self, expr: Expr) -> Json:
        return self.table.index(expr)

    def read_expr(self, data: Json, place: Place) -> Expr:
        return self.expressions[as_index(data, len(self.expressions), place)]

    def write_definition(self, definition: Definition) -> Json:
        return self._by_identity[id(definition)]

    def read_definition(self, data: Json, place: Place) -> Definition:
        return self.definitions[as_index(data, len(self.definitions), place)]

    def add_definitions(self, root: Definition) -> None:
        """Write a definition after those it uses, each once, also where equal ones are different objects."""
        stack = [root]
        while stack:
            definition = stack[-1]
            inner = [p.definition for p in definition.parts if id(p.definition) not in self._by_identity]
            if id(definition) in self._by_identity:
                stack.pop()
            elif inner:
                stack.extend(reversed(inner))
            else:
                data = DEFINITION.write(definition, self)
                index = self._by_text.setdefault(json.dumps(data), len(self.written))
                if index == len(self.written):
                    self.written.append(data)
                self._by_identity[id(definition)] = index
                stack.pop()

    def read_definitions(self, data: Json, place: Place, faults: Unreadable) -> None:
        """Read definitions in order; each uses only earlier ones."""
        sizes: dict[int, _Size] = {}
        for index, item in enumerate(as_list(data, place)):
            definition = Definition(type_name="", doc="")  # in place of what cannot be read
            try:
                definition = DEFINITION.read(item, place.item(index))
            except DocumentError as error:
                faults.add(error)
            size = _size_of(definition, [sizes[id(part.definition)] for part in definition.parts])
            _check_size(size, self.limits, place.item(index))
            sizes[id(definition)] = size
            self.definitions.append(definition)


@dataclass(frozen=True, slots=True)
class _Size:
    """What a use of a definition comes to: parts, what they declare, and the names in the paths of all that."""

    parts: int
    declared: int
    names: int


def _size_of(definition: Definition, inner: list[_Size]) -> _Size:
    d = definition
    own = sum(map(len, (d.ports, d.parameters, d.tables, d.signals, d.discretes, d.events, d.connections)))
    declared = 1 + own + sum(size.declared for size in inner)
    return _Size(
        parts=1 + sum(size.parts for size in inner),
        declared=declared,
        names=declared + sum(size.names for size in inner),
    )


def _check_size(size: _Size, limits: Limits, place: Place) -> None:
    if size.parts > limits.parts:
        raise exceeded("parts", f"has {size.parts} parts in all; at most {limits.parts} are read", place.text)
    if size.names > limits.path_names:
        raise exceeded(
            "path_names",
            f"what its parts declare has {size.names} names in all; at most {limits.path_names} are read",
            place.text,
        )


def to_document(model: Model) -> dict[str, Json]:
    """The document of a model: plain data that JSON can hold, from which an equal model can be made."""
    shared = SharedEntries()
    shared.add_definitions(model.root.definition)
    document: dict[str, Json] = {
        "format": MODEL_FORMAT,
        "version": VERSION,
        "name": model.name,
        "domains": many(DOMAIN).write(model.domains, shared),
        "root": PART.write(model.root, shared),
        "removals": many(REMOVAL).write(model.removals, shared),
        "definitions": shared.written,
        "expressions": shared.table.nodes,
    }
    return document


def from_document(document: Json, *, limits: Limits = LIMITS) -> Model:
    """The model that a document holds.

    Raises:
        DocumentError: the document is not of this format or version, goes beyond a limit, or something in it is
            malformed.
    """
    shared = SharedEntries(limits)
    top = Place("", shared)
    given = opened(document, MODEL_FORMAT, top)
    entries = {"name", "domains", "root", "removals", "definitions", "expressions"}
    _check_entries(given, entries, top)
    unreadable = Unreadable()
    shared.expressions = read_expressions(given["expressions"], top.key("expressions"), unreadable)
    unreadable.raise_if_any()  # everything else refers to expressions
    shared.read_definitions(given["definitions"], top.key("definitions"), unreadable)
    model: Model | None = None
    try:
        model = MODEL.read({name: given[name] for name in ("name", "root", "domains", "removals")}, top)
    except DocumentError as error:
        unreadable.add(error)
    unreadable.raise_if_any()
    assert model is not None
    faults = faults_of(model, limits, most=MOST_FAULTS)
    if faults:
        raise DocumentError(faults)
    return model


def write_model(model: Model, path: FileName) -> None:
    """Write the document of a model to a file."""
    _write(to_document(model), path)


def read_model(path: FileName, *, limits: Limits = LIMITS) -> Model:
    """The model of a file.

    Raises:
        DocumentError: the file cannot be read, is not the document of a model, or goes beyond a limit.
    """
    return _read(path, from_document, limits)


# -- scenarios ------------------------------------------------------------------------------------------


def to_scenario_document(scenario: Scenario) -> dict[str, Json]:
    """The document of a scenario."""
    return {"format": SCENARIO_FORMAT, "version": VERSION, **SCENARIO.write(scenario, SharedEntries())}


def from_scenario_document(document: Json, *, limits: Limits = LIMITS) -> Scenario:
    """The scenario that a document holds.

    Raises:
        DocumentError: the document is not of this format or version, goes beyond a limit, or something in it is
            malformed.
    """
    top = Place("", SharedEntries(limits))
    return SCENARIO.read(opened(document, SCENARIO_FORMAT, top), top)


def write_scenario(scenario: Scenario, path: FileName) -> None:
    """Write the document of a scenario to a file."""
    _write(to_scenario_document(scenario), path)


def read_scenario(path: FileName, *, limits: Limits = LIMITS) -> Scenario:
    """The scenario of a file.

    Raises:
        DocumentError: the file cannot be read, is not the document of a scenario, or goes beyond a limit.
    """
    return _read(path, from_scenario_document, limits)


# -- files ----------------------------------------------------------------------------------------------


def opened(document: Json, wanted: str, top: Place, readable: int = VERSION) -> dict[str, Json]:
    """The entries of a document, without format and version, which are checked."""
    given = dict(as_object(document, top))
    found = given.pop("format", None)
    if found != wanted:
        what = described(found) if found is not None else "missing"
        raise DocumentError.of(
            "document/format",
            f"expected a document of format '{wanted}'; its format is {what.removeprefix('the text ')}",
            help=_FORMAT_CURE.get(found if isinstance(found, str) else "", "is it a document of this package?"),
        )
    version = given.pop("version", None)
    if isinstance(version, bool) or version != readable:
        what = described(version).removeprefix("the number ") if version is not None else "missing"
        raise DocumentError.of(
            "document/version",
            f"the version of this {wanted} document is {what}; version {readable} is read",
            help="open it with the release that wrote it, or a later one",
        )
    return given


_FORMAT_CURE = {
    MODEL_FORMAT: "read it with read_model",
    SCENARIO_FORMAT: "it is a scenario: read it with read_scenario, or pass it with --scenario",
}


def _check_entries(given: dict[str, Json], entries: set[str], top: Place) -> None:
    for name in sorted(entries - set(given)):
        raise top.fault(f"the entry '{name}' is missing")
    for name in given:
        if name not in entries:
            raise top.fault(f"unknown entry {name[:60]!r}")


def _write(document: dict[str, Json], path: FileName) -> None:
    partial = partial_file(path)
    partial.write_text(_text(document), encoding="utf-8", newline="\n")
    partial.replace(path)


def _text(document: dict[str, Json]) -> str:
    """JSON with one line for each definition and expression, so that two versions can be compared."""
    entries: list[str] = []
    for key, value in document.items():
        if isinstance(value, list) and value:
            items = ",\n    ".join(json.dumps(item, allow_nan=False) for item in cast("list[Json]", value))
            text = f"[\n    {items}\n  ]"
        else:
            text = json.dumps(value, allow_nan=False)
        entries.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(entries) + "\n}\n"


def _read(path: FileName, read: Callable[..., T], limits: Limits) -> T:
    try:
        return read(parse_json(read_bytes(path, limits.file_bytes, "file_bytes"), limits), limits=limits)
    except ProperModelError as error:
        raise of_file(error, path) from error
