"""Hierarchy, wiring, signals and parameters in the flat graph."""

from __future__ import annotations

import math

import pytest

from propermodel.bondgraph.flatten import flatten
from propermodel.compiler import compile_model
from propermodel.diagnostics import ModelError, parse_path
from propermodel.modelling import (
    Component,
    Controller,
    Freeze,
    Input,
    OneJunction,
    Output,
    Parameter,
    Port,
    Scenario,
    Transformer,
    Translation,
    Updates,
    ZeroEffort,
    ZeroJunction,
    bond,
    chain,
    connect,
    elaborate,
    free,
    parameter,
    prescribed_effort,
    prescribed_flow,
    repeat,
)
from propermodel.modelling.model import ElementKind, JunctionKind
from propermodel.simulation.simulate import simulate
from tests.parts import Damper, Fixed, Force, Mass, Spring, SpringDamper
from tests.points import Point, equations_of


def faults_of(component: Component, removals=()):
    with pytest.raises(ModelError) as caught:
        flatten(elaborate(component).without(removals))
    return caught.value.diagnostics


class Hanging(Component):
    spring = Spring(stiffness=1.0)
    mass = Mass(mass=1.0)

    connections = (connect(spring.b, mass.flange),)


def test_unconnected_port_is_reported_where_the_part_stands():
    (fault,) = faults_of(Hanging())
    assert fault.code == "model/unconnected-port"
    assert fault.message == "the translation port 'spring.a' is not connected"
    assert fault.help == "connect it, or end it with a source (a fixed flange, a ground, an ambient)"
    assert str(fault.source).startswith("tests/bondgraph/test_flatten.py:")
    assert [(i.path, i.role) for i in fault.involved] == [("spring", "is a Spring")]


class OpenEnded(Component):
    end = Port(Translation)
    spring = Spring(stiffness=1.0)
    mass = Mass(mass=1.0)

    connections = (connect(spring.b, mass.flange), connect(end, spring.a))


def test_open_port_of_the_root_asks_what_it_means():
    (fault,) = faults_of(OpenEnded())
    assert fault.code == "model/open-port"
    assert fault.message == "the port 'end' of the root open_ended is open"
    assert fault.help == (
        "say how: free(end), prescribed_flow(end) or prescribed_effort(end) in its connections, "
        "or connect it in a larger model"
    )


class FreeEnd(OpenEnded):
    connections = (*OpenEnded.connections, free(OpenEnded.end))


class MovedEnd(OpenEnded):
    connections = (*OpenEnded.connections, prescribed_flow(OpenEnded.end))


class PushedEnd(OpenEnded):
    connections = (*OpenEnded.connections, prescribed_effort(OpenEnded.end))


def test_free_port_carries_no_effort():
    point = Point(equations_of(FreeEnd()), {"mass.momentum": 2.0})
    assert point.rates() == {"mass.momentum": 0.0}
    assert point["spring.port.effort"] == 0.0


def test_prescribed_flow_moves_the_port():
    point = Point(
        equations_of(MovedEnd()), {"mass.momentum": 2.0, "spring.displacement": 0.5}, inputs={"end.flow": 3.0}
    )
    assert point.rates() == {"spring.displacement": pytest.approx(1.0), "mass.momentum": pytest.approx(0.5)}
    assert point["end.flow"] == pytest.approx(3.0)


def test_prescribed_effort_pushes_the_port():
    point = Point(equations_of(PushedEnd()), {"mass.momentum": 2.0}, inputs={"end.effort": 4.0})
    # The effort of a port acts on the component: the mass is pushed with it.
    assert point.rates()["mass.momentum"] == pytest.approx(4.0)
    assert point["end.effort"] == pytest.approx(4.0)


def test_a_prescribed_port_means_nothing_inside_a_larger_model():
    class Larger(Component):
        inner = MovedEnd()
        wall = Fixed()
        connections = (connect(inner.end, wall.flange),)

    graph = flatten(elaborate(Larger()))
    assert not any(t.is_input for t in graph.tables.values())


class Follower(Controller):
    speed = Input("m/s")
    force = Output("N")
    gain: Parameter = parameter("N.s/m", default=2.0)

    def step(self) -> Updates:
        return {self.force: self.gain * self.speed}


