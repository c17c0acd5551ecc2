"""Strokes: what each element can take, which storage depends on which, and how a contradiction is told."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings

from propermodel.bondgraph.flatten import flatten
from propermodel.causality.assign import assign_causality
from propermodel.causality.causal import CausalGraph, Why
from propermodel.causality.report import explain_causality
from propermodel.diagnostics import ModelError, Path, StructureError
from propermodel.expressions import Expr
from propermodel.modelling import (
    Component,
    Parameter,
    Port,
    Preference,
    Resistance,
    Rotation,
    Translation,
    connect,
    elaborate,
    parameter,
    replace,
)
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.parts import (
    Capacitor,
    Coil,
    Damper,
    Fixed,
    Force,
    Ground,
    Lever,
    Mass,
    Motor,
    Resistor,
    Spring,
    Velocity,
    Voltage,
)
from tests.rigs import rigs


def strokes_of(component: Component) -> CausalGraph:
    return assign_causality(flatten(elaborate(component)))


def receives_effort(causal: CausalGraph, port: str) -> bool:
    path = Path(port.split("."))
    return causal.strokes[path].effort_into == path.parent


def fault_of(component: Component):
    with pytest.raises(StructureError) as caught:
        strokes_of(component)
    (fault,) = caught.value.diagnostics
    return fault


# -- every element alone ----------------------------------------------------------------------------------


def pair(first: Component, second: Component, more: tuple[Component, ...] = ()) -> Component:
    """Two or more elements that move together, one-ports or held by a wall at b."""
    parts = {"first": first, "second": second, **{f"more{i}": part for i, part in enumerate(more)}}
    joined = [part.flange if hasattr(type(part), "flange") else part.a for part in parts.values()]
    held = [part.b for part in parts.values() if hasattr(type(part), "b")]
    wiring = [connect(*joined)]
    if held:
        parts["wall"] = Fixed()
        wiring.append(connect(parts["wall"].flange, *held))
    return type("Pair", (Component,), {**parts, "connections": tuple(wiring)})()


@pytest.mark.parametrize(
    ("element", "port", "partner", "receives"),
    [
        (Force(force=1.0), "first.flange", Mass(mass=1.0), False),
        (Velocity(velocity=1.0), "first.flange", Damper(damping=1.0), True),
        (Mass(mass=1.0), "first.flange", Force(force=1.0), True),
        (Spring(stiffness=1.0), "first.port", Mass(mass=1.0), False),
        (Damper(damping=1.0), "first.port", Mass(mass=1.0), False),
        (Damper(damping=1.0), "first.port", Force(force=1.0), True),
        (Mass(mass=1.0), "first.flange", Velocity(velocity=1.0), False),  # derivative
    ],
)
def test_stroke_of_an_element(element, port, partner, receives):
    assert receives_effort(strokes_of(pair(element, partner)), port) is receives


def test_storage_is_a_state_where_nothing_forbids_it():
    causal = strokes_of(pair(Mass(mass=1.0), Spring(stiffness=1.0), (Damper(damping=1.0),)))
    assert set(causal.integral) == {Path(("first",)), Path(("second",))}
    assert causal.derivative == ()


def test_mass_on_a_flow_source_is_dependent():
    causal = strokes_of(pair(Mass(mass=1.0), Velocity(velocity=1.0)))
    assert causal.derivative == (Path(("first",)),)
    assert causal.strokes[Path(("first", "flange"))].cause == Path(("second",))


def test_transformer_passes_causality_on():
    class Levered(Component):
        mass = Mass(mass=1.0)
        lever = Lever(ratio=2.0)
        damper = Damper(damping=1.0)
        wall = Fixed()
        connections = (
            connect(mass.flange, lever.a),
            connect(lever.b, damper.a),
            connect(damper.b, wall.flange),
        )

    causal = strokes_of(Levered())
    assert receives_effort(causal, "lever.b")
    assert not receives_effort(causal, "lever.a")
    assert causal.strokes[Path(("lever", "b"))].why in (Why.TWO_PORT, Why.JUNCTION)


def test_gyrator_turns_causality_round():
    class Loaded(Component):
        source = Voltage(voltage=1.0)
        motor = Motor(constant=0.1)
        ground = Ground()
        load = Drag(friction=1.0)
        connections = (connect(source.a, motor.a), connect(source.b, ground.pin), connect(motor.b, load.shaft))

    causal = strokes_of(Loaded())
    # A voltage in, a speed demanded: the gyrator receives an effort at both ends.
    assert receives_effort(causal, "motor.a")
    assert receives_effort(causal, "motor.b")
    assert not receives_effort(causal, "load.shaft")


class Drag(Resistance):
    shaft = Port(Rotation)
    friction: Parameter = parameter("N.m.s/rad")

    def effort(self, flow: Expr) -> Expr:
        return self.friction * flow


# -- dependent storage --------------------------------------------------------------------------------------


class Geared(Component):
    first = Mass(mass=1.0)
    lever = Lever(ratio=2.0)
    second = Mass(mass=3.0)
    push = Force(force=1.0)

    connections = (connect(first.flange, lever.a, push.flange), connect(lever.b, second.flange))


def test_mass_behind_a_lever_is_dependent():
    causal = strokes_of(Geared())
    assert causal.integral == (Path(("first",)),)
    assert causal.derivative == (Path(("second",)),)
    assert "dependent storage: second" in str(causal)


class CapacitorsInParallel(Component):
    left = Capacitor(capacitance=1.0)
    right = Capacitor(capacitance=2.0)
    resistor = Resistor(resistance=1.0)
    ground = Ground()

    connections = (connect(left.a, right.a, resistor.a), connect(left.b, right.b, resistor.b, ground.pin))


def test_second_capacitor_in_parallel_is_dependent():
    causal = strokes_of(CapacitorsInParallel())
    assert (len(causal.integral), len(causal.derivative)) == (1, 1)


class CoilsInSeries(Component):
    source = Voltage(voltage=1.0)
    left = Coil(inductance=1.0)
    right = Coil(inductance=2.0)
    ground = Ground()

    connections = (
        connect(source.a, left.a),
        connect(left.b, right.a),
        connect(right.b, source.b, ground.pin),
    )


def test_second_coil_in_series_is_dependent():
    causal = strokes_of(CoilsInSeries())
    assert (len(causal.integral), len(causal.derivative)) == (1, 1)


def test_resistance_loop_is_decided_by_choice():
    class Divider(Component):
        source = Voltage(voltage=1.0)
        upper = Resistor(resistance=1.0)
        lower = Resistor(resistance=2.0)
        ground = Ground()
        connections = (
            connect(source.a, upper.a),
            connect(upper.b, lower.a),
            connect(lower.b, source.b, ground.pin),
        )

    causal = strokes_of(Divider())
    assert Why.CHOICE in {stroke.why for stroke in causal.strokes.values()}
    # In series one takes the current from the other.
    assert receives_effort(causal, "upper.port") is not receives_effort(causal, "lower.port")


# -- contradictions -----------------------------------------------------------------------------------------


class Rig(Component):
    road = Velocity(velocity=1.0)
    shaker = Velocity(velocity=2.0)
    wheel = Mass(mass=40.0)

    connections = (connect(wheel.flange, road.flange, shaker.flange),)


def test_two_flow_sources_on_one_junction():
    with pytest.raises(StructureError) as caught:
        strokes_of(Rig())
    assert re.sub(r":\d+", ":LINE", str(caught.value)) == (
        "error[causality/conflict]: two flow sources set the velocity of one junction\n"
        "  --> tests/causality/test_assign.py:LINE  road.flange (1-junction)\n"
        "      road    prescribes its velocity   tests/causality/test_assign.py:LINE\n"
        "      shaker  prescribes its velocity   tests/causality/test_assign.py:LINE\n"
        "  help: put a compliance between them, or make one of them an effort source"
    )


class TwoBatteries(Component):
    first = Voltage(voltage=12.0)
    second = Voltage(voltage=6.0)
    ground = Ground()

    connections = (connect(first.a, second.a), connect(first.b, second.b, ground.pin))


def test_two_effort_sources_on_one_junction():
    fault = fault_of(TwoBatteries())
    assert fault.code == "causality/conflict"
    assert fault.message == "two effort sources set the voltage of one junction"
    assert {i.path for i in fault.involved} == {"first", "second"}
    assert {i.role for i in fault.involved} == {"prescribes its voltage"}
    assert fault.help == "put a resistance or inertia between them, or make one of them a flow source"


class SourcesThroughALever(Component):
    left = Velocity(velocity=1.0)
    lever = Lever(ratio=2.0)
    right = Velocity(velocity=1.0)

    connections = (connect(left.flange, lever.a), connect(lever.b, right.flange))


def test_two_flow_sources_through_a_lever():
    fault = fault_of(SourcesThroughALever())
    assert {i.path for i in fault.involved} >= {"left", "right"}


class ForcesOnly(Component):
    left = Force(force=1.0)
    right = Force(force=2.0)

    connections = (connect(left.flange, right.flange),)


def test_forces_with_nothing_to_move():
    fault = fault_of(ForcesOnly())
    assert fault.message == "nothing sets the velocity of one junction: every bond prescribes its other variable"
    assert fault.help == "connect an inertia, or a resistance, whose law gives the velocity"
    assert [i.path for i in fault.involved] == ["left", "right"]


class OnlyEffort(Resistance):
    """Turbulent drag that offers its force for a velocity, not the other way round."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    drag: Parameter = parameter("N.s2/m2")

    def effort(self, flow: Expr) -> Expr:
        return self.drag * flow * abs(flow)


