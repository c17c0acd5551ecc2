"""Models and scenarios as documents: versioned JSON of plain data, safe to open.

A document holds every expression node and every definition once. Reading it checks all it says; nothing in it
is executed.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections import Counter
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any, TypeVar, cast

from propermodel.diagnostics import DocumentError, ModelError, ProperModelError, Source, portable_file
from propermodel.expressions.core import Expr
from propermodel.modelling.checks import faults_of
from propermodel.modelling.domains import DomainData, Shared
from propermodel.modelling.expression_documents import ExpressionTable, read_expressions
from propermodel.modelling.model import (
    Activation,
    Block,
    ConstantEffort,
    ConstantFlow,
    Coordinate,
    Cut,
    Definition,
    Direction,
    ElementKind,
    Event,
    Freeze,
    HalfArrow,
    JunctionKind,
    Model,
    Node,
    Opening,
    OpenPort,
    ParameterData,
    Part,
    PortData,
    PowerSource,
    Preference,
    ResistanceLaw,
    Resistive,
    Result,
    Sampled,
    Scenario,
    SignalData,
    SignalLink,
    Storage,
    TableSpec,
    TableValues,
    TwoPort,
    Variable,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.modelling.schema import (
    BOOLEAN,
    EXPR,
    FINITE,
    NAME,
    NUMBER,
    PATH,
    SOURCE,
    TEXT,
    UNIT,
    Codec,
    Json,
    Place,
    as_index,
    as_list,
    as_object,
    by_path,
    choice,
    described,
    malformed,
    many,
    optional,
    record,
    tagged,
    together,
)
from propermodel.modelling.tables import table_values

MODEL_FORMAT = "propermodel-model"
SCENARIO_FORMAT = "propermodel-scenario"
VERSION = 1
LARGEST_FILE = 64 * 1024 * 1024  # bytes
MOST_PARTS = 1_000_000

T = TypeVar("T")


# -- the format -----------------------------------------------------------------------------------------


def _read_table(data: Json, place: Place) -> TableValues:
    plain = _PLAIN_TABLE.read(data, place)
    try:
        return table_values(plain.grids, plain.values)
    except ModelError as error:
        raise place.fault(error.diagnostics[0].message) from None


def _input(data: Json, place: Place) -> float | TableValues:
    return TABLE_VALUES.read(data, place) if isinstance(data, dict) else FINITE.read(data, place)


_PLAIN_TABLE = record(TableValues, grids=many(many(FINITE)), values=many(FINITE))
TABLE_VALUES: Codec[TableValues] = Codec(_PLAIN_TABLE.write, _read_table)
INPUT: Codec[float | TableValues] = Codec(
    lambda value, refs: (TABLE_VALUES if isinstance(value, TableValues) else FINITE).write(cast("Any", value), refs),
    _input,
)
NAMED_EXPR = together(NAME, EXPR)
VARIABLE = choice(Variable)

COORDINATE = record(Coordinate, name=NAME, unit=UNIT, start=EXPR, low=EXPR, high=EXPR)
RESULT = record(Result, port=NAME, variable=VARIABLE, value=EXPR)
BEHAVIOUR = tagged(
    resistance=(
        Resistive,
        record(
            Resistive,
            laws=many(record(ResistanceLaw, results=many(RESULT))),
            locked=optional(EXPR),
            implicit=many(EXPR),
            converts=BOOLEAN,
            preference=optional(choice((Preference.EFFORT, Preference.FLOW))),
        ),
    ),
    storage=(
        Storage,
        record(
            Storage,
            kind=choice((ElementKind.COMPLIANCE, ElementKind.INERTIA)),
            coordinates=many(COORDINATE),
            stored=many(NAMED_EXPR),
            outputs=many(NAMED_EXPR),
            energy=EXPR,
            inverse=optional(EXPR),
            preference=optional(choice((Preference.INTEGRAL, Preference.DERIVATIVE))),
        ),
    ),
    source=(
        PowerSource,
        record(PowerSource, kind=choice((ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE)), value=EXPR),
    ),
    two_port=(
        TwoPort,
        record(
            TwoPort,
            kind=choice((ElementKind.TRANSFORMER, ElementKind.GYRATOR)),
            modulus=EXPR,
            position=optional(EXPR),
        ),
    ),
    junction=(
        JunctionKind,
        Codec(
            lambda kind, _: {"kind": kind.value},
            lambda data, place: choice(JunctionKind).read(as_object(data, place).get("kind"), place.key("kind")),
        ),
    ),
    block=(
        Block,
        record(Block, outputs=many(NAMED_EXPR), states=many(COORDINATE), derivatives=many(NAMED_EXPR)),
    ),
    sampled=(
        Sampled,
        record(Sampled, period=EXPR, starts=many(together(NAME, UNIT, EXPR)), updates=many(NAMED_EXPR)),
    ),
)
CONNECTION = tagged(
    node=(Node, record(Node, ports=many(PATH), source=SOURCE)),
    bond=(HalfArrow, record(HalfArrow, tail=PATH, head=PATH, source=SOURCE)),
    activated_bond=(
        Activation,
        record(Activation, tail=PATH, head=PATH, carries=choice(Variable), source=SOURCE),
    ),
    signal=(SignalLink, record(SignalLink, value=EXPR, targets=many(PATH), source=SOURCE)),
    open=(OpenPort, record(OpenPort, port=PATH, opening=choice(Opening), source=SOURCE)),
)
REMOVAL = tagged(
    zero_effort=(ZeroEffort, record(ZeroEffort, bond=PATH)),
    zero_flow=(ZeroFlow, record(ZeroFlow, bond=PATH)),
    constant_effort=(ConstantEffort, record(ConstantEffort, bond=PATH, value=FINITE)),
    constant_flow=(ConstantFlow, record(ConstantFlow, bond=PATH, value=FINITE)),
    cut=(Cut, record(Cut, bond=PATH, driven=VARIABLE)),
    freeze=(Freeze, record(Freeze, signal=PATH, value=FINITE)),
)
DOMAIN = record(
    DomainData,
    name=NAME,
    effort=TEXT,
    effort_unit=UNIT,
    flow=TEXT,
    flow_unit=UNIT,
    displacement_unit=UNIT,
    momentum_unit=UNIT,
    shared=choice(Shared),
    datum=TEXT,
    is_true=BOOLEAN,
)
PART = record(
    Part,
    name=NAME,
    definition=Codec(
        lambda definition, refs: refs.write_definition(definition),
        lambda data, place: place.references.read_definition(data, place),
    ),
    values=many(NAMED_EXPR),
    tables=many(together(NAME, TABLE_VALUES)),
    source=SOURCE,
)
DEFINITION = record(
    Definition,
    type_name=TEXT,
    doc=TEXT,
    ports=many(record(PortData, name=NAME, domain=NAME, between=optional(together(NAME, NAME)))),
    parameters=many(
        record(
            ParameterData,
            name=NAME,
            unit=UNIT,
            default=optional(EXPR),
            low=NUMBER,
            high=NUMBER,
            source=TEXT,
            status=TEXT,
            doc=TEXT,
        )
    ),
    tables=many(
        record(
            TableSpec,
            name=NAME,
            unit=UNIT,
            coordinate_units=many(UNIT),
            extrapolation=TEXT,
            values=TABLE_VALUES,
            source=TEXT,
        )
    ),
    signals=many(record(SignalData, name=NAME, unit=UNIT, direction=choice(Direction))),
    behaviour=optional(BEHAVIOUR),
    discretes=many(together(NAME, UNIT, EXPR)),
    events=many(
        record(
            Event,
            condition=EXPR,
            changes=many(together(EXPR, EXPR)),
            restitution=optional(EXPR),
            source=SOURCE,
        )
    ),
    parts=many(PART),
    connections=many(CONNECTION),
    is_energy_group=BOOLEAN,
    source=SOURCE,
)
SCENARIO = record(
    Scenario,
    name=TEXT,
    start=FINITE,
    stop=FINITE,
    inputs=by_path(INPUT),
    tables=by_path(TABLE_VALUES),
    initial=by_path(FINITE),
    parameters=by_path(FINITE),
    description=TEXT,
)


# -- models ---------------------------------------------------------------------------------------------


class _Shared:
    """The expressions and definitions of a document that is being written or has been read."""

    def __init__(self) -> None:
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

    def read_definitions(self, data: Json, place: Place) -> None:
        """Read definitions in order; each uses only earlier ones."""
        sizes: dict[int, int] = {}
        for index, item in enumerate(as_list(data, place)):
            definition = DEFINITION.read(item, place.item(index))
            size = 1 + sum(sizes[id(part.definition)] for part in definition.parts)
            if size > MOST_PARTS:
                raise place.item(index).fault(f"has {size} parts in all; at most {MOST_PARTS} are read")
            sizes[id(definition)] = size
            self.definitions.append(definition)


def to_document(model: Model) -> dict[str, Json]:
    """The document of a model: plain data that JSON can hold, from which an equal model can be made."""
    shared = _Shared()
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


def from_document(document: Json) -> Model:
    """The model that a document holds.

    Raises:
        DocumentError: the document is not of this format or version, or something in it is malformed.
    """
    shared = _Shared()
    top = Place("", shared)
    given = _opened(document, MODEL_FORMAT, top)
    entries = {"name", "domains", "root", "removals", "definitions", "expressions"}
    _check_entries(given, entries, top)
    shared.expressions = read_expressions(given["expressions"], top.key("expressions"))
    shared.read_definitions(given["definitions"], top.key("definitions"))
    model = Model(
        name=TEXT.read(given["name"], top.key("name")),
        root=PART.read(given["root"], top.key("root")),
        domains=many(DOMAIN).read(given["domains"], top.key("domains")),
        removals=many(REMOVAL).read(given["removals"], top.key("removals")),
    )
    faults = faults_of(model)
    if faults:
        raise DocumentError(faults)
    return model


def write_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write the document of a model to a file."""
    _write(to_document(model), path)


