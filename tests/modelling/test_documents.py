"""Documents: everything comes back equal, and nothing malformed gets in."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.diagnostics import DocumentError, Path, parse_path
from propermodel.expressions import Expr, sin
from propermodel.expressions.core import SymbolKind, constant, symbol
from propermodel.modelling import (
    Component,
    ConstantEffort,
    ConstantFlow,
    Controller,
    Cut,
    Discrete,
    EffortSource,
    Freeze,
    Input,
    Model,
    MultiportCompliance,
    OneJunction,
    Output,
    Parameter,
    Port,
    Resistance,
    Scenario,
    SignalBlock,
    State,
    TableValues,
    Translation,
    Updates,
    ZeroEffort,
    ZeroFlow,
    bond,
    connect,
    elaborate,
    parameter,
    prescribed_flow,
    quantity,
    table,
)
from propermodel.modelling.documents import (
    SharedEntries,
    from_document,
    from_scenario_document,
    read_model,
    read_scenario,
    to_document,
    to_scenario_document,
    write_model,
    write_scenario,
)
from propermodel.modelling.formats import DEFINITION, PART, SCENARIO
from propermodel.modelling.model import Definition, Part, Variable
from propermodel.modelling.schema import Place
from tests.expressions.strategies import SYMBOLS, expressions
from tests.parts import Fixed, Lever, Mass, SpringDamper
from tests.rigs import rigs


class Engine(EffortSource):
    """Pulls as its table says; the first line is kept, this one is not.

    Not kept either.
    """

    flange = Port(Translation)
    throttle = Input("1")
    pull = table("kN", ("m/s", "1"), [[0.0, 10.0, 20.0], [0.0, 1.0]], [0, 5, 0, 4, 0, 1.5], source="made up")

    def effort(self) -> Expr:
        return -self.pull(self.flange.flow, self.throttle)


class Governor(Controller):
    speed = Input("m/s")
    throttle = Output("1", start=0.25)
    integral = Discrete("m", start=1.5)
    target: Parameter = parameter("km/h", default=36.0, low=0.0, high=130.0, source="handbook", status="estimated")

    def step(self) -> Updates:
        error = self.target - self.speed
        return {
            self.integral: self.integral + error * self.period,
            self.throttle: self.integral * quantity(0.1, "1/m"),
        }


class Filter(SignalBlock):
    given = Input("m/s")
    taken = Output("m/s")
    smooth = State("m/s", start=0.1)

    def outputs(self) -> Updates:
        return {self.taken: self.smooth}

    def derivatives(self) -> Updates:
        return {self.smooth: (self.given - self.smooth) / quantity(0.2, "s")}


class Brake(Resistance):
    port = Port(Translation)
    closed = Input("1")
    force: Parameter = parameter("N", default=1000.0)
    energy_group = True

    def effort(self, flow: Expr) -> Expr:
        return self.force * flow / quantity(0.1, "m/s")

    def locked(self) -> Expr:
        return (self.closed > 0.5) & ~(self.force < quantity(1.0, "N"))


class Coupled(MultiportCompliance):
    one = Port(Translation)
    two = Port(Translation)
    first = State("m", start=0.125)
    second = State("m")

    def energy(self) -> Expr:
        return quantity(8.0, "N/m") * (self.first * self.first + self.first * self.second + self.second**2)


class Vehicle(Component):
    """One of everything."""

    road = Port(Translation)
    pedal = Input("1")
    scale: Parameter = parameter("1", default=1.0)
    load: Parameter = parameter("kg", default=quantity(2.0, "t") * scale)

    engine = Engine()
    governor = Governor()
    smooth = Filter()
    body = Mass(mass=load)
    front = SpringDamper(stiffness=0.1 + 0.2, damping=1e-300)
    rear = SpringDamper(stiffness=2.0e5, damping=1.0 / 3.0)
    lever = Lever(ratio=2.0)
    trailer = Mass(mass=load * sin(scale))
    brake = Brake()
    field = Coupled()
    carriage = Mass(mass=1.0)
    node = OneJunction()

    connections = (
        connect(road, front.a, rear.a),
        connect(front.b, rear.b, body.flange, engine.flange, lever.a, brake.port),
        connect(lever.b, trailer.flange, field.one),
        bond(field.two, node),
        bond(node, carriage.flange),
        connect(body.flange.flow, smooth.given),
        connect(smooth.taken, governor.speed),
        connect(governor.throttle, engine.throttle),
        connect(pedal, brake.closed),
        prescribed_flow(road),
    )


VEHICLE = elaborate(Vehicle())
REMOVALS = (
    ZeroEffort(parse_path("front.damper.port")),
    ZeroFlow(parse_path("rear.spring.port")),
    ConstantEffort(parse_path("front.spring.port"), 1.0 / 3.0),
    ConstantFlow(parse_path("trailer.flange"), -0.0),
    Cut(parse_path("body.flange"), Variable.EFFORT),
    Freeze(parse_path("governor.speed"), 1e-12),
)


def through_json(document: dict[str, Any]) -> Any:
    return json.loads(json.dumps(document, allow_nan=False))


# -- round trips --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("removals", [(), REMOVALS])
def test_model_comes_back_equal(removals):
    model = VEHICLE.without(removals)
    assert from_document(through_json(to_document(model))) == model


def test_model_comes_back_from_a_file(tmp_path):
    file = tmp_path / "vehicle.json"
    write_model(VEHICLE.without(REMOVALS), file)
    assert read_model(file) == VEHICLE.without(REMOVALS)
    assert [p.name for p in tmp_path.iterdir()] == ["vehicle.json"]


def test_document_of_a_document_is_the_same():
    document = to_document(VEHICLE.without(REMOVALS))
    assert to_document(from_document(through_json(document))) == document


@given(rigs())
@settings(max_examples=25)
def test_any_rig_comes_back_equal(rig):
    model = elaborate(rig.component())
    assert from_document(through_json(to_document(model))) == model


def model_of(expr: Expr, **values: Expr) -> Model:
    """A model whose only law is an expression of the parameters x, y, z."""

    class Source(EffortSource):
        flange = Port(Translation)
        x: Parameter = parameter("", default=1.0)
        y: Parameter = parameter("", default=2.0)
        z: Parameter = parameter("", default=3.0)

        def effort(self) -> Expr:
            return quantity(1.0, "N")

    model = elaborate(Source())
    definition = dataclasses.replace(
        model.root.definition, behaviour=dataclasses.replace(model.root.definition.behaviour, value=expr)
    )
    part = dataclasses.replace(model.root, definition=definition, values=tuple(values.items()))
    return dataclasses.replace(model, root=part)


@given(expressions(size=15))
@settings(max_examples=100)
def test_any_expression_comes_back_as_the_same_object(expr):
    model = from_document(through_json(to_document(model_of(expr))))
    assert model.root.definition.behaviour.value is expr


@given(st.floats(allow_nan=False))
def test_numbers_come_back_exactly(value):
    model = model_of(constant(value, "N"), x=constant(value))
    back = from_document(through_json(to_document(model)))
    assert back == model
    assert back.root.values[0][1].data[0] == value


def test_deep_expressions_meet_no_recursion_limit():
    expr = SYMBOLS[0]
    for n in range(5000):
        expr = sin(expr) * SYMBOLS[n % 3]
    assert from_document(through_json(to_document(model_of(expr)))).root.definition.behaviour.value is expr


def test_deep_nesting_meets_no_recursion_limit():
    definition = model_of(SYMBOLS[0]).root.definition
    for _ in range(3000):
        definition = Definition(type_name="Shell", doc="", parts=(Part(name="inner", definition=definition),))
    model = dataclasses.replace(VEHICLE, root=Part(name="deep", definition=definition))
    back = from_document(through_json(to_document(model)))
    assert to_document(back) == to_document(model)


# -- what a document looks like -------------------------------------------------------------------------------


def test_definition_and_expression_are_stored_once():
    document = to_document(VEHICLE)
    names = [d["type_name"] for d in document["definitions"]]
    assert len(names) == len(set(names))
    assert names[-1] == "Vehicle"
    nodes = [json.dumps(node) for node in document["expressions"]]
    assert len(nodes) == len(set(nodes))


def test_equal_definitions_that_are_two_objects_are_stored_once():
    class Twice(Component):
        left = Mass(mass=1.0)
        right = Mass(mass=2.0)
        connections = (connect(left.flange, right.flange),)

    model = elaborate(Twice())
    left, right = model.root.definition.parts
    apart = dataclasses.replace(right, definition=copy.copy(right.definition))
    assert apart.definition is not left.definition
    definition = dataclasses.replace(model.root.definition, parts=(left, apart))
    document = to_document(dataclasses.replace(model, root=dataclasses.replace(model.root, definition=definition)))
    assert [d["type_name"] for d in document["definitions"]] == ["Mass", "Twice"]


def test_small_document():
    class Rig(Component):
        mass = Mass(mass=2.0)
        wall = Fixed()
        connections = (connect(mass.flange, wall.flange),)

    document = to_document(elaborate(Rig()).without([ZeroEffort(parse_path("mass.flange"))]))
    assert (document["format"], document["version"], document["name"]) == ("propermodel-model", 1, "rig")
    assert document["removals"] == [{"type": "zero_effort", "bond": "mass.flange"}]
    mass, fixed, _ = document["definitions"]
    assert mass["type_name"] == "Mass"
    assert mass["parameters"] == [{"name": "mass", "unit": "kg"}]
    assert mass["behaviour"]["type"] == "storage"
    assert fixed["behaviour"]["kind"] == "Sf"
    low = document["expressions"][mass["behaviour"]["coordinates"][0]["low"]]
    assert low == ["constant", "-inf"]


def test_files_are_named_relative_to_the_project():
    sources = [d["source"][0] for d in to_document(VEHICLE)["definitions"]]
    written_out = "src/propermodel/modelling/elements.py"  # the junction
    assert set(sources) == {"tests/parts.py", "tests/modelling/test_documents.py", written_out}


def test_files_outside_the_project_keep_only_their_name(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    source = dataclasses.replace(VEHICLE.root.definition.source, file="/home/somebody/secret/rig.py")
    definition = dataclasses.replace(VEHICLE.root.definition, source=source)
    model = dataclasses.replace(VEHICLE, root=dataclasses.replace(VEHICLE.root, definition=definition))
    assert to_document(model)["definitions"][-1]["source"][0] == "rig.py"


def test_every_field_of_the_model_is_in_the_document():
    # A field that is added to the model must find its way into documents, or be left out on purpose.
    for codec, cls in ((PART, Part), (DEFINITION, Definition), (SCENARIO, Scenario)):
        names = {f.name for f in dataclasses.fields(cls)}
        for name in names:
            with pytest.raises(DocumentError) as caught:
                codec.read({name: object()}, Place("", SharedEntries()))
            assert "unknown entry" not in str(caught.value)


def test_numbers_that_are_none_are_not_written():
    with pytest.raises(DocumentError, match="not a number"):
        to_document(model_of(constant(math.nan, "N")))


def test_names_with_dots_are_not_written():
    part = dataclasses.replace(VEHICLE.root.definition.parts[0], name="a.b")
    definition = dataclasses.replace(VEHICLE.root.definition, parts=(part,))
    model = dataclasses.replace(VEHICLE, root=dataclasses.replace(VEHICLE.root, definition=definition))
    with pytest.raises(DocumentError, match=r"'a\.b' cannot be a name"):
        to_document(model)


def test_leftovers_of_equations_are_not_written():
    with pytest.raises(DocumentError, match="which is not of the model"):
        to_document(model_of(symbol(SymbolKind.UNKNOWN, Path(("x",)))))


# -- what is refused ------------------------------------------------------------------------------------------


def refused(document: Any) -> DocumentError:
    with pytest.raises(DocumentError) as caught:
        from_document(document)
    return caught.value


def changed(*keys: Any, to: Any) -> Any:
    """The document of the vehicle with another value at one place."""
    document = through_json(to_document(VEHICLE.without(REMOVALS)))
    place = document
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = to
    return document


def test_other_format():
    assert str(refused(changed("format", to="something-else"))) == (
        "error[document/format]: expected a document of format 'propermodel-model'; "
        "its format is 'something-else'\n"
        "  help: is it a document of this package?"
    )
    assert "its format is missing" in str(refused({}))
    for wrong in (None, [], 3, "model"):
        assert "expected an object" in str(refused(wrong))


def test_other_version():
    assert str(refused(changed("version", to=2))) == (
        "error[document/version]: the version of this propermodel-model document is 2; version 1 is read\n"
        "  help: open it with the release that wrote it, or a later one"
    )
    assert "is true; version 1 is read" in str(refused(changed("version", to=True)))


def index_of(name: str) -> int:
    return [d["type_name"] for d in to_document(VEHICLE)["definitions"]].index(name)


MASS = index_of("Mass")
VEHICLE_AT = index_of("Vehicle")


@pytest.mark.parametrize(
    ("keys", "value", "where", "message"),
    [
        (("name",), 3, "name", "expected text, found the number 3"),
        (("root",), [], "root", "expected an object, found a list"),
        (("definitions",), {}, "definitions", "expected a list, found an object"),
        (("root", "definition"), 99, "root.definition", "refers to entry 99, which is not before it"),
        (("root", "definition"), True, "root.definition", "expected the number of an earlier entry, found true"),
        (("root", "extra"), 1, "root", "unknown entry 'extra'"),
        (
            ("definitions", MASS, "behaviour", "type"),
            "storag",
            f"definitions[{MASS}].behaviour.type",
            "expected one of resistance, storage, source, two_port, junction, block, sampled; found 'storag'",
        ),
        (
            ("definitions", MASS, "parameters", 0, "unit"),
            "cubits2x",
            f"definitions[{MASS}].parameters[0].unit",
            "'cubits2x' is not a unit",
        ),
        (
            ("definitions", MASS, "parameters", 0, "low"),
            1e999,
            f"definitions[{MASS}].parameters[0].low",
            "expected a number, found one that is not finite",
        ),
        (
            ("definitions", VEHICLE_AT, "parts", 0, "definition"),
            VEHICLE_AT,
            f"definitions[{VEHICLE_AT}].parts[0].definition",
            f"refers to entry {VEHICLE_AT}, which is not before it",
        ),
        (
            ("definitions", VEHICLE_AT, "source"),
            ["rig.py", -1],
            f"definitions[{VEHICLE_AT}].source[1]",
            "expected a count, found the number -1",
        ),
        (("removals", 0, "bond"), "front..port", "removals[0].bond", "'' cannot be a name"),
        (("removals", 2, "value"), None, "removals[2].value", "expected a number, found nothing"),
        (("removals", 2, "value"), "inf", "removals[2].value", "expected a finite number"),
        (("expressions", 0), [], "expressions[0]", "expected a node of an expression, found an empty list"),
        (("expressions", 0), ["constant"], "expressions[0]", "expected a node of an expression"),
    ],
)
def test_malformed_content_is_named_with_its_place(keys, value, where, message):
    error = refused(changed(*keys, to=value))
    (fault,) = error.diagnostics
    assert fault.where.startswith(where)
    assert message in fault.message
    assert str(error).startswith("error[document/content]: ")


X, CONDITION, TABLE, NEXT = 0, 1, 2, 3


@pytest.mark.parametrize(
    ("node", "where", "message"),
    [
        (["+", X, NEXT], "[2]", "refers to entry 3, which is not before it"),
        (["+", X, -1], "[2]", "refers to entry -1, which is not before it"),
        (["+", X], "", "'+' takes two arguments, 1 were given"),
        (["sin", X, X], "", "'sin' takes one argument, 2 were given"),
        (["where", X, X, X], "", "'where' has a condition where a number is due"),
        (["and", X, CONDITION], "", "'and' has a condition where a number is due"),
        (["+", X, CONDITION], "", "'+' has a condition where a number is due"),
        (["lookup", X, X], "", "'lookup' has a table where a number is due"),
        (["lookup", TABLE, TABLE], "", "'lookup' has a table where a number is due"),
        (["sin", TABLE], "", "'sin' has a table where a number is due"),
        (["lookup", TABLE], "", "'lookup' takes two or three arguments"),
        (["slope", 1, TABLE, X], "", "'slope' takes two or three arguments"),
        (["**", X, X], "", "the exponent of a power must be a bare number"),
        (["symbol", "unknown", "a", ""], "[1]", "expected the kind of a symbol"),
        (["symbol", "parameter", "", ""], "[2]", "expected the path of a symbol"),
        (["constant", 1.0, "furlong/fortnights2x"], "[2]", "is not a unit"),
        (["constant", None], "[1]", "expected a number, found nothing"),
        (["eval", "1"], "", "expected a node of an expression"),
        (["sin", "x"], "[1]", "expected the number of an earlier entry, found the text 'x'"),
    ],
)
def test_malformed_expression_is_named_with_its_place(node, where, message):
    nodes = [["symbol", "parameter", "x", ""], ["<", 0, 0], ["symbol", "table", "map", ""], node]
    error = refused(changed("expressions", to=nodes))
    (fault,) = error.diagnostics
    assert fault.where == f"expressions[3]{where}"
    assert message in fault.message


def test_missing_entry():
    document = changed("name", to="x")
    del document["removals"]
    assert "the entry 'removals' is missing" in str(refused(document))
    document = changed("name", to="x")
    del document["definitions"][MASS]["behaviour"]["energy"]
    assert "the entry 'energy' is missing" in str(refused(document))


def test_unknown_entry_offers_the_nearest():
    assert "did you mean 'is_energy_group'?" in str(refused(changed("definitions", MASS, "is_energygroup", to=True)))


def table_at() -> int:
    return index_of("Engine")


@pytest.mark.parametrize(
    ("grids", "values", "message"),
    [
        ([[0, 1, 1], [0, 1]], [0] * 6, "strictly growing"),
        ([[0], [0, 1]], [0] * 2, "two or more"),
        ([[0, 1, 2], [0, 1]], [0] * 5, "needs 6 finite values, 5 were given"),
        ([[0, "inf"], [0, 1]], [0] * 4, "expected a finite number"),
        ([[0, 1]], [0, 1], "needs one or two grids, each with a unit"),
    ],
)
def test_table_must_be_one(grids, values, message):
    keys = ("definitions", table_at(), "tables", 0, "values")
    assert message in str(refused(changed(*keys, to={"grids": grids, "values": values})))


@pytest.mark.parametrize(
    ("keys", "value", "message"),
    [
        (("domains", 0, "name"), "magnetic", "the domain 'translation' of port 'flange' is unknown"),
        (("definitions", VEHICLE_AT, "connections", 0, "ports"), ["road", "front.c"], "there is no port 'front.c'"),
        (("definitions", VEHICLE_AT, "connections", 3, "tail"), "body", "there is no port 'body' to connect"),
        (("definitions", VEHICLE_AT, "parts", 4, "name"), "rear", "the name 'rear' is given 2 times"),
        (("definitions", MASS, "behaviour", "stored", 0, 0), "shaft", "the stored quantities: there is no 'shaft'"),
        (("definitions", MASS, "parameters"), [], "mentions the parameter 'mass' (kg), which does not exist"),
        (("definitions", MASS, "behaviour", "coordinates"), [], "one coordinate for each port, this has 0 for 1"),
    ],
)
def test_names_that_do_not_fit_are_refused(keys, value, message):
    assert message in str(refused(changed(*keys, to=value)))


# -- scenarios ------------------------------------------------------------------------------------------------

BUMP = Scenario(
    name="bump",
    start=-1.0,
    stop=10.0,
    inputs={
        parse_path("road.flow"): TableValues(((0.0, 1.0, 3.0),), (0.0, 0.1 + 0.2, 0.0)),
        parse_path("pedal"): 0.25,
    },
    tables={parse_path("engine.pull"): TableValues(((0.0, 1.0), (0.0, 2.0)), (1.0, 2.0, 3.0, 4.0))},
    initial={parse_path("axles[0].spring.displacement"): 1.0 / 3.0},
    parameters={parse_path("body.mass"): 1e-300},
    description="a bump",
)


@pytest.mark.parametrize("scenario", [BUMP, Scenario()])
def test_scenario_comes_back_equal(scenario, tmp_path):
    assert from_scenario_document(through_json(to_scenario_document(scenario))) == scenario
    write_scenario(scenario, tmp_path / "scenario.json")
    assert read_scenario(tmp_path / "scenario.json") == scenario


@pytest.mark.parametrize(
    ("key", "value", "where", "message"),
    [
        ("stop", "soon", "stop", "expected a number, found the text 'soon'"),
        ("stop", "inf", "stop", "expected a finite number"),
        ("inputs", {"a..b": 1.0}, "inputs", "cannot be a name"),
        ("inputs", {"road.flow": "fast"}, "inputs.road.flow", "expected a number"),
        ("tables", {"map": {"grids": [[1, 0]], "values": [1, 2]}}, "tables.map", "strictly growing"),
        ("initial", [1], "initial", "expected an object, found a list"),
        ("gravity", 9.81, "the document", "unknown entry 'gravity'"),
    ],
)
def test_malformed_scenario(key, value, where, message):
    with pytest.raises(DocumentError) as caught:
        from_scenario_document({**to_scenario_document(BUMP), key: value})
    (fault,) = caught.value.diagnostics
    assert fault.where == where
    assert message in fault.message


def test_a_model_is_no_scenario():
    with pytest.raises(DocumentError, match="expected a document of format 'propermodel-scenario'"):
        from_scenario_document(to_document(VEHICLE))


def test_the_vehicle_has_one_of_everything():
    # Guards the tests above.
    kinds = {d.get("behaviour", {}).get("type") for d in to_document(VEHICLE)["definitions"]}
    assert kinds == {"storage", "source", "two_port", "junction", "block", "sampled", "resistance", None}


def test_all_faults_of_a_document_are_told_at_once():
    document = copy.deepcopy(to_document(VEHICLE))
    first = document["definitions"][0]
    first["ports"][0]["domian"] = first["ports"][0].pop("domain")
    first["source"] = "models/rig.py"
    document["domains"][0]["shared"] = "nothing"
    document["root"]["source"] = ["models/rig.py", -1]
    document["removals"] = [{"type": "zero_efort", "bond": "a"}]
    with pytest.raises(DocumentError) as caught:
        from_document(document)
    places = [diagnostic.where for diagnostic in caught.value.diagnostics]
    assert places == [
        "definitions[0].ports[0]",
        "definitions[0].ports[0]",
        "definitions[0].source",
        "root.source[1]",
        "domains[0].shared",
        "removals[0].type",
    ]
    assert caught.value.diagnostics[0].help == "did you mean 'domain'?"


def test_all_faults_of_expressions_are_told_at_once_without_what_follows_from_them():
    document = copy.deepcopy(to_document(VEHICLE))
    count = len(document["expressions"])
    document["expressions"] += [["sinn", 0], ["+", count, 0], ["+", 0], ["constant", "many"]]
    with pytest.raises(DocumentError) as caught:
        from_document(document)
    places = [diagnostic.where for diagnostic in caught.value.diagnostics]
    assert places == [f"expressions[{count}]", f"expressions[{count + 2}]", f"expressions[{count + 3}][1]"]


def test_a_document_full_of_faults_is_told_in_part():
    document = copy.deepcopy(to_document(VEHICLE))
    document["removals"] = [{"type": "zero_efort", "bond": "a"}] * 1000
    with pytest.raises(DocumentError) as caught:
        from_document(document)
    assert len(caught.value.diagnostics) == 20


def test_all_faults_of_a_scenario_are_told_at_once():
    document = {**to_scenario_document(Scenario()), "stop": "late", "inputs": {"a": "x", "b": [1.0]}, "start": None}
    with pytest.raises(DocumentError) as caught:
        from_scenario_document(document)
    places = [diagnostic.where for diagnostic in caught.value.diagnostics]
    assert sorted(places) == ["inputs.a", "inputs.b", "start", "stop"]
