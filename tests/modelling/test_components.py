"""The class body is the model: names, views, variants, and what is refused at the author's line."""

from __future__ import annotations

import inspect

import pytest

from propermodel.diagnostics import ModelError, Path
from propermodel.expressions import Expr
from propermodel.modelling import (
    Compliance,
    Component,
    Parameter,
    Port,
    Rotation,
    Translation,
    chain,
    connect,
    elaborate,
    parameter,
    quantity,
    repeat,
    replace,
)
from tests.parts import Damper, Fixed, Flywheel, Force, Lever, Mass, Spring, SpringDamper


def line_of_next(lines: int = 1) -> str:
    """The place of a line after the caller's."""
    frame = inspect.currentframe()
    assert frame is not None
    assert frame.f_back is not None
    return f"tests/modelling/test_components.py:{frame.f_back.f_lineno + lines}"


class QuarterCar(Component):
    """Body on a suspension on a wheel on a tyre; the road moves the tyre."""

    road = Port(Translation)
    body_mass: Parameter = parameter("kg", default=1200.0, low=100.0, high=5000.0)

    body = Mass(mass=body_mass)
    wheel = Mass(mass=80.0)
    suspension = SpringDamper(stiffness=2.0e4, damping=1.5e3)
    tyre = SpringDamper(stiffness=2.4e5, damping=1.5e2)

    connections = (
        connect(road, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange),
    )


# -- names and views ------------------------------------------------------------------------------------


def test_paths_come_from_the_class_body():
    car = QuarterCar()
    assert car.suspension.spring.path == Path(("suspension", "spring"))
    assert str(car.suspension.spring.port.path) == "suspension.spring.port"
    assert repr(car.suspension.spring.port.effort) == "suspension.spring.port.effort"
    assert repr(car.suspension.stiffness) == "suspension.stiffness"


def test_parts_compare_by_root_and_path():
    car, other = QuarterCar(), QuarterCar()
    assert car.suspension == car.suspension
    assert hash(car.suspension.spring) == hash(car.suspension.spring)
    assert car.suspension != car.tyre
    assert car.suspension != other.suspension
    assert car.suspension.spring.port.effort is car.suspension.spring.port.effort
    assert car.suspension.spring.port.effort is not other.suspension.spring.port.effort


def test_observables_of_a_port():
    port = QuarterCar().suspension.spring.port
    named = {name: getattr(port, name).data.unit for name in ("effort", "flow", "power", "displacement", "momentum")}
    assert named == {"effort": "N", "flow": "m/s", "power": "W", "displacement": "m", "momentum": "N.s"}


def test_parameters_of_one_unit_are_two_parameters():
    class Pair(Component):
        first: Parameter = parameter("kg", default=1.0)
        second: Parameter = parameter("kg", default=2.0)

    assert Pair.first is not Pair.second
    assert [p.name for p in elaborate(Pair()).root.definition.parameters] == ["first", "second"]


def test_repeat_numbers_its_parts():
    class Train(Component):
        size: Parameter = parameter("kg", default=7.0)
        cars = repeat(3, Lever(ratio=2.0))
        masses = repeat(2, Mass(mass=size))
        connections = (*chain(cars, "b", "a"), connect(masses[0].flange, cars[0].a))

    train = Train()
    assert str(train.cars[1].a.path) == "cars[1].a"
    assert len(train.cars) == 3
    assert [str(car.path) for car in train.cars] == ["cars[0]", "cars[1]", "cars[2]"]
    definition = elaborate(train).root.definition
    assert [p.name for p in definition.parts] == ["cars[0]", "cars[1]", "cars[2]", "masses[0]", "masses[1]"]
    assert [tuple(map(str, c.ports)) for c in definition.connections] == [
        ("cars[0].b", "cars[1].a"),
        ("cars[1].b", "cars[2].a"),
        ("masses[0].flange", "cars[0].a"),
    ]


def test_subclass_inherits_and_overrides():
    class Stiffer(QuarterCar):
        tyre = SpringDamper(stiffness=9.9e5, damping=1.5e2)
        spare = Mass(mass=20.0)

    names = [p.name for p in elaborate(Stiffer()).root.definition.parts]
    assert set(names) == {"body", "wheel", "suspension", "tyre", "spare"}


# -- immutability and variants ----------------------------------------------------------------------------