class Undriven(Component):
    controller = Follower()
    mass = Mass(mass=1.0)
    push = Force(force=1.0)

    connections = (connect(mass.flange, push.flange),)


def test_undriven_input_is_reported():
    (fault,) = faults_of(Undriven())
    assert fault.code == "model/undriven-signal"
    assert fault.message == "the input 'controller.speed' has no value"
    assert fault.help == "connect a signal to it: connect(part.port.flow, other.input)"


class DrivenTwice(Undriven):
    connections = (
        *Undriven.connections,
        connect(Undriven.mass.flange.flow, Undriven.controller.speed),
        connect(Undriven.push.flange.flow, Undriven.controller.speed),
    )


def test_input_driven_twice_is_reported():
    (fault,) = faults_of(DrivenTwice())
    assert fault.code == "model/signal-driven-twice"
    assert fault.message == "'controller.speed' is driven twice"


class Driven(Undriven):
    connections = (*Undriven.connections, connect(Undriven.mass.flange.flow, Undriven.controller.speed))


def test_frozen_signal_keeps_its_value():
    graph = flatten(elaborate(Driven()).without([Freeze(parse_path("controller.speed"), 7.0)]))
    values = {str(leaf.data.path): value for leaf, value in graph.signals.items()}
    assert values["controller.speed"].data == (7.0, "")


def test_removal_of_something_unknown_is_reported():
    model = elaborate(Driven())
    with pytest.raises(Exception, match=r"'mass\.flang'") as caught:
        flatten(model.without([ZeroEffort(parse_path("mass.flang"))]))
    assert caught.value.diagnostics[0].code == "reduction/unknown-removal"
    with pytest.raises(Exception, match=r"controller\.spee"):
        flatten(model.without([Freeze(parse_path("controller.spee"), 0.0)]))


# -- names and wiring -----------------------------------------------------------------------------------


class Section(Component):
    left = Port(Translation)
    right = Port(Translation)
    mass: Parameter = parameter("kg", default=2.0)

    body = Mass(mass=mass)
    strut = SpringDamper(stiffness=5.0, damping=1.0)

    connections = (connect(left, body.flange, strut.a), connect(strut.b, right))


class Train(Component):
    cars = repeat(3, Section(mass=4.0))
    wall = Fixed()
    push = Force(force=1.0)

    connections = (
        connect(push.flange, cars[0].left),
        chain(cars, "right", "left"),
        connect(cars[2].right, wall.flange),
    )


def test_elements_have_the_path_of_their_part():
    graph = flatten(elaborate(Train()))
    assert {str(p) for p, e in graph.original.elements.items() if e.kind is ElementKind.INERTIA} == {
        f"cars[{i}].body" for i in range(3)
    }
    assert graph.parameters[parse_path("cars[1].body.mass")].value.data.path == parse_path("cars[1].mass")
    assert graph.parameters[parse_path("cars[1].mass")].value.data == (4.0, "")


def test_node_is_named_after_the_port_nearest_the_root():
    graph = flatten(elaborate(Train()))
    node = graph.node_ports[parse_path("cars[1].left")]
    assert node.junction == parse_path("cars[0].right")
    assert graph.original.junctions[node.junction].kind is JunctionKind.ONE


def test_flow_into_a_composite_port_is_what_its_inside_takes():
    system = equations_of(Train())
    states = {str(s.path): 0.1 * (n + 1) for n, s in enumerate(system.states)}
    point = Point(system, states)
    for i in range(3):
        left, right = (point[f"cars[{i}].{side}.power"] for side in ("left", "right"))
        inside = sum(
            point[f"cars[{i}].{leaf}.power"] for leaf in ("body.flange", "strut.spring.port", "strut.damper.port")
        )
        assert left + right == pytest.approx(inside)


def test_a_port_named_in_two_connections_is_one_node():
    class Twice(Component):
        mass = Mass(mass=1.0)
        damper = Damper(damping=1.0)
        push = Force(force=1.0)
        wall = Fixed()
        connections = (
            connect(mass.flange, damper.a),
            connect(mass.flange, push.flange),
            connect(damper.b, wall.flange),
        )

    graph = flatten(elaborate(Twice()))
    assert len([j for j in graph.original.junctions.values() if j.kind is JunctionKind.ONE]) == 2