def read_model(path: str | os.PathLike[str]) -> Model:
    """The model of a file.

    Raises:
        DocumentError: the file cannot be read, or is not the document of a model.
    """
    return _read(path, from_document)


# -- scenarios ------------------------------------------------------------------------------------------


def to_scenario_document(scenario: Scenario) -> dict[str, Json]:
    """The document of a scenario."""
    return {"format": SCENARIO_FORMAT, "version": VERSION, **SCENARIO.write(scenario, _Shared())}


def from_scenario_document(document: Json) -> Scenario:
    """The scenario that a document holds.

    Raises:
        DocumentError: the document is not of this format or version, or something in it is malformed.
    """
    top = Place("", _Shared())
    return SCENARIO.read(_opened(document, SCENARIO_FORMAT, top), top)


def write_scenario(scenario: Scenario, path: str | os.PathLike[str]) -> None:
    """Write the document of a scenario to a file."""
    _write(to_scenario_document(scenario), path)


def read_scenario(path: str | os.PathLike[str]) -> Scenario:
    """The scenario of a file.

    Raises:
        DocumentError: the file cannot be read, or is not the document of a scenario.
    """
    return _read(path, from_scenario_document)


# -- files ----------------------------------------------------------------------------------------------


def _opened(document: Json, wanted: str, top: Place) -> dict[str, Json]:
    """The entries of a document, without format and version, which are checked."""
    given = dict(as_object(document, top))
    found = given.pop("format", None)
    if found != wanted:
        what = described(found) if found is not None else "missing"
        raise _refused(
            "document/format",
            f"expected a document of format '{wanted}'; its format is {what.removeprefix('the text ')}",
            _FORMAT_CURE.get(found if isinstance(found, str) else "", "is it a document of this package?"),
        )
    version = given.pop("version", None)
    if isinstance(version, bool) or version != VERSION:
        what = described(version) if version is not None else "missing"
        raise _refused(
            "document/version",
            f"the version of this {wanted} document is {what.removeprefix('the number ')}; version {VERSION} is read",
            "open it with the release that wrote it, or a later one",
        )
    return given


