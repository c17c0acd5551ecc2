"""From a component to plain data."""

from __future__ import annotations

import pytest

from propermodel.diagnostics import ModelError, parse_path
from propermodel.modelling import (
    Component,
    ConstantEffort,
    Input,
    Output,
    Parameter,
    Port,
    SignalBlock,
    Translation,
    Updates,
    ZeroEffort,
    connect,
    elaborate,
    evaluate,
    parameter,
    quantity,
)
from propermodel.modelling.elaborate import find_part
from tests.modelling.test_components import QuarterCar
from tests.parts import Damper, Fixed, Mass, Spring, SpringDamper


def test_models_are_equal_by_value():
    assert elaborate(QuarterCar()) == elaborate(QuarterCar())
    assert elaborate(QuarterCar()) != elaborate(QuarterCar(body_mass=900.0))
    assert elaborate(QuarterCar()) != elaborate(QuarterCar(), name="other")


def test_where_something_was_written_is_no_part_of_equality():
    def here() -> type[Component]:
        class Rig(Component):
            mass = Mass(mass=1.0)
            connections = ()

        return Rig

    def there() -> type[Component]:
        class Rig(Component):
            mass = Mass(mass=1.0)
            connections = ()

        return Rig

    first, second = elaborate(here()()), elaborate(there()())
    assert first == second
    assert first.root.definition.source != second.root.definition.source
    assert first.root.definition.source.file == "tests/modelling/test_elaborate.py"


def test_a_class_is_read_once():
    definition = elaborate(QuarterCar()).root.definition
    suspension, tyre = (p.definition for p in definition.parts if p.name in ("suspension", "tyre"))
    assert suspension is tyre


def test_removals_are_data_of_the_model():
    model = elaborate(QuarterCar())
    removal = ZeroEffort(parse_path("tyre.damper.port"))
    other = ConstantEffort(parse_path("suspension.damper.port"), 3.0)
    assert model.without([removal]).without([other]).removals == (removal, other)
    assert model.removals == ()
    assert model.without([removal]) == model.without([removal])
    assert model.without([removal]) != model


def test_domains_are_held_by_value():
    model = elaborate(QuarterCar())
    domain = model.domain("translation")
    assert (domain.effort_unit, domain.flow_unit) == ("N", "m/s")
    assert model.domains == (Translation.data(),)


def test_two_domains_of_one_name_are_refused():
    class Other(Translation):
        name = "translation"
        effort_unit = "kN"

    class Mixed(Component):
        left = Port(Translation)
        right = Port(Other)

    with pytest.raises(ModelError) as caught:
        elaborate(Mixed())
    assert caught.value.diagnostics[0].message == "two different domains are called 'translation'"


def test_name_of_a_model_is_its_class_in_snake_case():
    assert elaborate(QuarterCar()).name == "quarter_car"
    assert elaborate(QuarterCar(), name="rig").name == "rig"


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("QuarterCarOnARoad", "quarter_car_on_a_road"),
        ("RLC", "rlc"),
        ("SeriesRLCCircuit", "series_rlc_circuit"),
        ("DCMotor", "dc_motor"),
        ("Truck6x6", "truck6x6"),
    ],
)
def test_one_letter_and_several_capitals_are_words_in_the_name(written, name):
    assert elaborate(type(written, (QuarterCar,), {})()).name == name


class Gain(SignalBlock):
    given = Input("m/s")
    taken = Output("N")
    factor: Parameter = parameter("N.s/m", default=2.0)

    def outputs(self) -> Updates:
        return {self.taken: self.factor * self.given}


def test_signal_of_another_dimension_is_refused():
    class Miswired(Component):
        mass = Mass(mass=1.0)
        wall = Fixed()
        gain = Gain()
        connections = (connect(mass.flange, wall.flange), connect(mass.flange.effort, gain.given))

    with pytest.raises(ModelError) as caught:
        elaborate(Miswired())
    (fault,) = caught.value.diagnostics
    assert fault.message == "'gain.given' takes m/s and is driven by kg.m/s2"
    assert fault.source.file == "tests/modelling/test_elaborate.py"


def test_signal_may_be_an_expression_of_observables_deep_inside():
    class Wired(Component):
        mass = Mass(mass=1.0)
        strut = SpringDamper(stiffness=1.0, damping=1.0)
        wall = Fixed()
        gain = Gain()
        connections = (
            connect(mass.flange, strut.a),
            connect(strut.b, wall.flange),
            connect(mass.flange.flow - strut.damper.port.flow * 0.5, gain.given),
        )

    (link,) = (c for c in elaborate(Wired()).root.definition.connections if hasattr(c, "value"))
    assert repr(link.value) == "mass.flange.flow - strut.damper.port.flow*0.5"
    assert link.targets == (parse_path("gain.given"),)


def test_evaluate_calls_a_law_with_plain_numbers():
    assert evaluate(Spring(stiffness=30.0).effort, 0.2) == pytest.approx(6.0)
    assert evaluate(Damper(damping=quantity(2.0, "kN.s/m")).effort, 0.1) == pytest.approx(200.0)


def test_find_part():
    model = elaborate(QuarterCar())
    assert find_part(model, parse_path("suspension.spring")).definition.type_name == "Spring"
    with pytest.raises(ModelError) as caught:
        find_part(model, parse_path("suspension.sprin"))
    (fault,) = caught.value.diagnostics
    assert fault.message == "quarter_car has no part 'suspension.sprin': 'sprin' is not in suspension"
    assert fault.help == "did you mean 'spring'?"
