"""Documents that are made to cost time or memory: refused at once, or read in time proportional to their size."""

from __future__ import annotations

import re
import time
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

import propermodel as pm
from propermodel.diagnostics import DocumentError, parse_path
from propermodel.modelling.documents import from_document, from_scenario_document, read_scenario, to_document
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import LIMITS, Limits
from tests.faults.case import ROOT
from tests.parts import Fixed, Mass, SpringDamper


class Rig(pm.Component):
    mass = Mass(mass=1.0)
    spring = SpringDamper(stiffness=1.0, damping=1.0)
    wall = Fixed()
    connections = (pm.connect(mass.flange, spring.a), pm.connect(spring.b, wall.flange))


@contextmanager
def within(seconds: float, mega_bytes: float = 0.0) -> Iterator[None]:
    """What happens inside takes at most this much CPU time, and memory where that is asked for (which takes time)."""
    if mega_bytes:
        tracemalloc.start()
    started = time.process_time()
    try:
        yield
        used = time.process_time() - started
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert used < seconds
    assert peak <= mega_bytes * 2**20


def document() -> dict[str, Any]:
    return to_document(pm.elaborate(Rig()))


def shell(type_name: str, **entries: Any) -> dict[str, Any]:
    return {"type_name": type_name, "doc": "", **entries}


def refused(given: Any, read: Any = from_document, limits: Limits = LIMITS) -> str:
    with pytest.raises(DocumentError) as caught:
        read(given, limits=limits)
    return str(caught.value)


def test_parts_that_double_at_every_level():
    given = document()
    first = len(given["definitions"])
    for level in range(40):
        below = first + level - 1 if level else 0
        parts = [{"name": name, "definition": below} for name in ("left", "right")]
        given["definitions"].append(shell(f"Twice{level}", parts=parts))
    given["root"]["definition"] = first + 39
    with within(1.0, 4.0):
        told = refused(given)
    assert f"parts in all; at most {LIMITS.parts} are read" in told
    assert told.startswith("error[document/limit]: has ")
    assert "limits=pm.Limits(parts=...)" in told


def test_shells_within_shells():
    given = document()
    first = len(given["definitions"])
    for level in range(6_000):
        below = first + level - 1 if level else 0
        given["definitions"].append(shell("Shell", parts=[{"name": "inner", "definition": below}]))
    with within(10.0):
        assert f"names in all; at most {LIMITS.path_names} are read" in refused(given)


def test_many_parts_with_many_parameters():
    given = document()
    first = len(given["definitions"])
    parameters = [{"name": f"p{n}", "unit": "", "default": 0} for n in range(5000)]
    given["definitions"].append(shell("Wide", parameters=parameters))
    given["definitions"].append(shell("All", parts=[{"name": f"w{n}", "definition": first} for n in range(5000)]))
    with within(5.0):
        assert f"names in all; at most {LIMITS.path_names} are read" in refused(given)


def test_expressions_that_are_shared_exponentially_are_nothing_special():
    given = document()
    spring = next(d for d in given["definitions"] if d["type_name"] == "Spring")
    nodes = given["expressions"]
    given_law = spring["behaviour"]["outputs"][0][1]
    law = given_law
    for _ in range(300):  # written out it has 2^300 terms
        nodes.append(["+", law, law])
        nodes.append(["constant", 0.5])
        nodes.append(["*", len(nodes) - 2, len(nodes) - 1])
        law = len(nodes) - 1
    spring["behaviour"]["outputs"][0][1] = law
    with within(10.0):
        model = from_document(given)
        compiled = pm.compile_model(model)
        assert "mass" in str(compiled.system)
        assert len(str(pm.state_equations(compiled))) < 10**6
        assert from_document(to_document(model)) == model


def test_a_chain_of_expressions_that_every_parameter_uses():
    # Each parameter mentions all before it: 8 million mentions in a file of 300 kB.
    given = document()
    nodes = given["expressions"]
    count = 4000
    parameters = [{"name": "p0", "unit": ""}]
    nodes.append(["symbol", "parameter", "p0", ""])
    chain = len(nodes) - 1
    for n in range(1, count):
        nodes.append(["symbol", "parameter", f"p{n}", ""])
        parameters.append({"name": f"p{n}", "unit": "", "default": chain})
        nodes.append(["+", chain, len(nodes) - 1])
        chain = len(nodes) - 1
    given["definitions"].append(shell("Chain", parameters=parameters))
    given["root"] = {"name": "chain", "definition": len(given["definitions"]) - 1, "values": [["p0", 0]]}
    with within(5.0, 20.0):
        assert from_document(given).name == "rig"


def test_definitions_that_all_use_one_great_expression():
    given = document()
    nodes = given["expressions"]
    nodes.append(["symbol", "parameter", "p", ""])
    great = len(nodes) - 1
    for _ in range(1000):
        nodes.append(["sin", great])
        great = len(nodes) - 1
    first = len(given["definitions"])
    parameters = [{"name": "p", "unit": "", "default": 0}, {"name": "q", "unit": "", "default": great}]
    given["definitions"].extend(shell("User", parameters=parameters) for _ in range(200))
    given["definitions"].append(shell("All", parts=[{"name": f"u{n}", "definition": first + n} for n in range(200)]))
    given["root"]["definition"] = len(given["definitions"]) - 1
    with within(5.0):
        told = refused(given, limits=Limits(expression_uses=100_000))
    assert "the definitions use more than 100000 expressions" in told
    assert "--> User" in told


