"""Parameters at the start: each from those that it is defined by."""

import pytest

import propermodel as pm
from propermodel.diagnostics import SimulationError, parse_path
from propermodel.modelling import Component, Model, Scenario, connect, elaborate
from propermodel.modelling.documents import from_document, to_document
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import parameter_values
from tests.parts import Mass


class Pair(Component):
    a = Mass(mass=1.0)
    b = Mass(mass=a.mass)
    connections = (connect(a.flange, b.flange),)


def circle() -> Model:
    """Two masses that a document gives each other's mass."""
    document = to_document(elaborate(Pair()))
    document["expressions"].append(["symbol", "parameter", "b.mass", "kg"])
    document["definitions"][-1]["parts"][0]["values"] = [["mass", len(document["expressions"]) - 1]]
    return from_document(document)


def test_parameters_in_a_circle_are_refused():
    compiled = pm.compile_model(circle())
    with pytest.raises(
        SimulationError, match=r"these parameters are defined by each other: (a\.mass, b\.mass|b\.mass, a\.mass)\n"
    ) as caught:
        simulate(compiled, Scenario(stop=0.1))
    assert caught.value.diagnostics[0].code == "simulation/parameter-circle"


def test_a_number_opens_the_circle():
    compiled = pm.compile_model(circle())
    values = parameter_values(compiled, {parse_path("a.mass"): 7.0})
    assert {str(leaf.data.path): value for leaf, value in values.items()} == {"a.mass": 7.0, "b.mass": 7.0}


class Three(Component):
    a = Mass(mass=1.0)
    b = Mass(mass=1.0)
    c = Mass(mass=3.0)
    connections = (connect(a.flange, b.flange, c.flange),)


def test_parameters_that_share_a_definition_are_no_circle():
    # a = c + b and b = c, so that both wait for c.
    document = to_document(elaborate(Three()))
    expressions, (a, b, _) = document["expressions"], document["definitions"][-1]["parts"]
    at = len(expressions)
    expressions += [
        ["symbol", "parameter", "b.mass", "kg"],
        ["symbol", "parameter", "c.mass", "kg"],
        ["+", at + 1, at],
    ]
    a["values"], b["values"] = [["mass", at + 2]], [["mass", at + 1]]
    values = parameter_values(pm.compile_model(from_document(document)), {})
    assert {str(leaf.data.path): v for leaf, v in values.items()} == {"a.mass": 6.0, "b.mass": 3.0, "c.mass": 3.0}