def test_components_and_parameters_are_immutable():
    car = QuarterCar()
    with pytest.raises(AttributeError, match=r"make a variant with replace\(component, wheel=...\)"):
        car.wheel = Mass(mass=1.0)  # pyright: ignore
    with pytest.raises(AttributeError, match="immutable"):
        car.body_mass = 3.0  # pyright: ignore


def test_replace_exchanges_values_and_parts():
    class Heavy(Mass):
        """Another kind of mass."""

    variant = replace(QuarterCar(), body_mass=900.0, wheel=Heavy(mass=33.0))
    model = elaborate(variant, name="quarter_car")
    original = elaborate(QuarterCar())
    parts = {p.name: p for p in model.root.definition.parts}
    assert parts["wheel"].definition.type_name == "Heavy"
    assert dict(model.root.values)["body_mass"].data == (900.0, "")
    assert {p.name for p in original.root.definition.parts if p.definition.type_name == "Heavy"} == set()
    assert model != original


def test_replace_reaches_views_of_the_variant():
    class Wide(SpringDamper):
        extra = Damper(damping=1.0)
        connections = (
            *SpringDamper.connections,
            connect(SpringDamper.a, extra.a),
            connect(SpringDamper.b, extra.b),
        )

    variant = replace(QuarterCar(), suspension=Wide(stiffness=1.0, damping=1.0))
    assert str(variant.suspension.extra.port.path) == "suspension.extra.port"
    assert elaborate(variant).root.definition.parts[2].definition.type_name == "Wide"


def test_replace_of_something_unknown_offers_the_nearest_name():
    with pytest.raises(ModelError) as caught:
        replace(QuarterCar(), suspensoin=Mass(mass=1.0))
    (fault,) = caught.value.diagnostics
    assert fault.message == "QuarterCar has no part or parameter 'suspensoin'"
    assert fault.help == "did you mean 'suspension'?"
    assert fault.source.file == "tests/modelling/test_components.py"


def test_replace_keeps_parts_parts_and_values_values():
    for change in ({"wheel": 3.0}, {"body_mass": Mass(mass=1.0)}, {"road": 1.0}):
        with pytest.raises(ModelError) as caught:
            replace(QuarterCar(), **change)
        (fault,) = caught.value.diagnostics
        assert fault.code == "model/replace"
        assert fault.help == "replace a part by a part, and a parameter or table by its new value"
        assert fault.source.file == "tests/modelling/test_components.py"


def test_replacement_must_have_the_ports_that_are_connected():
    faults = faults_of(replace(QuarterCar(), wheel=Spring(stiffness=1.0)))
    assert [f.message for f in faults] == ["there is no port 'wheel.flange' to connect"]
    assert faults[0].source.file == "tests/modelling/test_components.py"


# -- faults of a class body ---------------------------------------------------------------------------------


def test_unknown_parameter_offers_the_nearest_name():
    place = line_of_next(2)
    with pytest.raises(ModelError) as caught:
        Spring(stifness=3.0)  # pyright: ignore
    (fault,) = caught.value.diagnostics
    assert fault.code == "model/unknown-parameter"
    assert fault.message == "Spring has no parameter 'stifness'"
    assert fault.help == "did you mean 'stiffness'?"
    assert str(fault.source) == place
    assert [(i.path, i.role) for i in fault.involved] == [("stiffness", "is a parameter of it")]


def test_one_object_under_two_names_is_refused():
    with pytest.raises(ModelError) as caught:

        class Twins(Component):
            axle = Mass(mass=1.0)
            front = axle

    (fault,) = caught.value.diagnostics
    assert fault.code == "model/two-names"
    assert fault.message == "Twins gives one object the names 'axle' and 'front'"
    assert fault.help == "make each part its own: left = Wheel(...), right = Wheel(...)"


def faults_of(component: Component):
    with pytest.raises(ModelError) as caught:
        elaborate(component)
    return caught.value.diagnostics


def test_missing_parameter_is_reported_where_the_part_stands():
    class Forgetful(Component):
        place = line_of_next()
        mass = Mass()  # pyright: ignore
        connections = ()

    (fault,) = faults_of(Forgetful())
    assert fault.code == "model/missing-parameter"
    assert fault.message == "mass: needs a value for 'mass' (kg)"
    assert str(fault.source) == Forgetful.place
    assert [(i.path, i.role) for i in fault.involved] == [("Mass", "is declared here")]
    assert fault.involved[0].source.file == "tests/parts.py"