def test_a_part_that_many_connections_name():
    given = document()
    first = len(given["definitions"])
    ports = [{"name": f"p{n}", "domain": "translation"} for n in range(8000)]
    given["definitions"].append(shell("Wide", ports=ports))
    connections = [{"type": "node", "ports": [f"w.p{n}"]} for n in range(8000)]
    given["definitions"].append(shell("All", parts=[{"name": "w", "definition": first}], connections=connections))
    given["root"] = {"name": "all", "definition": first + 1}
    with within(10.0):
        assert from_document(given).root.name == "all"


def test_many_faults_are_told_in_part():
    given = document()
    ports = [{"name": f"port_number_{n:06}", "domain": "translatoin"} for n in range(20_000)]
    given["definitions"][0]["ports"] = ports
    with within(5.0):
        assert refused(given).count("error[") == 20


def test_names_that_resemble_each_other_are_not_compared_for_hours():
    given = document()
    known = [{"name": "ab" * 450 + f"{n:05}", "unit": "", "default": 0} for n in range(5000)]
    values = [["ba" * 450 + f"{n:05}", 0] for n in range(5000)]
    first = len(given["definitions"])
    given["definitions"].append(shell("Named", parameters=known))
    given["definitions"].append(shell("All", parts=[{"name": "n", "definition": first, "values": values}]))
    given["root"] = {"name": "all", "definition": first + 1}
    with within(10.0):
        assert "there is no 'baba" in refused(given)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (Limits(expressions=10), "expressions; at most 10 are read"),
        (Limits(units=3), "there are more than 3 different units"),
        (Limits(text_characters=5), "characters; at most 5 are read"),
        (Limits(name_characters=3), "characters; at most 3 are read"),
        (Limits(parts=3), "parts in all; at most 3 are read"),
        (Limits(path_names=3), "names in all; at most 3 are read"),
        (Limits(expression_uses=3), "the definitions use more than 3 expressions"),
    ],
)
def test_every_limit_is_kept(limits: Limits, message: str):
    told = refused(document(), limits=limits)
    assert told.startswith("error[document/limit]: ")
    assert message in told
    assert "  --> " in told


def test_the_amount_of_values_is_known_before_they_are_made():
    data = b"[" + b"{}," * 2_000_000 + b"{}]"
    with within(2.0, 10.0):
        assert "the document has up to 4000003 values" in refused(data, parse_json)
    names = b'["' + b"a." * 8_000_002 + b'"]'
    with within(2.0, 40.0):
        assert "values; at most 4000000 are read" in refused(names, parse_json)
    quotes = b'"' * 17_000_000
    with within(2.0, 40.0):
        assert "values; at most 4000000 are read" in refused(quotes, parse_json)


@pytest.mark.parametrize(
    "unit", ["m" * 65, "9**9**9", "((((((((((m", "m99999999", "km9999999", "1/0", "__import__", "m\n"]
)
def test_strange_units_are_refused_at_once(unit: str):
    given = document()
    given["definitions"][0]["parameters"][0]["unit"] = unit
    with within(2.0):
        assert refused(given).startswith("error[")


@pytest.mark.parametrize("name", ["", "a.b", "\x1b[2J", "a\nb", "\ud800", "\u202eevil"])
def test_names_that_cannot_be_shown_are_refused(name: str):
    given = document()
    given["root"]["name"] = name
    told = refused(given)
    assert "cannot be a name" in told or "has control characters" in told
    assert told.isprintable() or set(told) - {c for c in told if c.isprintable()} == {"\n"}


def test_texts_that_control_screens_are_refused():
    given = document()
    given["definitions"][0]["doc"] = "\x1b]0;owned\x07"
    assert r"the text '\x1b]0;owned\x07' has control characters" in refused(given)


def test_large_tables_are_read(tmp_path: Path):
    # A road of 460 000 points, as the scenarios of trucks have.
    count = 460_000
    times = tuple(n * 1e-3 + 1e-7 for n in range(count))
    road = pm.TableValues((times,), tuple((-1) ** n * 1.1e-3 / (n + 3) for n in range(count)))
    scenario = pm.Scenario(name="road", stop=460.0, inputs={parse_path("road.flow"): road})
    pm.write_scenario(scenario, tmp_path / "road.json")
    assert (tmp_path / "road.json").stat().st_size > 1.6e7
    assert read_scenario(tmp_path / "road.json") == scenario


def test_tables_beyond_the_limit_are_refused():
    table = {"grids": [[0.0, 1.0, 2.0]], "values": [0.0, 1.0, 2.0]}
    given = {"format": "propermodel-scenario", "version": 1, "inputs": {"road.flow": table}}
    told = refused(given, from_scenario_document, Limits(table_points=2))
    assert "a table has 3 numbers; at most 2 are read" in told
    assert "--> inputs.road.flow.grids[0]" in told
    given["inputs"]["road.flow"]["grids"] = [[0.0, 1.0]] * 20_000
    with within(3.0):
        assert "a table has one or two grids, 20000 were given" in refused(given, from_scenario_document)


def test_the_limits_are_in_the_documentation():
    text = (ROOT / "docs" / "howto" / "documents.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([\d ]+) \|", text, re.MULTILINE)
    assert {name: int(number.replace(" ", "")) for name, number in rows} == asdict(LIMITS)
