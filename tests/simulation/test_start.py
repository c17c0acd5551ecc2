"""What a run starts with: parameters, each from those that it is defined by, and finite numbers everywhere."""

import math
from dataclasses import replace

import pytest

import propermodel as pm
from examples.quarter_car import QuarterCar
from examples.quarter_car import scenario as waves
from propermodel.diagnostics import ModelError, SimulationError
from propermodel.expressions import Expr
from propermodel.modelling import (
    Component,
    EffortSource,
    Input,
    Parameter,
    Port,
    Scenario,
    TableValues,
    Translation,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.documents import from_document, to_document
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import parameter_values
from tests.parts import Mass


class Told(EffortSource):
    """Pushes with the force that it is told."""

    flange = Port(Translation)
    force = Input("N")

    def effort(self) -> Expr:
        return -self.force


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


class Ratio(Component):
    over: Parameter = parameter("kg", default=2.0)
    under: Parameter = parameter("1", default=1.0)
    a = Mass(mass=over / under)
    connections = (connect(a.flange),)


NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"parameters": {"under": 0.0}}, "the parameter 'a.mass' is inf at the start"),
        ({"parameters": {"under": 0.0, "over": 0.0}}, "the parameter 'a.mass' is nan at the start"),
        ({"initial": {"a.momentum": NAN}}, "scenario 'scenario' gives 'a.momentum' the start nan"),
        ({"initial": {"a.flange.flow": -INF}}, "scenario 'scenario' gives 'a.flange.flow' the start -inf"),
    ],
)
@pytest.mark.parametrize("backend", list(pm.Backend))
def test_a_run_does_not_start_with_what_is_no_finite_number(given, told, backend):
    compiled = pm.compile_model(elaborate(Ratio()), backend=backend)
    with pytest.raises(SimulationError, match="simulation/not-finite") as caught:
        simulate(compiled, Scenario(**given))
    assert told in [fault.message.removesuffix(", which is no finite number") for fault in caught.value.diagnostics]


class Pushed(Component):
    mass = Mass(mass=1.0)
    push = Told()
    force = Input("N")
    connections = (connect(mass.flange, push.flange), connect(force, push.force))


@pytest.mark.parametrize(
    "force", [NAN, INF, TableValues(((0.0, 1.0),), (0.0, NAN)), TableValues(((0.0, INF),), (0.0, 1.0))]
)
def test_inputs_are_finite(force):
    with pytest.raises(
        SimulationError, match=r"scenario 'scenario' gives 'force' the value (nan|inf), which is no finite"
    ):
        simulate(pm.compile_model(elaborate(Pushed())), Scenario(inputs={"force": force}))


@pytest.mark.parametrize("value", [NAN, INF, -INF])
def test_a_parameter_that_is_not_finite_is_refused_where_it_is_written(value):
    class Wrong(Component):
        body = Mass(mass=value)
        connections = (connect(body.flange),)

    with pytest.raises(ModelError, match=rf"body: 'mass' = {value:g} is no finite number") as caught:
        elaborate(Wrong())
    assert "test_start.py" in str(caught.value)


@pytest.mark.parametrize("window", [(0.0, INF), (-INF, 1.0), (NAN, 1.0), (1.0, 1.0)])
def test_the_window_of_a_run_is_finite(window):
    with pytest.raises(SimulationError, match="simulation/window"):
        simulate(pm.compile_model(elaborate(Ratio())), Scenario(start=window[0], stop=window[1]))


@pytest.mark.parametrize("period", [0.0, -1.0, NAN])
@pytest.mark.parametrize("name", ["record_every", "integrals_every"])
def test_periods_of_recording_are_positive(name, period):
    with pytest.raises(SimulationError, match="simulation/period"):
        simulate(pm.compile_model(elaborate(Ratio())), Scenario(), **{name: period})


def test_a_reduced_model_runs_the_scenarios_of_the_full_one():
    model = pm.elaborate(QuarterCar())
    given = replace(waves(), initial={pm.Path(("tyre", "spring", "displacement")): 0.01})
    reduced = pm.compile_model(model.without([pm.ZeroFlow(pm.Path(("tyre", "spring", "port")))]))
    assert pm.simulate(reduced, given, step=1e-3).ending.is_complete
    misspelt = replace(given, initial={pm.Path(("tire", "spring", "displacement")): 0.01})
    with pytest.raises(pm.ProperModelError, match="which is no state of this model"):
        pm.simulate(reduced, misspelt, step=1e-3)
