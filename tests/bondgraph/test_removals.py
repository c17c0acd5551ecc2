"""What each removal does, and what cannot be removed."""

from __future__ import annotations

import pytest

from propermodel.bondgraph.flatten import flatten
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.expressions import Expr
from propermodel.modelling import (
    Component,
    ConstantEffort,
    ConstantFlow,
    Cut,
    MultiportCompliance,
    Port,
    State,
    Translation,
    ZeroEffort,
    ZeroFlow,
    connect,
    elaborate,
    quantity,
)
from propermodel.modelling.model import Removal, Variable
from tests.parts import Damper, Fixed, Force, Mass, Spring
from tests.points import Point, equations_of


class Oscillator(Component):
    mass = Mass(mass=2.0)
    spring = Spring(stiffness=50.0)
    damper = Damper(damping=3.0)
    wall = Fixed()
    push = Force(force=7.0)

    connections = (
        connect(mass.flange, spring.a, damper.a, push.flange),
        connect(wall.flange, spring.b, damper.b),
    )


def reduced(component: Component, *removals: Removal):
    return equations_of(elaborate(component).without(removals))


def test_constant_effort_takes_the_place_of_a_spring():
    system = reduced(Oscillator(), ConstantEffort(parse_path("spring.port"), 11.0))
    point = Point(system, {"mass.momentum": 4.0})
    assert point.rates()["mass.momentum"] == pytest.approx(-11.0 - 3.0 * 2.0 - 7.0)
    assert point["spring.port.effort"] == pytest.approx(11.0)
    assert point["spring.port.flow"] == pytest.approx(2.0)


def test_constant_flow_takes_the_place_of_a_mass():
    system = reduced(Oscillator(), ConstantFlow(parse_path("mass.flange"), 1.5))
    point = Point(system, {"spring.displacement": 0.1})
    assert point.rates() == {"spring.displacement": pytest.approx(1.5)}
    assert point["mass.flange.effort"] == pytest.approx(-(50.0 * 0.1 + 3.0 * 1.5 + 7.0))


def test_mass_without_effort_is_massless():
    system = reduced(Oscillator(), ZeroEffort(parse_path("mass.flange")))
    point = Point(system, {"spring.displacement": 0.1})
    # The damper moves as the spring and the force make it.
    assert point.rates() == {"spring.displacement": pytest.approx(-(50.0 * 0.1 + 7.0) / 3.0)}


def test_mass_without_flow_stands_still():
    system = reduced(Oscillator(), ZeroFlow(parse_path("mass.flange")))
    point = Point(system, {str(s.path): 0.1 for s in system.states})
    assert all(rate == 0.0 for rate in point.rates().values())
    assert point["damper.port.flow"] == 0.0


class Coupled(Component):
    """A large mass drags a small one along."""

    large = Mass(mass=100.0)
    coupling = Damper(damping=3.0)
    small = Mass(mass=0.5)

    connections = (connect(large.flange, coupling.a), connect(coupling.b, small.flange))


def test_cut_element_is_driven_but_does_not_act_back():
    system = reduced(Coupled(), Cut(parse_path("small.flange"), Variable.EFFORT))
    point = Point(system, {"large.momentum": 200.0, "small.momentum": 0.25})
    # The small mass is dragged, but for the damper it stands still.
    assert point["coupling.port.flow"] == pytest.approx(2.0)
    assert point.rates() == {"large.momentum": pytest.approx(-6.0), "small.momentum": pytest.approx(6.0)}


def test_element_is_driven_by_what_its_junction_shares():
    fault = fault_of(Coupled(), Cut(parse_path("coupling.port"), Variable.FLOW))
    assert fault.code == "reduction/cut"
    assert fault.message == "coupling.port cannot be driven by the flow of the 0-junction coupling.difference"
    assert fault.help == "an element at a 1-junction is driven by its flow, one at a 0-junction by its effort"


def fault_of(component: Component, *removals: Removal):
    with pytest.raises(ReductionError) as caught:
        flatten(elaborate(component).without(removals))
    (fault,) = caught.value.diagnostics
    return fault


def test_a_bond_is_removed_once():
    spring = parse_path("spring.port")
    fault = fault_of(Oscillator(), ZeroEffort(spring), ZeroFlow(spring))
    assert fault.code == "reduction/removed-twice"
    assert fault.message == "'spring.port' is removed 2 times"


def test_unknown_bond_offers_the_nearest():
    fault = fault_of(Oscillator(), ZeroEffort(parse_path("sprin.port")))
    assert fault.code == "reduction/unknown-removal"
    assert fault.message == "a removal names 'sprin.port', which is no bond of the model in normal form"
    assert fault.help == "did you mean 'spring.port'?"


class Field(MultiportCompliance):
    one = Port(Translation)
    two = Port(Translation)
    first = State("m")
    second = State("m")

    def energy(self) -> Expr:
        return quantity(8.0, "N/m") * (self.first * self.first + self.first * self.second + self.second**2)


class FieldBetweenMasses(Component):
    field = Field()
    left = Mass(mass=1.0)
    right = Mass(mass=2.0)

    connections = (connect(field.one, left.flange), connect(field.two, right.flange))


def test_a_field_goes_as_a_whole():
    fault = fault_of(FieldBetweenMasses(), ZeroEffort(parse_path("field.one")))
    assert fault.code == "reduction/partial-field"
    assert fault.message == "field is removed at some of its ports only; field.two would be left"
    assert fault.help == "say for every port of a field what replaces it"


def test_a_field_without_efforts_sets_both_masses_free():
    system = reduced(FieldBetweenMasses(), ZeroEffort(parse_path("field.one")), ZeroEffort(parse_path("field.two")))
    point = Point(system, {"left.momentum": 1.0, "right.momentum": 2.0})
    assert point.rates() == {"left.momentum": 0.0, "right.momentum": 0.0}