class Written(Component):
    """The quarter car's tyre in bond graph words: force on a mass, spring to the ground."""

    mass = Mass(mass=2.0)
    push = Force(force=3.0)
    strut = Spring(stiffness=5.0)
    wall = Fixed()
    motion = OneJunction()

    connections = (
        bond(motion, mass.flange),
        bond(motion, push.flange),
        bond(motion, strut.a),
        connect(strut.b, wall.flange),
    )


class Drawn(Component):
    mass = Mass(mass=2.0)
    push = Force(force=3.0)
    strut = Spring(stiffness=5.0)
    wall = Fixed()

    connections = (connect(mass.flange, push.flange, strut.a), connect(strut.b, wall.flange))


def test_bonds_and_connections_say_the_same():
    states = {"mass.momentum": 1.0, "strut.displacement": 0.2}
    assert Point(equations_of(Written()), states).rates() == Point(equations_of(Drawn()), states).rates()


def test_half_arrow_gives_the_sense_of_a_bond():
    class Turned(Written):
        connections = (
            *Written.connections[:1],
            bond(Written.push.flange, Written.motion),
            *Written.connections[2:],
        )

    states = {"mass.momentum": 1.0, "strut.displacement": 0.0}
    assert Point(equations_of(Turned()), states).rates()["mass.momentum"] == pytest.approx(3.0)
    assert Point(equations_of(Written()), states).rates()["mass.momentum"] == pytest.approx(-3.0)


def test_zero_junction_written_out():
    class Between(Component):
        left = Mass(mass=1.0)
        right = Mass(mass=1.0)
        common = ZeroJunction()
        spring = Spring(stiffness=4.0)
        wall = Fixed()
        connections = (
            bond(common, left.flange),
            bond(common, right.flange),
            bond(spring.a, common),
            connect(spring.b, wall.flange),
        )

    graph = flatten(elaborate(Between()))
    assert JunctionKind.ZERO in {j.kind for j in graph.normal.junctions.values()}


class LongTrain(Component):
    cars = repeat(700, Section(mass=4.0))
    wall = Fixed()
    push = Force(force=1.0)

    connections = (
        connect(push.flange, cars[0].left),
        chain(cars, "right", "left"),
        connect(cars[699].right, wall.flange),
    )


def test_a_chain_of_two_thousand_elements_meets_no_recursion_limit():
    model = elaborate(LongTrain())
    graph = flatten(model)
    assert len(graph.normal.elements) == 3 * 700 + 1
    assert "cars[699].strut.spring" in str(graph)
    assert model == elaborate(LongTrain())
    assert hash(model.root) == hash(elaborate(LongTrain()).root)
    assert repr(model)


class Isolator(Transformer):
    """A transformer whose two ports are each between two flanges."""

    a_left = Port(Translation)
    a_right = Port(Translation)
    b_left = Port(Translation)
    b_right = Port(Translation)
    a = Port(Translation, between=(a_left, a_right))
    b = Port(Translation, between=(b_left, b_right))

    def modulus(self) -> float:
        return 2.0


class Isolated(Component):
    pushed = Mass(mass=1.0)
    isolator = Isolator()
    spring = Spring(stiffness=8.0)
    wall = Fixed()

    connections = (
        connect(pushed.flange, isolator.a_left),
        connect(isolator.a_right, isolator.b_right, spring.b, wall.flange),
        connect(isolator.b_left, spring.a),
    )


def test_each_difference_of_a_two_port_has_its_own_junction():
    graph = flatten(elaborate(Isolated()))
    ends = {end.owner for bond in graph.normal.bonds.values() for end in (bond.tail, bond.head)}
    assert {parse_path(name) for name in ("pushed", "isolator", "spring")} <= ends
    run = simulate(
        compile_model(elaborate(Isolated())), Scenario(stop=1.0, initial={"pushed.momentum": 1.0}), step=1e-4
    )
    # v_b = 2 v_a: the spring looks 2^2 times as stiff.
    assert run.at_end("pushed.flange.flow") == pytest.approx(math.cos(math.sqrt(32.0)), abs=1e-3)
