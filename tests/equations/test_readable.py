"""Readable equations: exactly what a lecturer writes, with the values of the equation system."""

from __future__ import annotations

import random
import time

import pytest
from matplotlib.mathtext import MathTextParser

from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import ModelError
from propermodel.equations.readable import LONGEST, state_equations
from propermodel.expressions.core import TIME, Expr, SymbolKind, leaves, lookup
from propermodel.expressions.interpret import interpret_all
from propermodel.expressions.simplify import Simplifier
from propermodel.library.electrical import Capacitor, Ground, Resistor, VoltageSource
from propermodel.modelling import (
    Component,
    Electrical,
    Input,
    Parameter,
    Port,
    Resistance,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.model import Storage
from tests import textbooks

BOOK: dict[type[Component], str] = {
    textbooks.SeriesCircuit: """\
series_circuit: 2 states
inputs: voltage [V]
  coil.inductance*coil.current' = voltage - resistor.resistance*coil.current - capacitor.voltage
  capacitor.capacitance*capacitor.voltage' = coil.current""",
    textbooks.Motor: """\
motor: 2 states
inputs: voltage [V], torque [N.m]
  motor.inductance*coil.current' = voltage - motor.resistance*coil.current
        - motor.constant*rotor.angular_velocity
  motor.inertia*rotor.angular_velocity' = motor.constant*coil.current
        - motor.friction*rotor.angular_velocity + torque""",
    textbooks.GearedInertias: """\
geared_inertias: 1 state
inputs: torque [N.m]
  (pinion.inertia*gear.ratio^2 + wheel.inertia)*pinion.angular_velocity' = gear.ratio^2*torque
        - bearing.damping*pinion.angular_velocity""",
    textbooks.WheatstoneBridge: """\
wheatstone_bridge: 1 state
inputs: voltage [V]
  galvanometer.inductance*galvanometer.current' =
        upper_right.resistance
            *(voltage - lower_right.resistance*galvanometer.current)
            /(upper_right.resistance + lower_right.resistance)
        - upper_left.resistance
            *(voltage + lower_left.resistance*galvanometer.current)
            /(upper_left.resistance + lower_left.resistance)""",
    textbooks.QuarterCar: """\
quarter_car: 4 states
inputs: road.velocity [m/s]
  body.mass*body.velocity' = suspension.stiffness*spring.displacement
        + suspension.damping*(wheel.velocity - body.velocity)
  wheel.mass*wheel.velocity' = tyre.stiffness*tyre.displacement
        - suspension.stiffness*spring.displacement
        + suspension.damping*(body.velocity - wheel.velocity)
  tyre.displacement'         = road.velocity - wheel.velocity
  spring.displacement'       = wheel.velocity - body.velocity""",
    textbooks.Cylinder: """\
cylinder: 2 states
inputs: flow [m3/s]
  chamber.volume/chamber.bulk_modulus*chamber.pressure' = flow - piston.area*load.velocity
        - leakage.conductance*chamber.pressure
  load.mass*load.velocity' = piston.area*chamber.pressure - damper.damping*load.velocity""",
}


def compiled(component: Component) -> CompiledModel:
    return compile_model(elaborate(component))


@pytest.mark.parametrize("component", BOOK, ids=lambda component: component.__name__)
def test_the_equations_are_those_of_the_textbook(component: type[Component]):
    assert state_equations(compiled(component())).text() == BOOK[component]


@pytest.mark.parametrize("component", [*BOOK, textbooks.section_chain], ids=lambda c: c.__name__)
def test_the_rates_are_those_of_the_system(component: type[Component]):
    model = compiled(textbooks.section_chain(5) if component is textbooks.section_chain else component())
    readable = state_equations(model)
    draw = random.Random(1)
    point: dict[Expr, float] = {}
    for flat in model.graph.parameters.values():
        # A parameter that repeats another one has its value.
        point[flat.symbol] = point.get(flat.value, draw.uniform(0.5, 2.0))
    for table, leaf in zip(model.graph.tables.values(), readable.inputs, strict=True):
        point[leaf] = point[lookup(table.symbol, TIME)] = draw.uniform(-1.0, 1.0)
        point[table.symbol] = point[TIME] = 0.0
    shown = {state.path: state for state in readable.states}
    for state in model.system.states:
        point[state.symbol] = draw.uniform(-1.0, 1.0)
    # What is shown is momentum over inertance or charge over capacitance: the value of an effort or flow.
    ratio: dict[Expr, float] = {}
    for state in model.system.states:
        item = shown[state.path]
        ratio[item.symbol] = 1.0
        if item.symbol is not state.symbol:
            law = _law(model, state.path)
            (at_state,) = interpret_all([law], point)
            ratio[item.symbol] = at_state / point[state.symbol]
            point[item.symbol] = at_state
    expected = interpret_all([state.derivative for state in model.system.states], point)
    found = interpret_all([shown[state.path].derivative for state in model.system.states], point)
    for state, rate, given in zip(model.system.states, expected, found, strict=True):
        assert given == pytest.approx(rate * ratio[shown[state.path].symbol], rel=1e-9)


def _law(model: CompiledModel, path: tuple[str, ...]) -> Expr:
    element = next(e for e in model.graph.normal.elements.values() if e.path == path[:-1])
    assert isinstance(element.behaviour, Storage)
    ((_, law),) = element.behaviour.outputs
    return law


def test_what_two_elements_share_has_one_name():
    names = {str(name) for name in state_equations(compiled(textbooks.Motor())).names.values()}
    assert names == {
        "voltage",
        "torque",
        "coil.current",
        "rotor.angular_velocity",
        "motor.inductance",
        "motor.resistance",
        "motor.constant",
        "motor.inertia",
        "motor.friction",
    }


@pytest.mark.parametrize("component", BOOK, ids=lambda component: component.__name__)
def test_latex_can_be_set(component: type[Component]):
    readable = state_equations(compiled(component()))
    parser = MathTextParser("path")
    lines = [line for line in readable.markdown().splitlines() if line.startswith("$$")]
    assert len(lines) == len(readable.states)
    for line in lines:
        parser.parse(f"${line.strip('$')}$")
    rows = readable.latex().splitlines()
    assert rows[0] == r"\begin{align*}"
    assert rows[-1] == r"\end{align*}"
    for row in rows[1:-1]:
        parser.parse(f"${row.removesuffix(chr(92) * 2).replace('&', '')}$")


def test_the_motor_in_latex():
    assert state_equations(compiled(textbooks.Motor())).latex() == (
        "\\begin{align*}\n"
        r"  L_{\mathrm{motor}} \, \dot{i}_{\mathrm{coil}} &= u - R_{\mathrm{motor}} \, i_{\mathrm{coil}}"
        r" - K_{\mathrm{motor}} \, \omega_{\mathrm{rotor}} \\"
        "\n"
        r"  J_{\mathrm{motor}} \, \dot{\omega}_{\mathrm{rotor}} &= K_{\mathrm{motor}} \, i_{\mathrm{coil}}"
        r" - \mathrm{friction}_{\mathrm{motor}} \, \omega_{\mathrm{rotor}} + T"
        "\n\\end{align*}\n"
    )


def test_a_long_chain_is_written_in_bounded_space():
    model = compiled(textbooks.section_chain(500))
    begin = time.process_time()
    readable = state_equations(model)
    text = readable.text()
    assert time.process_time() - begin < 10.0
    assert len(readable.states) == 1000
    assert readable.definitions == ()
    simplifier = Simplifier()
    assert max(simplifier.size(state.right) for state in readable.states) <= LONGEST
    assert text == state_equations(model).text()
    assert "sections[321].mass.mass*sections[321].mass.velocity' =\n" in text
    assert all(
        leaf.data.kind in (SymbolKind.STATE, SymbolKind.PARAMETER, SymbolKind.SIGNAL)
        for state in readable.states
        for leaf in leaves(state.right)
    )


class CubicResistor(Resistance):
    """A law that can only be read one way, u = g i^3."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    gain: Parameter = parameter("V/A3")

    def effort(self, flow: Expr) -> Expr:
        return self.gain * flow * flow * flow


class LoadedDivider(Component):
    """A divider with a nonlinear lower half, loaded by a capacitor."""

    voltage = Input("V")
    source = VoltageSource()
    upper = Resistor(resistance=2.0)
    lower_half = CubicResistor(gain=3.0)
    link = Resistor(resistance=5.0)
    capacitor = Capacitor(capacitance=1e-3)
    ground = Ground()

    connections = (
        connect(voltage, source.voltage),
        connect(source.pin, upper.a),
        connect(upper.b, lower_half.a, link.a),
        connect(link.b, capacitor.a),
        connect(lower_half.b, capacitor.b, ground.pin),
    )


def test_an_implicit_block_says_what_it_solves_for():
    readable = state_equations(compiled(LoadedDivider()))
    lines = readable.text().splitlines()
    assert lines[2:6] == [
        "  capacitor.capacitance*capacitor.voltage' =",
        "        (lower_half.voltage - capacitor.voltage)/link.resistance",
        "",
        "solved together for lower_half.voltage:",
    ]
    assert "".join(line.strip() for line in lines[6:]) == (
        "0 = lower_half.voltage- lower_half.gain*((voltage - lower_half.voltage)/upper.resistance"
        "+ (capacitor.voltage - lower_half.voltage)/link.resistance)^3"
    )
    assert r"\noindent solved together for $u_{\mathrm{lower\ half}}$:" in readable.latex()


def test_outputs_are_written_in_the_same_terms():
    model = compiled(textbooks.QuarterCar())
    (output,) = state_equations(model, ["suspension.damper.port.effort"]).outputs
    assert "\noutputs:\n  damper.force = suspension.damping*(wheel.velocity - body.velocity)" in state_equations(
        model, ["suspension.damper.port.effort"]
    ).text().replace("suspension.damper", "damper")
    assert output.unit == "N"


def test_an_unknown_output_is_refused_with_the_nearest():
    with pytest.raises(ModelError, match=r"did you mean 'suspension\.damper\.port\.effort'"):
        state_equations(compiled(textbooks.QuarterCar()), ["suspension.damper.port.efort"])


class Divider(Component):
    """Two resistors on a source: no states at all."""

    voltage = Input("V")
    source = VoltageSource()
    upper = Resistor(resistance=1.0)
    lower = Resistor(resistance=2.0)
    ground = Ground()

    connections = (
        connect(voltage, source.voltage),
        connect(source.pin, upper.a),
        connect(upper.b, lower.a),
        connect(lower.b, ground.pin),
    )


def test_a_model_without_states_shows_what_its_elements_answer():
    text = state_equations(compiled(Divider())).text()
    assert text.splitlines()[:2] == ["divider: 0 states", "inputs: voltage [V]"]
    assert "upper.resistance*voltage/(upper.resistance + lower.resistance)" in text
    assert "= voltage/(upper.resistance + lower.resistance)" in text