_JSON_CURE = "open a file that propermodel wrote (write_model, write_scenario), complete and unchanged"
_FORMAT_CURE = {
    MODEL_FORMAT: "read it with read_model",
    SCENARIO_FORMAT: "it is a scenario: read it with read_scenario, or pass it with --scenario",
}


def _refused(code: str, message: str, help: str = "") -> DocumentError:
    return DocumentError.of(code, message, help=help)


def _check_entries(given: dict[str, Json], entries: set[str], top: Place) -> None:
    for name in sorted(entries - set(given)):
        raise top.fault(f"the entry '{name}' is missing")
    for name in given:
        if name not in entries:
            raise top.fault(f"unknown entry '{name:.60}'")


def _write(document: dict[str, Json], path: str | os.PathLike[str]) -> None:
    target = FilePath(path)
    partial = target.with_name(f"{target.name}.part")
    partial.write_text(_text(document), encoding="utf-8")
    partial.replace(target)


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


def _read(path: str | os.PathLike[str], read: Callable[[Json], T]) -> T:
    file = portable_file(os.fspath(path))
    try:
        size = FilePath(path).stat().st_size
        if size > LARGEST_FILE:
            raise _refused(
                "document/size",
                f"the file has {size} bytes; at most {LARGEST_FILE} are read",
                f"is it a document of this package? Those have less than {LARGEST_FILE // 2**20} MB",
            )
        return read(_parsed(FilePath(path).read_text(encoding="utf-8")))
    except OSError as error:
        problem = _refused("document/file", f"the file cannot be read: {error.strerror or error}", "check the path")
    except UnicodeDecodeError:
        problem = _refused("document/json", "the file is not text in UTF-8", _JSON_CURE)
    except ProperModelError as error:
        problem = error
    raise DocumentError([dataclasses.replace(d, source=Source(file, 0)) for d in problem.diagnostics]) from problem


def _parsed(text: str) -> Json:
    try:
        return json.loads(text, object_pairs_hook=_once, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise _refused(
            "document/json", f"the file is not JSON: {error.msg} in line {error.lineno}", _JSON_CURE
        ) from error
    except RecursionError:
        raise _refused(
            "document/json", "the file is not a document: its JSON is nested too deeply", _JSON_CURE
        ) from None
    except ValueError as error:
        raise _refused("document/json", f"the file is not JSON: {error}", _JSON_CURE) from error


def _once(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    found = dict(pairs)
    if len(found) < len(pairs):
        double = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise malformed("", f"the entry '{double:.60}' is given twice in one object")
    return found


def _no_constant(text: str) -> float:
    raise malformed("", f"'{text}' is not a number of JSON", 'infinities are written as "inf" and "-inf"')
