"""Linear models as matrices of symbols."""

from __future__ import annotations

import pytest
import sympy

from propermodel.compiler import compile_model
from propermodel.diagnostics import StructureError
from propermodel.equations.matrices import SymbolicMatrices, symbolic_matrices
from propermodel.equations.readable import state_equations
from propermodel.library.mechanics.translation import Mass, QuadraticDrag
from propermodel.modelling import Component, connect, elaborate
from tests import textbooks

LINEAR = [
    textbooks.SeriesCircuit,
    textbooks.Motor,
    textbooks.GearedInertias,
    textbooks.WheatstoneBridge,
    textbooks.QuarterCar,
    textbooks.Cylinder,
]


def matrices_of(component: Component) -> SymbolicMatrices:
    return symbolic_matrices(compile_model(elaborate(component)))


def test_the_motor_as_matrices():
    assert (
        matrices_of(textbooks.Motor()).text()
        == """\
motor: x' = A x + B u
x = coil.current, rotor.angular_velocity
u = voltage, torque

A = [ -motor.resistance/motor.inductance  -motor.constant/motor.inductance ]
    [    motor.constant/motor.inertia      -motor.friction/motor.inertia   ]

B = [ 1/motor.inductance         0        ]
    [         0           1/motor.inertia ]"""
    )


def test_the_motor_in_latex():
    written = matrices_of(textbooks.Motor()).latex()
    assert written.splitlines()[0] == (
        r"\frac{\mathrm{d}}{\mathrm{d}t} \begin{bmatrix} i_{\mathrm{coil}} \\ \omega_{\mathrm{rotor}} \end{bmatrix}"
    )
    row = r"-\frac{R_{\mathrm{motor}}}{L_{\mathrm{motor}}} & -\frac{K_{\mathrm{motor}}}{L_{\mathrm{motor}}} \\"
    assert row in written
    assert written.count("{") == written.count("}")


@pytest.mark.parametrize("component", LINEAR, ids=lambda component: component.__name__)
def test_the_matrices_are_the_jacobians_of_sympy(component: type[Component]):
    compiled = compile_model(elaborate(component()))
    found = symbolic_matrices(compiled)
    oracle = state_equations(compiled).to_sympy()
    rates = sympy.Matrix(list(oracle.rates.values()))
    for entries, wrt in ((found.a, oracle.states), (found.b, oracle.inputs)):
        jacobian = rates.jacobian(wrt)
        for row in range(len(found.states)):
            for column in range(len(wrt)):
                entry = entries.get((row, column))
                ours = sympy.Integer(0) if entry is None else _to_sympy(str_of(found, entry), oracle.symbols)
                assert sympy.simplify(ours - jacobian[row, column]) == 0


def str_of(found: SymbolicMatrices, entry: object) -> str:
    """An entry as text that SymPy can read."""
    from propermodel.equations.notation import TEXT
    from propermodel.expressions.core import Expr

    assert isinstance(entry, Expr)
    names = {leaf: str(name).replace(".", "__") for leaf, name in found.names.items()}
    return TEXT.formula(entry, names).replace("^", "**")


def _to_sympy(text: str, symbols: object) -> sympy.Expr:
    assert isinstance(symbols, dict)
    known = {str(name).replace(".", "__"): symbol for name, symbol in symbols.items()}
    return sympy.sympify(text, locals=known)


def test_large_matrices_list_what_is_not_zero():
    found = matrices_of(textbooks.section_chain(200))
    lines = found.text().splitlines()
    assert len(found.a) == len([line for line in lines if line.startswith("A[")])
    assert len(found.a) <= 7 * 200
    assert "A[1, 2] = -1" in lines


class Dragged(Component):
    """A mass against a drag that grows with the square of speed."""

    body = Mass(mass=1.0)
    air = QuadraticDrag(drag_area=1.0)
    connections = (connect(body.flange, air.flange),)


def test_what_is_not_linear_is_named():
    with pytest.raises(StructureError) as caught:
        matrices_of(Dragged())
    (fault,) = caught.value.diagnostics
    assert fault.code == "equations/nonlinear"
    assert fault.message == "the rate of body.velocity is not linear with constant coefficients"
    assert fault.involved[0].path == "body.velocity"
