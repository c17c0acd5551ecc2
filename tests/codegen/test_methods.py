"""Orders of the methods on an oscillator, against the closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Method, Outcome, Request
from tests.codegen.programs import Draft, oscillator


def position_error(method: Method, step: float, backend: Backend = Backend.NATIVE) -> float:
    """The error of the undamped oscillator after one second, against q cos + v/w sin."""
    draft = oscillator(damping=0.0, driven=False)
    memory = draft.memory()
    build_machine(draft.program(), method, backend=backend).run(memory, Request(until=1.0, step=step))
    omega = math.sqrt(50.0 / 2.0)
    return abs(float(memory.state[0]) - (0.3 * math.cos(omega) + 0.5 / omega * math.sin(omega)))


ORDERS = [(Method.EULER, 1), (Method.SEMI_IMPLICIT, 1), (Method.RK4, 4), (Method.ROS2, 2)]


@pytest.mark.parametrize(("method", "order"), ORDERS)
def test_the_error_falls_with_the_order_of_the_method(method: Method, order: int) -> None:
    coarse, fine = position_error(method, 2e-3), position_error(method, 1e-3)
    assert math.log2(coarse / fine) == pytest.approx(order, abs=0.15)


def energy_run(method: Method) -> Outcome:
    draft = oscillator(damping=0.0, driven=False)
    machine = build_machine(draft.program(), method)
    energy = np.array([draft.signals - 1])
    return machine.run(draft.memory(), Request(until=200.0, step=5e-3, row_period=0.1, selected=energy))


def test_semi_implicit_euler_keeps_the_energy_bounded_and_euler_does_not() -> None:
    kept, grown = (energy_run(method).rows[:, 0] for method in (Method.SEMI_IMPLICIT, Method.EULER))
    assert np.ptp(kept) < 0.05 * kept[0]
    assert grown[-1] > 100.0 * grown[0]


@pytest.mark.parametrize("backend", Backend)
def test_integrals_of_power_are_those_of_the_quadrature(backend: Backend) -> None:
    # A clock as state: the power t has the integral t**2 / 2, which RK4 and ROS2 find and Euler misses by t h / 2.
    draft = Draft()
    clock = draft.state("clock", -1.0)
    draft.rate(clock, 1.0 + 0.0 * clock)
    draft.power(clock)
    found = {}
    for method in Method:
        memory = draft.memory()
        build_machine(draft.program(), method, backend=backend).run(memory, Request(until=2.0, step=0.25))
        found[method] = (float(memory.integral[0]), float(memory.activity[0]))
    assert found[Method.EULER] == (-0.25, 1.0)
    assert found[Method.SEMI_IMPLICIT] == (-0.25, 1.0)
    assert found[Method.RK4] == pytest.approx((0.0, 1.0), abs=1e-14)
    assert found[Method.ROS2] == pytest.approx((0.0, 1.0), abs=1e-14)


def test_a_derivative_that_is_a_state_is_read_before_the_step() -> None:
    # x' = v, v' = -x from (1, 0): Euler keeps v(1) = -h while x(1) = 1; updating in place would give x(1) = 1 - h**2.
    draft = Draft()
    v, x = draft.state("v", 0.0), draft.state("x", 1.0)
    draft.rate(v, -x)
    draft.rate(x, v)
    memory = draft.memory()
    build_machine(draft.program(), Method.EULER).run(memory, Request(until=0.5, step=0.5))
    assert memory.state.tolist() == [-0.5, 1.0]
