"""Laws become expressions: which causalities they offer, what is derived, and what is refused."""

from __future__ import annotations

import inspect

import pytest

from propermodel.diagnostics import ModelError, Path
from propermodel.expressions import Expr, absolute, exp, sign, sqrt
from propermodel.expressions.core import Expr as Expression
from propermodel.expressions.core import SymbolKind, leaves, symbol
from propermodel.expressions.derivatives import derivative
from propermodel.expressions.interpret import interpret
from propermodel.modelling import (
    Compliance,
    Component,
    Controller,
    Discrete,
    Hydraulic,
    Inertia,
    Input,
    MultiportCompliance,
    MultiportResistance,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    State,
    Transformer,
    Translation,
    Updates,
    elaborate,
    parameter,
    quantity,
)
from propermodel.modelling.model import Resistive, Sampled, Storage, Variable
from tests.parts import Damper, Mass, Spring


def behaviour_of(component: Component):
    return elaborate(component).root.definition.behaviour


def fault_of(component: Component):
    with pytest.raises(ModelError) as caught:
        elaborate(component)
    (fault,) = caught.value.diagnostics
    return fault


def value(expr: Expression, **symbols: float) -> float:
    """The value of a traced law, symbols by their last name."""
    return interpret(expr, {leaf: symbols[leaf.data.path.name] for leaf in leaves(expr)})


# -- resistances --------------------------------------------------------------------------------------------


def test_linear_law_is_inverted_for_the_author():
    resistive = behaviour_of(Damper(damping=2.0))
    assert isinstance(resistive, Resistive)
    results = {r.variable: r.value for law in resistive.laws for r in law.results}
    assert value(results[Variable.EFFORT], damping=4.0, flow=3.0) == 12.0
    assert value(results[Variable.FLOW], damping=4.0, effort=12.0) == 3.0


class Preloaded(Resistance):
    port = Port(Translation)

    def flow(self, effort: Expr) -> Expr:
        return (effort - quantity(3.0, "N")) / quantity(2.0, "N.s/m")


def test_affine_law_is_inverted_too():
    results = {r.variable: r.value for law in behaviour_of(Preloaded()).laws for r in law.results}
    assert value(results[Variable.FLOW], effort=7.0) == pytest.approx(2.0)
    assert value(results[Variable.EFFORT], flow=2.0) == pytest.approx(7.0)


class Orifice(Resistance):
    port = Port(Hydraulic)
    loss: Parameter = parameter("Pa.s2/m6")

    def effort(self, flow: Expr) -> Expr:
        return self.loss * flow * absolute(flow)


class BothWays(Orifice):
    def flow(self, effort: Expr) -> Expr:
        return sign(effort) * sqrt(absolute(effort) / self.loss)


def test_nonlinear_law_has_the_causality_it_is_written_in():
    assert [law.results[0].variable for law in behaviour_of(Orifice(loss=1.0)).laws] == [Variable.EFFORT]
    assert [law.results[0].variable for law in behaviour_of(BothWays(loss=1.0)).laws] == [
        Variable.EFFORT,
        Variable.FLOW,
    ]


def test_the_two_laws_are_inverse_to_each_other():
    laws = {law.results[0].variable: law.results[0].value for law in behaviour_of(BothWays(loss=1.0)).laws}
    for q in (-2.0, 0.5, 3.0):
        p = value(laws[Variable.EFFORT], loss=7.0, flow=q)
        assert value(laws[Variable.FLOW], loss=7.0, effort=p) == pytest.approx(q)


class Lawless(Resistance):
    port = Port(Translation)


def test_resistance_without_a_law():
    fault = fault_of(Lawless())
    assert fault.code == "model/law-missing"
    assert fault.message == "Lawless has no law: neither effort(flow) nor flow(effort) nor residual(effort, flow)"
    assert fault.help == "define the law as a method of the class"
    assert fault.source.file == "tests/modelling/test_tracing.py"