class ForcedDrag(Component):
    push = Force(force=1.0)
    drag = OnlyEffort(drag=1.0)
    wall = Fixed()

    connections = (connect(push.flange, drag.a), connect(drag.b, wall.flange))


def test_law_that_is_not_offered_is_named():
    fault = fault_of(ForcedDrag())
    assert fault.message == "nothing sets the velocity of one junction: every bond prescribes its other variable"
    assert [(i.path, i.role) for i in fault.involved] == [
        ("push", "prescribes its force"),
        ("drag", "offers a law for port.effort only"),
    ]
    assert fault.help == "connect an inertia, or a resistance, whose law gives the velocity"
    assert all(str(i.source).startswith("tests/causality/test_assign.py:") for i in fault.involved)


# -- any rig --------------------------------------------------------------------------------------------------


@given(rigs())
@settings(max_examples=60)
def test_strokes_of_any_rig_are_consistent(rig):
    causal = strokes_of(rig.component())
    normal = causal.graph.normal
    at = normal.at()
    assert set(causal.strokes) == set(normal.bonds)
    for path, junction in normal.junctions.items():
        into = [b for b in at[path] if causal.strokes[b.name].effort_into == path]
        # One effort comes into a 0-junction; all but one into a 1-junction.
        assert len(into) == (1 if junction.kind is JunctionKind.ZERO else len(at[path]) - 1)
    for element in normal.elements.values():
        receives = [causal.receives_effort(b, element) for b in at[element.path]]
        match element.kind:
            case ElementKind.EFFORT_SOURCE:
                assert receives == [False]
            case ElementKind.FLOW_SOURCE:
                assert receives == [True]
            case ElementKind.TRANSFORMER:
                assert sorted(receives) == [False, True]
            case ElementKind.INERTIA:
                assert receives == [element.path in causal.integral]
            case ElementKind.COMPLIANCE:
                assert receives == [element.path in causal.derivative]
    # As many states as the rig has independent motions and stretches.
    levers = sum(e.kind == "lever" for e in rig.edges)
    springs = sum(e.kind == "spring" for e in rig.edges)
    masses = [p for p in causal.integral if normal.elements[p].kind is ElementKind.INERTIA]
    assert len(masses) == len(rig.masses) - levers
    assert len(causal.integral) - len(masses) == springs


