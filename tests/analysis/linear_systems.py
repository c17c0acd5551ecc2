"""Small linear systems with known modes and responses."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from propermodel.analysis.linear_model import ElementVariables, LinearModel, OperatingPoint
from propermodel.analysis.linearise import linearise
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import Backend, compile_model
from propermodel.diagnostics import Path
from propermodel.modelling import Component, Scenario, connect, elaborate
from tests.parts import Capacitor, Coil, Damper, Fixed, Force, Ground, Mass, Resistor, Spring, Voltage
from tests.physics.systems import system

L, C, R = 2e-3, 5e-6, 3.0


def linear(component: Component, **chosen: list[str]) -> LinearModel:
    compiled = compile_model(elaborate(component), backend=Backend.INTERPRETED)
    return linearise(compiled, Scenario(), **chosen)  # pyright: ignore[reportArgumentType]


def of_matrices(A: FloatArray, B: FloatArray, C: FloatArray) -> LinearModel:
    """A linear model of these matrices, of no particular machine."""
    count, inputs, outputs = len(A), B.shape[1], len(C)

    def named(letter: str, size: int) -> tuple[Path, ...]:
        return tuple(Path((f"{letter}{index}",)) for index in range(size))

    return LinearModel(
        name="matrices",
        states=named("x", count),
        state_units=("1",) * count,
        inputs=named("u", inputs),
        input_units=("1",) * inputs,
        outputs=named("y", outputs),
        output_units=("1",) * outputs,
        A=A,
        B=B,
        C=C,
        D=np.zeros((outputs, inputs)),
        B_rate=np.zeros((count, inputs)),
        D_rate=np.zeros((outputs, inputs)),
        point=OperatingPoint(
            description="nowhere",
            time=0.0,
            states=np.zeros(count),
            inputs=np.zeros(inputs),
            outputs=np.zeros(outputs),
            rates=np.zeros(count),
        ),
        elements=ElementVariables(paths=(), is_storage=(), efforts=csr_array((0, count)), others=csr_array((0, count))),
    )


def lags(rates: FloatArray) -> LinearModel:
    """First-order lags in a row: y = product of rate / (s + rate) u."""
    count = len(rates)
    A = np.diag(-rates) + np.diag(rates[1:], -1)
    return of_matrices(A, rates[:1, np.newaxis] * np.eye(count, 1), np.eye(1, count, count - 1))


def circuit(resistance: float = R) -> Component:
    """A voltage on a coil, a resistor and a capacitor in series."""
    supply, coil = Voltage(voltage=1.0), Coil(inductance=L)
    resistor, capacitor, ground = Resistor(resistance=resistance), Capacitor(capacitance=C), Ground()
    return system(
        connect(supply.a, coil.a),
        connect(coil.b, resistor.a),
        connect(resistor.b, capacitor.a),
        connect(capacitor.b, supply.b, ground.pin),
        supply=supply,
        coil=coil,
        resistor=resistor,
        capacitor=capacitor,
        ground=ground,
    )


def free_mass() -> Component:
    """A force on a mass and nothing else."""
    mass, push = Mass(mass=2.0), Force(force=1.0)
    return system(connect(mass.flange, push.flange), mass=mass, push=push)


def two_masses(damping: float = 0.0) -> Component:
    """Two equal masses between walls on three equal springs; a damper joins the masses."""
    one, two, push, wall = Mass(mass=2.0), Mass(mass=2.0), Force(force=1.0), Fixed()
    left, middle, right = Spring(stiffness=50.0), Spring(stiffness=50.0), Spring(stiffness=50.0)
    damper = Damper(damping=damping)
    return system(
        connect(wall.flange, left.a, right.b),
        connect(left.b, middle.a, damper.a, one.flange, push.flange),
        connect(middle.b, damper.b, right.a, two.flange),
        one=one, two=two, push=push, wall=wall, left=left, middle=middle, right=right, damper=damper,
    )  # fmt: skip


def free_pair() -> Component:
    """Two masses joined by a spring and a damper, free in space."""
    one, two, push = Mass(mass=1.0), Mass(mass=3.0), Force(force=1.0)
    spring, damper = Spring(stiffness=30.0), Damper(damping=0.6)
    return system(
        connect(one.flange, push.flange, spring.a, damper.a),
        connect(two.flange, spring.b, damper.b),
        one=one, two=two, push=push, spring=spring, damper=damper,
    )  # fmt: skip