@pytest.mark.parametrize("value", [50.0, 6000.0])
def test_value_outside_its_range_is_reported(value):
    (fault,) = faults_of(QuarterCar(body_mass=value))
    assert fault.code == "model/parameter-range"
    assert fault.message == f"quarter_car: 'body_mass' = {value:g} kg lies outside its range 100 to 5000"


def test_range_is_in_the_declared_unit():
    class Bottle(Component):
        pressure: Parameter = parameter("bar", default=3.0, low=1.0, high=10.0)

    assert elaborate(Bottle(pressure=9.5)).root.values[0][1].data == (9.5e5, "")
    (fault,) = faults_of(Bottle(pressure=11.0))
    assert fault.message == "bottle: 'pressure' = 11 bar lies outside its range 1 to 10"


def test_several_faults_are_raised_at_once():
    class Sloppy(Component):
        first = Mass()  # pyright: ignore
        second = Damper()  # pyright: ignore
        connections = ()

    assert {f.message for f in faults_of(Sloppy())} == {
        "first: needs a value for 'mass' (kg)",
        "second: needs a value for 'damping' (N.s/m)",
    }


def test_ports_of_two_domains_do_not_connect():
    class Mixed(Component):
        mass = Mass(mass=1.0)
        wheel = Flywheel(inertia=1.0)
        place = line_of_next()
        connections = (connect(mass.flange, wheel.shaft),)  # pyright: ignore

    (fault,) = faults_of(Mixed())
    assert fault.code == "model/domain"
    assert fault.message == "a connection joins ports of different domains (rotation, translation)"
    assert [(i.path, i.role) for i in fault.involved] == [
        ("mass.flange", "is translation"),
        ("wheel.shaft", "is rotation"),
    ]
    assert fault.help == "put a transducer (transformer or gyrator) between the domains"
    assert str(fault.source) == Mixed.place


def test_ports_of_strangers_do_not_connect():
    stranger = Mass(mass=1.0)

    class Lonely(Component):
        push = Force(force=1.0)
        connections = (connect(push.flange, stranger.flange),)

    (fault,) = faults_of(Lonely())
    assert fault.code == "model/foreign-reference"
    assert fault.message == "Lonely connects a port of something that is not one of its direct parts"
    assert fault.help == "connections reach into the ports of direct parts only"


def test_laws_do_not_mention_strangers():
    stranger = Mass(mass=1.0)

    class Nosy(Compliance):
        port = Port(Translation)

        def effort(self, displacement: Expr) -> Expr:
            return displacement * stranger.mass / quantity(1.0, "s2")

    (fault,) = faults_of(Nosy())
    assert fault.code == "model/foreign-reference"
    assert "is not one of its direct parts" in fault.message


def test_connect_wants_ports_not_parts():
    with pytest.raises(ModelError) as caught:
        connect(Mass(mass=1.0), Fixed().flange)  # pyright: ignore
    (fault,) = caught.value.diagnostics
    assert fault.message == (
        "connect joins power ports, or a signal with the inputs it drives; it was given Mass, Port"
    )
    assert fault.help.startswith("name a port of the part")


def test_law_handed_in_where_an_observable_is_expected():
    with pytest.raises(ModelError) as caught:
        connect(Spring(stiffness=1.0).effort, Mass(mass=1.0).flange)  # pyright: ignore
    assert "it was given method, Port" in caught.value.diagnostics[0].message


def test_parameter_handed_to_a_part_must_fit():
    class Confused(Component):
        length: Parameter = parameter("m", default=1.0)
        mass = Mass(mass=length)
        connections = ()

    (fault,) = faults_of(Confused())
    assert fault.code == "model/dimension"
    assert fault.message == "mass: 'mass' is handed m where kg is due"


def test_parameter_expression_is_in_the_parents_parameters():
    class Scaled(Component):
        radius: Parameter = parameter("m", default=0.5)
        density: Parameter = parameter("kg/m3", default=7800.0)
        mass = Mass(mass=density * radius**3)
        connections = ()

    (part,) = elaborate(Scaled()).root.definition.parts
    assert repr(dict(part.values)["mass"]) == "density*radius**3"


def test_root_takes_numbers_only():
    (fault,) = faults_of(QuarterCar(body_mass=QuarterCar().tyre.stiffness))
    assert fault.message == "quarter_car: 'body_mass' of the root must be a number"


def test_rotation_is_not_translation_for_the_reader_either():
    assert repr(Port(Rotation).effort.data.unit) == "'N.m'"