# -- what authors prefer ------------------------------------------------------------------------------------


class Follower(Mass):
    preference = Preference.DERIVATIVE


class Leader(Mass):
    preference = Preference.INTEGRAL


class Rigid(Component):
    """Two masses on one flange; the first is the state unless an author says otherwise."""

    first = Mass(mass=1.0)
    second = Mass(mass=2.0)

    connections = (connect(first.flange, second.flange),)


def test_without_a_preference_the_first_storage_is_the_state():
    assert strokes_of(Rigid()).derivative == (Path(("second",)),)


def test_storage_that_prefers_to_be_dependent_is_offered_its_state_last():
    causal = strokes_of(replace(Rigid(), first=Follower(mass=1.0)))
    assert causal.derivative == (Path(("first",)),)


def test_storage_that_prefers_to_be_a_state_is_offered_it_first():
    causal = strokes_of(replace(Rigid(), second=Leader(mass=2.0)))
    assert causal.derivative == (Path(("first",)),)


def test_a_preference_that_nothing_allows_is_not_insisted_on():
    class Alone(Component):
        mass = Follower(mass=1.0)
        damper = Damper(damping=1.0)
        wall = Fixed()
        connections = (connect(mass.flange, damper.a), connect(damper.b, wall.flange))

    causal = strokes_of(Alone())
    assert causal.integral == (Path(("mass",)),)
    assert causal.derivative == ()