class Implicit(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m")
    force: Parameter = parameter("N")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        return effort + effort * absolute(effort) / self.force - self.damping * flow


def test_an_implicit_law_gives_openly_what_it_is_linear_in():
    behaviour = behaviour_of(Implicit(damping=2.0, force=5.0))
    assert isinstance(behaviour, Resistive)
    (law,) = behaviour.laws
    assert law.results[0].variable is Variable.FLOW
    assert value(law.results[0].value, effort=-10.0, damping=2.0, force=5.0) == -15.0
    (residual,) = behaviour.implicit
    assert value(residual, effort=-10.0, flow=-15.0, damping=2.0, force=5.0) == 0.0


def test_a_law_next_to_an_implicit_one_is_used_as_given():
    class Given(Implicit):
        def effort(self, flow: Expr) -> Expr:
            return self.damping * flow

    behaviour = behaviour_of(Given(damping=2.0, force=5.0))
    assert isinstance(behaviour, Resistive)
    assert [law.results[0].variable for law in behaviour.laws] == [Variable.EFFORT, Variable.FLOW]
    assert behaviour.implicit == ()


def test_an_implicit_law_is_checked_for_dimensions():
    class Mixed(Implicit):
        def residual(self, effort: Expr, flow: Expr) -> Expr:
            return effort + effort * effort - self.damping * flow

    fault = fault_of(Mixed(damping=2.0, force=5.0))
    assert fault.code == "model/dimension"
    assert "Mixed.residual is not dimensionally consistent" in fault.message


def test_an_implicit_law_without_the_flow_is_that_of_a_source():
    class Source(Implicit):
        def residual(self, effort: Expr, flow: Expr) -> Expr:
            return effort - self.force

    fault = fault_of(Source(damping=2.0, force=5.0))
    assert fault.code == "model/implicit-law"
    assert fault.message == "the implicit law Source.residual does not depend on the flow"


class Converter(MultiportResistance):
    pump = Port(Rotation)
    turbine = Port(Rotation)
    gain: Parameter = parameter("N.m.s2/rad2")

    def laws(self) -> tuple[Updates, ...]:
        torque = self.gain * self.pump.flow * self.pump.flow
        return ({self.pump.effort: torque, self.turbine.effort: -2.0 * torque},)


def test_two_port_resistance():
    (law,) = behaviour_of(Converter(gain=1.0)).laws
    assert [(r.port, r.variable) for r in law.results] == [
        ("pump", Variable.EFFORT),
        ("turbine", Variable.EFFORT),
    ]
    assert value(law.results[1].value, gain=3.0, flow=2.0) == -24.0


# -- storage ------------------------------------------------------------------------------------------------


def test_linear_storage_has_its_energy_and_inverse():
    storage = behaviour_of(Spring(stiffness=1.0))
    assert isinstance(storage, Storage)
    assert value(storage.energy, stiffness=4.0, displacement=3.0) == pytest.approx(18.0)
    assert value(storage.inverse, stiffness=4.0, effort=12.0) == pytest.approx(3.0)


def test_inertia_is_written_by_its_momentum():
    storage = behaviour_of(Mass(mass=1.0))
    (_, flow) = storage.outputs[0]
    assert value(flow, mass=4.0, momentum=12.0) == pytest.approx(3.0)
    assert value(storage.energy, mass=4.0, momentum=12.0) == pytest.approx(18.0)


class Offset(Compliance):
    port = Port(Translation)

    def effort(self, displacement: Expr) -> Expr:
        return quantity(4.0, "N/m") * (displacement - quantity(0.5, "m"))


@pytest.mark.parametrize("component", [Spring(stiffness=1.0), Mass(mass=2.0), Offset()])
def test_derivative_of_the_energy_is_the_law(component):
    storage = behaviour_of(component)
    coordinate = storage.coordinates[0]
    state = symbol(SymbolKind.STATE, Path((coordinate.name,)), coordinate.unit)
    slope = derivative(storage.energy, state)
    for x in (-1.0, 0.3, 2.0):
        values = dict.fromkeys(("mass", "stiffness"), 2.0) | {coordinate.name: x}
        assert value(slope, **values) == pytest.approx(value(storage.outputs[0][1], **values))


class Gas(Compliance):
    port = Port(Hydraulic)

    def effort(self, displacement: Expr) -> Expr:
        return quantity(1e5, "Pa") * exp(displacement / quantity(1e-3, "m3"))


def test_nonlinear_storage_needs_its_energy():
    fault = fault_of(Gas())
    assert fault.message == ("Gas has no energy(displacement), which a nonlinear storage needs for the energy balance")


class Turning(Inertia):
    shaft = Port(Rotation)

    def momentum(self, flow: Expr) -> Expr:
        return quantity(2.0, "kg.m2") * flow * absolute(flow) / quantity(1.0, "rad/s")


def test_inertia_that_cannot_be_inverted_needs_its_flow():
    assert fault_of(Turning()).message == "Turning has no law flow(momentum)"


class Lopsided(MultiportCompliance):
    one = Port(Translation)
    two = Port(Translation)
    first = State("m")

    def energy(self) -> Expr:
        return quantity(1.0, "N/m") * self.first * self.first


def test_field_needs_a_state_for_each_port():
    assert fault_of(Lopsided()).message == "Lopsided has no one State per port (2 ports, 1 states)"


class TwoPorted(Compliance):
    left = Port(Translation)
    right = Port(Translation)

    def effort(self, displacement: Expr) -> Expr:
        return quantity(1.0, "N/m") * displacement


def test_one_port_element_has_one_port():
    fault = fault_of(TwoPorted())
    assert fault.code == "model/ports"
    assert fault.message == "TwoPorted is a one-port element but has the ports left, right"
    assert fault.help == "give it one port; an element between two flanges has Port(domain, between=(a, b))"


# -- dimensions ---------------------------------------------------------------------------------------------


class Wrong(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow * flow


def line_of(cls: type, method: str) -> str:
    return f"tests/modelling/test_tracing.py:{inspect.getsourcelines(getattr(cls, method))[1]}"


def test_law_of_another_dimension_is_reported_at_the_law():
    fault = fault_of(Wrong(damping=1.0))
    assert str(fault) == (
        "error[model/dimension]: the law Wrong.effort is not dimensionally consistent: "
        "it has the dimension kg.m2/s3 where N (kg.m/s2) is due\n"
        f"  --> {line_of(Wrong, 'effort')}\n"
        "  help: check the units of the parameters; write a number with its unit: quantity(1e-6, 'm3/s')"
    )


class Adding(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow + 3.0


def test_bare_number_in_a_law_is_dimensionless():
    fault = fault_of(Adding(damping=1.0))
    assert "'damping*port.flow + 3' combines kg.m/s2 and 1" in fault.message


class Unchecked(Transformer):
    a = Port(Translation)
    b = Port(Rotation)
    radius: Parameter = parameter("m", default=1.0)

    def modulus(self) -> Expr:
        return self.radius


def test_modulus_must_join_the_domains():
    # A force is torque over radius: the modulus has the dimension 1/m.
    fault = fault_of(Unchecked())
    assert fault.message == (
        "the law Unchecked.modulus is not dimensionally consistent: "
        "it has the dimension kg.m3/s2 where N (kg.m/s2) is due"
    )


class Branching(Resistance):
    port = Port(Translation)

    def effort(self, flow: Expr) -> Expr:
        if flow > 0.0:
            return quantity(1.0, "N.s/m") * flow
        return quantity(2.0, "N.s/m") * flow


def test_if_in_a_law_points_to_where():
    with pytest.raises(ModelError) as caught:
        elaborate(Branching())
    assert "write where(condition, a, b) instead of 'if'" in str(caught.value)
    line = int(line_of(Branching, "effort").rpartition(":")[2]) + 1
    assert str(caught.value.diagnostics[0].source) == f"tests/modelling/test_tracing.py:{line}"


class Broken(Resistance):
    port = Port(Translation)

    def effort(self, flow: Expr) -> Expr:
        return flow.upper()  # pyright: ignore


def test_mistake_in_a_law_is_reported_at_its_line():
    fault = fault_of(Broken())
    assert fault.code == "model/law"
    assert fault.message == (
        "the law Broken.effort cannot be read: AttributeError: 'Expr' object has no attribute 'upper'"
    )
    line = int(line_of(Broken, "effort").rpartition(":")[2]) + 1
    assert str(fault.source) == f"tests/modelling/test_tracing.py:{line}"


# -- signals ------------------------------------------------------------------------------------------------


class Governor(Controller):
    speed = Input("rad/s")
    fuel = Output("kg/s", start=0.5)
    integral = Discrete("rad", start=2.0)

    def step(self) -> Updates:
        return {
            self.integral: self.integral + self.speed * self.period,
            self.fuel: self.integral * quantity(3.0, "kg/s"),
        }


def test_controller_is_read_as_simultaneous_updates():
    sampled = behaviour_of(Governor())
    assert isinstance(sampled, Sampled)
    assert [(n, u, s.data[0]) for n, u, s in sampled.starts] == [("fuel", "kg/s", 0.5), ("integral", "rad", 2.0)]
    updates = dict(sampled.updates)
    assert value(updates["integral"], integral=1.0, speed=4.0, period=0.5) == 3.0
    assert value(updates["fuel"], integral=1.0) == 3.0


class Muddled(SignalBlock):
    given = Input("m")
    taken = Output("m/s")

    def outputs(self) -> Updates:
        return {self.taken: self.given}


def test_signal_of_another_dimension_is_reported():
    assert "it has the dimension m where m/s (m/s) is due" in fault_of(Muddled()).message
