"""Conditions written as text end runs where the same conditions in Python do, and say what is wrong with them."""

from __future__ import annotations

import pytest

from propermodel.compiler import Method
from propermodel.diagnostics import ProperModelError
from propermodel.expressions import absolute, time
from propermodel.library.mechanics.translation import Damper, Fixed, Mass
from propermodel.modelling import Component, Parameter, Scenario, connect, parameter
from propermodel.simulation.conditions import DEEPEST, LONGEST, parse_condition
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import RunStatus
from tests.physics.systems import compiled


class Car(Component):
    """A mass that a damper slows: v = 30 exp(-t) m/s."""

    mass: Parameter = parameter("kg", default=2.0)
    body = Mass(mass=mass, start_velocity=30.0)
    damper = Damper(damping=2.0)
    road = Fixed()
    connections = (connect(body.flange, damper.a), connect(damper.b, road.flange))


CAR = compiled(Car())


@pytest.mark.parametrize(
    ("text", "at"),
    [
        ("body.flange.flow < 10", 1.0986122886681098),
        ("body.flange.flow < 36 km/h", 1.0986122886681098),
        ("10 m/s > body.flange.flow", 1.0986122886681098),
        ("body.flange.flow < 10 m/s and time > 2 s", 2.0),
        ("body.flange.flow < 10 m/s or time >= 500 ms", 0.5),
        ("not (body.flange.flow >= 10 m/s)", 1.0986122886681098),
        ("not not time > .25", 0.25),
        ("abs(-body.flange.flow) * 2.0 - 5 < 10 + 5", 1.0986122886681098),
        ("(body.flange.flow + body.flange.flow) / 2 < 10", 1.0986122886681098),
        ("body.energy < 100 J", 1.0986122886681098),
        ("body.momentum / body.mass < 10 m/s", 1.0986122886681098),
        ("time > 1 s and (time > 3 s or time > 2e0)", 2.0),
    ],
)
def test_a_text_ends_a_run_where_it_says(text: str, at: float):
    run = simulate(CAR, Scenario(stop=9.0), until=text, method=Method.RK4, step=1e-2)
    assert run.ending.status is RunStatus.STOPPED
    assert run.ending.time == pytest.approx(at, abs=1e-8)


def test_a_text_is_the_condition_that_python_writes():
    flow = next(leaf for leaf in CAR.system.values if str(leaf.data.path) == "body.flange.flow")
    wanted = (absolute(flow) < 10.0) & (time > 2.0) | ~(flow > 1.0)
    assert parse_condition(CAR, "abs(body.flange.flow) < 10 and time > 2 or not body.flange.flow > 1") == wanted


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("body.flange.flw < 10", "did you mean 'body.flange.flow'"),
        ("body.flange.flow", "a comparison"),
        ("body.flange.flow <", "a number or a name"),
        ("body.flange.flow < 10)", "ends before"),
        ("(time > 1", "')' was expected"),
        ("time > 1 2", "ends before"),
        ("body.flange.flow < 10 kg", "condition"),
        ("__import__('os').system('true') > 0", "cannot be read"),
        ("time.__class__ > 0", "no observable 'time.__class__'"),
        ("time > 1 parsec", "parsec"),
        ("", "the end"),
        ("(" * (DEEPEST + 2) + "time" + ")" * (DEEPEST + 2) + " > 1", "brackets"),
        ("not " * (DEEPEST + 2) + "time > 1", "brackets"),
        ("time > 1 or " * LONGEST, "characters"),
    ],
)
def test_a_text_that_is_no_condition_is_refused_with_its_place(text: str, says: str):
    with pytest.raises(ProperModelError) as caught:
        parse_condition(CAR, text)
    assert says in str(caught.value)