class Yielding(Damper):
    preference = Preference.FLOW


class Series(Component):
    """Two dampers that share a force: one of them sets the speed of the flange between them."""

    spring = Spring(stiffness=1.0)
    first = Damper(damping=1.0)
    second = Damper(damping=2.0)
    source = Velocity(velocity=1.0)
    wall = Fixed()

    connections = (
        connect(source.flange, first.a),
        connect(first.b, second.a),
        connect(second.b, wall.flange),
        connect(spring.a, source.flange),
        connect(spring.b, wall.flange),
    )


def test_a_resistance_gives_what_its_author_prefers_and_the_stroke_says_so():
    plain = strokes_of(Series())
    ports = ("first.port", "second.port")
    assert [receives_effort(plain, port) for port in ports] == [False, True]
    for name, expected in (("first", [True, False]), ("second", [False, True])):
        causal = strokes_of(replace(Series(), **{name: Yielding(damping=1.0)}))
        assert [receives_effort(causal, port) for port in ports] == expected
        stroke = causal.strokes[Path((name, "port"))]
        assert (stroke.why, stroke.cause) == (Why.PREFERENCE, Path((name,)))
        report = explain_causality(causal)
        assert "preferred by its author" in report.table()
        assert f"R {name} has either causality, and its author prefers this one" in report.explanation()


def test_a_preference_of_the_wrong_kind_is_refused():
    class Wrong(Damper):
        preference = Preference.DERIVATIVE

    with pytest.raises(ModelError) as caught:
        elaborate(replace(Series(), first=Wrong(damping=1.0)))
    (fault,) = caught.value.diagnostics
    assert fault.code == "model/preference"
    assert fault.message == "Wrong prefers the causality derivative, which it cannot have"
    assert fault.help == "write preference = Preference.EFFORT or Preference.FLOW"


def test_preferences_are_in_the_document():
    model = elaborate(replace(Series(), first=Yielding(damping=1.0)))
    again = from_document(to_document(model))
    assert again == model
    assert assign_causality(flatten(again)).strokes == assign_causality(flatten(model)).strokes
