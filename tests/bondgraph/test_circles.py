"""Parameters that are defined by each other are found when a model is compiled."""

from __future__ import annotations

import pytest

from propermodel.bondgraph.flatten import flatten
from propermodel.diagnostics import ModelError
from propermodel.modelling import Component, Model, connect, elaborate
from propermodel.modelling.documents import from_document, to_document
from tests.parts import Mass


class Four(Component):
    a = Mass(mass=1.0)
    b = Mass(mass=2.0)
    c = Mass(mass=3.0)
    d = Mass(mass=4.0)
    connections = (connect(a.flange, b.flange, c.flange, d.flange),)


def defined(**by: str) -> Model:
    """Four masses, some of which a document makes sums of others (b="cd": b is c + d)."""
    document = to_document(elaborate(Four()))
    expressions = document["expressions"]
    for part in document["definitions"][-1]["parts"]:
        for index, name in enumerate(by.get(part["name"], "")):
            expressions.append(["symbol", "parameter", f"{name}.mass", "kg"])
            if index:
                expressions.append(["+", part["values"][0][1], len(expressions) - 1])
            part["values"] = [["mass", len(expressions) - 1]]
    return from_document(document)


@pytest.mark.parametrize(
    ("by", "circles"),
    [
        ({"a": "b", "b": "a"}, [["a", "b"]]),
        ({"a": "b", "b": "cd", "d": "b"}, [["b", "d"]]),
        ({"a": "b", "b": "c", "c": "d", "d": "a"}, [["a", "b", "c", "d"]]),
        ({"a": "b", "b": "a", "c": "d", "d": "c"}, [["a", "b"], ["c", "d"]]),
        ({"d": "d"}, [["d"]]),
    ],
)
def test_a_circle_is_refused_with_all_its_members(by, circles):
    with pytest.raises(ModelError) as caught:
        flatten(defined(**by))
    assert {fault.code for fault in caught.value.diagnostics} == {"model/parameter-circle"}
    found = [sorted(item.path.removesuffix(".mass") for item in fault.involved) for fault in caught.value.diagnostics]
    assert sorted(found) == circles


def test_the_members_say_what_they_need():
    with pytest.raises(ModelError, match=r"these parameters are defined by each other: b\.mass, d\.mass") as caught:
        flatten(defined(a="b", b="cd", d="b"))
    (fault,) = caught.value.diagnostics
    assert [(item.path, item.role) for item in fault.involved] == [
        ("b.mass", "needs d.mass"),
        ("d.mass", "needs b.mass"),
    ]
    assert "test_circles.py" in str(fault.source)


def test_a_parameter_that_is_its_own_definition_says_so():
    with pytest.raises(ModelError, match=r"d\.mass is defined by itself"):
        flatten(defined(d="d"))


@pytest.mark.parametrize("by", [{}, {"a": "bc", "b": "c"}, {"a": "bd", "b": "cd", "c": "d"}])
def test_a_shared_definition_is_no_circle(by):
    flatten(defined(**by))


def test_a_long_row_of_definitions_is_followed():
    class Row(Component):
        first = Mass(mass=1.0)
        connections = (connect(first.flange),)

    count = 3000
    document = to_document(elaborate(Row()))
    part = document["definitions"][-1]["parts"][0]
    parts = [{**part, "name": f"m{index}"} for index in range(count)]
    expressions = document["expressions"]
    for index, each in enumerate(parts):
        expressions.append(["symbol", "parameter", f"m{(index + 1) % count}.mass", "kg"])
        each["values"] = [["mass", len(expressions) - 1]]
    document["definitions"][-1] |= {"parts": parts, "connections": []}
    with pytest.raises(ModelError) as caught:
        flatten(from_document(document))
    codes = [fault.code for fault in caught.value.diagnostics]
    assert codes.count("model/parameter-circle") == 1
