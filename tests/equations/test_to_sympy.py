"""What SymPy makes of readable equations."""

from __future__ import annotations

import pytest
import sympy

from propermodel.compiler import compile_model
from propermodel.equations.readable import state_equations
from propermodel.equations.to_sympy import SymPyEquations
from propermodel.expressions import Expr, tanh, where
from propermodel.library.mechanics.translation import Fixed, Mass
from propermodel.modelling import Component, Parameter, Port, Resistance, Translation, connect, elaborate, parameter
from propermodel.modelling.tables import table
from tests import textbooks


def equations_of(component: Component) -> SymPyEquations:
    return state_equations(compile_model(elaborate(component))).to_sympy()


def test_the_natural_frequency_of_a_series_circuit():
    circuit = equations_of(textbooks.SeriesCircuit())
    r, inductance, c = (
        circuit.symbols[name] for name in ("resistor.resistance", "coil.inductance", "capacitor.capacitance")
    )
    jacobian = sympy.Matrix(list(circuit.rates.values())).jacobian(circuit.states)
    s = sympy.Symbol("s")
    polynomial = jacobian.charpoly(s).as_expr()
    assert sympy.simplify(polynomial - (s**2 + r / inductance * s + 1 / (inductance * c))) == 0


def test_the_bridge_against_superposition():
    """The galvanometer sees the difference of two voltage dividers behind two pairs of parallel resistors."""
    bridge = equations_of(textbooks.WheatstoneBridge())
    ul, ur, ll, lr = (
        bridge.symbols[f"{name}.resistance"] for name in ("upper_left", "upper_right", "lower_left", "lower_right")
    )
    voltage, current = bridge.inputs[0], bridge.states[0]
    open_voltage = voltage * (ll / (ul + ll) - lr / (ur + lr))
    inner = ul * ll / (ul + ll) + ur * lr / (ur + lr)
    expected = (open_voltage - inner * current) / bridge.symbols["galvanometer.inductance"]
    assert sympy.simplify(bridge.rates[current] - expected) == 0


def test_geared_inertias_move_as_one():
    geared = equations_of(textbooks.GearedInertias())
    names = ("pinion.inertia", "wheel.inertia", "gear.ratio", "bearing.damping", "torque")
    pinion, wheel, ratio, damping, torque = (geared.symbols[name] for name in names)
    (speed,) = geared.states
    expected = (torque - damping / ratio**2 * speed) / (pinion + wheel / ratio**2)
    assert sympy.simplify(geared.rates[speed] - expected) == 0


class Kinked(Resistance):
    """A law with a branch, a smooth step and a table."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    force: Parameter = parameter("N")
    width: Parameter = parameter("m/s")
    curve = table("N", ("m/s",), [[0.0, 1.0]], [0.0, 5.0])

    def effort(self, flow: Expr) -> Expr:
        return where(flow > 0.0, self.force * tanh(flow / self.width), self.curve(flow))


class Braked(Component):
    """A mass that such a law brakes."""

    mass = Mass(mass=2.0)
    brake = Kinked(force=3.0, width=0.1)
    frame = Fixed()
    connections = (connect(mass.flange, brake.a), connect(brake.b, frame.flange))


def test_branches_and_tables():
    braked = equations_of(Braked())
    (speed,) = braked.states
    force, width, mass = (braked.symbols[name] for name in ("brake.force", "brake.width", "mass.mass"))
    curve = sympy.Function("brake.curve")
    law = sympy.Piecewise((force * sympy.tanh(speed / width), speed > 0), (curve(speed), True))
    assert sympy.simplify(braked.rates[speed] + law / mass) == 0


@pytest.mark.parametrize("number", [3])
def test_a_chain_has_the_matrix_of_a_chain(number: int):
    chain = equations_of(textbooks.section_chain(number))
    jacobian = sympy.Matrix(list(chain.rates.values())).jacobian(chain.states)
    assert jacobian.shape == (2 * number, 2 * number)
    place = {str(state): index for index, state in enumerate(chain.states)}
    k, m = chain.symbols["sections[1].coupling.stiffness"], chain.symbols["sections[0].mass.mass"]
    row = place["sections[0].mass.velocity"]
    assert sympy.simplify(jacobian[row, place["sections[1].coupling.spring.displacement"]] + k / m) == 0
