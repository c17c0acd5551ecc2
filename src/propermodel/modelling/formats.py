"""The formats of models and scenarios: what each type is in a document, entry by entry."""

from __future__ import annotations

from typing import Any, cast

from propermodel.diagnostics import ModelError
from propermodel.modelling.domains import DomainData, Shared
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
    Merge,
    Node,
    Opening,
    OpenPort,
    ParameterData,
    Part,
    PortData,
    PowerSource,
    Preference,
    Prescribe,
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
    NUMBERS,
    PATH,
    SOURCE,
    TEXT,
    UNIT,
    Codec,
    Json,
    Place,
    as_object,
    by_path,
    choice,
    many,
    optional,
    record,
    tagged,
    together,
)
from propermodel.modelling.tables import table_values


def _read_table(data: Json, place: Place) -> TableValues:
    plain = _PLAIN_TABLE.read(data, place)
    try:
        return table_values(plain.grids, plain.values)
    except ModelError as error:
        raise place.fault(error.diagnostics[0].message) from None


def _input(data: Json, place: Place) -> float | TableValues:
    return TABLE_VALUES.read(data, place) if isinstance(data, dict) else FINITE.read(data, place)


_PLAIN_TABLE = record(TableValues, grids=many(NUMBERS), values=NUMBERS)
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
    prescribe=(Prescribe, record(Prescribe, bond=PATH, driven=VARIABLE)),
    merge=(Merge, record(Merge, bond=PATH, into=PATH)),
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
