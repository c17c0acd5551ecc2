"""The linearly implicit method: order, stiffness, shared Jacobians, and what happens when it cannot go on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Method, Request, Status
from propermodel.codegen.rosenbrock import with_step_of
from propermodel.codegen.schedule import nodes_of
from propermodel.codegen.state_jacobian import state_jacobian
from propermodel.codegen.tableaus import ROS2
from propermodel.diagnostics import SimulationError
from propermodel.expressions import cos, sin
from propermodel.expressions.core import TIME
from tests.codegen.programs import Draft, chain, implicit, oscillator


def final(
    draft: Draft, until: float, step: float, jacobian_every: int = 1, backend: Backend = Backend.NATIVE
) -> list[float]:
    memory = draft.memory()
    machine = build_machine(draft.program(), Method.ROS2, backend=backend)
    outcome = machine.run(memory, Request(until=until, step=step, jacobian_every=jacobian_every))
    assert outcome.status is Status.FINISHED
    return [float(x) for x in memory.state]


def order(coarse: float, fine: float) -> float:
    return math.log2(coarse / fine)


def prothero_robinson(rate: float) -> Draft:
    """x' = rate (x - sin t) + cos t, whose solution from 0 is sin t."""
    draft = Draft()
    x = draft.state("x", 0.0)
    draft.rate(x, rate * (x - sin(TIME)) + cos(TIME))
    return draft


def van_der_pol(stiffness: float) -> Draft:
    draft = Draft()
    x, v = draft.state("x", 2.0), draft.state("v", 0.0)
    k = draft.parameter("k", stiffness)
    draft.rate(x, v)
    draft.rate(v, k * ((1.0 - x * x) * v - x))
    return draft


@pytest.mark.parametrize("rate", [-1.0, -100.0, -1e4, -1e6, -1e9])
def test_the_error_falls_with_the_square_of_the_step_however_stiff(rate: float) -> None:
    errors = [abs(final(prothero_robinson(rate), 1.0, h)[0] - math.sin(1.0)) for h in (0.02, 0.01, 0.005)]
    assert errors[0] < 1e-3
    # Between the two regimes, where rate * step is about 1, orders pass through higher ones.
    assert order(errors[1], errors[2]) > 1.8


def test_a_stiff_limit_cycle_is_that_of_radau() -> None:
    stiffness = 1e3

    def rates(_: float, x: np.ndarray) -> list[float]:
        return [x[1], stiffness * ((1.0 - x[0] ** 2) * x[1] - x[0])]

    reference = solve_ivp(rates, (0.0, 1.2), [2.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12, t_eval=(0.6, 1.2)).y[0]
    # Along the slow part, with steps longer than an explicit method may take, 2 / (3 * stiffness).
    slow = [abs(final(van_der_pol(stiffness), 0.6, h)[0] - reference[0]) for h in (4e-3, 2e-3)]
    assert slow[1] < 1e-5
    assert order(*slow) > 1.8
    # Past the jump, which only short steps resolve.
    past = [abs(final(van_der_pol(stiffness), 1.2, h)[0] - reference[1]) for h in (2.5e-4, 1.25e-4)]
    assert past[1] < 1e-3
    assert order(*past) > 1.8


def test_what_is_infinitely_stiff_is_gone_after_one_step() -> None:
    draft = Draft()
    x = draft.state("x", 1.0)
    draft.rate(x, -1e12 * x)
    assert abs(final(draft, 0.1, 0.1)[0]) < 1e-9


def test_what_depends_on_time_alone_is_integrated_with_the_third_order() -> None:
    def missed(step: float) -> float:
        draft = Draft()
        x = draft.state("x", 0.0)
        draft.rate(x, cos(TIME))
        return abs(final(draft, 1.0, step)[0] - math.sin(1.0))

    assert order(missed(0.02), missed(0.01)) == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("jacobian_every", [1, 3, 10])
def test_the_order_stays_with_an_old_jacobian(jacobian_every: int) -> None:
    def errors(step: float) -> float:
        return abs(final(van_der_pol(2.0), 1.0, step, jacobian_every)[0] - exact)

    exact = final(van_der_pol(2.0), 1.0, 2.5e-5)[0]
    assert order(errors(4e-3), errors(2e-3)) == pytest.approx(2.0, abs=0.2)


def test_a_jacobian_serves_as_often_as_asked() -> None:
    # With the Jacobian of the first step only, the result is that of stages written by hand.
    draft = van_der_pol(2.0)
    h, gamma = 0.01, ROS2.gamma
    x = np.array([2.0, 0.0])
    matrix: np.ndarray = np.eye(2) - gamma * h * np.array([[0.0, 1.0], [-2.0, -6.0]])

    def rates(x: np.ndarray) -> np.ndarray:
        return np.array([x[1], 2.0 * ((1.0 - x[0] ** 2) * x[1] - x[0])])

    for _ in range(5):
        k1 = np.linalg.solve(matrix, rates(x))
        k2 = np.linalg.solve(matrix, rates(x + 2.0 / 3.0 * h * k1) - 4.0 / 3.0 * k1)
        x = x + 1.25 * h * k1 + 0.75 * h * k2
    np.testing.assert_allclose(final(draft, 5 * h, h, 5), x, rtol=1e-12)
    assert final(draft, 5 * h, h, 4) != final(draft, 5 * h, h, 5)


@pytest.mark.parametrize("backend", Backend)
def test_integrals_of_power_have_the_order_of_the_method(backend: Backend) -> None:
    def errors(step: float) -> list[float]:
        draft = oscillator(damping=4.0, driven=False)
        memory = draft.memory()
        # Two instants besides the end, so that the quadrature is closed in between.
        request = Request(until=0.3, step=step, integral_period=0.1)
        build_machine(draft.program(), Method.ROS2, backend=backend).run(memory, request)
        q, p = memory.state
        stored = (25.0 * q * q + 0.25 * p * p) - (25.0 * 0.09 + 0.25)
        dissipated = float(memory.integral[1])
        return [abs(stored + dissipated), abs(float(memory.integral[0]) - 25.0 * (q * q - 0.09))]

    for coarse, fine in zip(errors(4e-3), errors(2e-3), strict=True):
        assert order(coarse, fine) > 1.8
        assert fine < 1e-4


@pytest.mark.parametrize("lanes", [2, 8])
def test_each_lane_has_the_bits_of_a_run_alone(lanes: int) -> None:
    for draft in (oscillator(), implicit(2)):
        program = draft.program()
        wide, alone = build_machine(program, Method.ROS2, lanes), build_machine(program, Method.ROS2)
        memory = draft.memory(lanes)
        memory.state *= 1.0 + 0.1 * np.arange(lanes)
        request = Request(until=0.2, step=5e-3, integral_period=0.1, jacobian_every=3)
        wide.run(memory, request)
        for lane in range(lanes):
            single = draft.memory()
            single.state *= 1.0 + 0.1 * lane
            alone.run(single, request)
            np.testing.assert_array_equal(memory.state[:, lane], single.state)
            np.testing.assert_array_equal(memory.activity[:, lane], single.activity)


@pytest.mark.parametrize("lanes", [1, 2])
@pytest.mark.parametrize("backend", Backend)
def test_singular_equations_end_a_run_by_name(backend: Backend, lanes: int) -> None:
    # 1 - gamma h rate vanishes for what grows as fast as the step is long.
    draft = Draft()
    calm, wild = draft.state("calm", 1.0), draft.state("wild", 2.0)
    rate = draft.parameter("rate", 1.0 / (ROS2.gamma * 0.125))
    draft.rate(calm, -calm)
    draft.rate(wild, rate * wild)
    memory = draft.memory(lanes)
    if lanes == 2:
        memory.parameter[0, 0] = 0.5
    machine = build_machine(draft.program(), Method.ROS2, lanes, backend)
    outcome = machine.run(memory, Request(until=1.0, step=0.125))
    failed = lanes - 1
    assert [(f.lane, f.status, f.index, f.time) for f in outcome.failures] == [(failed, Status.SINGULAR_STEP, 1, 0.0)]
    if lanes == 1:
        assert outcome.status is Status.SINGULAR_STEP
        assert memory.state.tolist() == [1.0, 2.0]
    else:
        assert memory.state[1, 0] == pytest.approx(2.0 * math.exp(0.5), rel=1e-3)


@pytest.mark.parametrize("size", [1, 2, 5])
def test_the_jacobian_passes_implicit_blocks(size: int) -> None:
    draft = implicit(size)
    found = state_jacobian(draft.program().rates, draft.program().layout)
    first = draft.signals
    draft.signal(found.entries[0, 0])
    draft.signal(found.drift[0])
    machine = build_machine(draft.program(), Method.EULER, backend=Backend.INTERPRETED)
    memory = draft.memory(origin=0.3)
    slopes = machine.observe(memory)[first:]

    def quotient(dx: float, dt: float) -> float:
        rates: list[float] = []
        for side in (1.0, -1.0):
            moved = memory.copy()
            moved.state += side * dx
            moved.time += side * dt
            rates.append(float(machine.rates(moved)[0][0]))
        return (rates[0] - rates[1]) / (2.0 * (dx + dt))

    np.testing.assert_allclose(slopes, [quotient(1e-6, 0.0), quotient(0.0, 1e-6)], rtol=1e-7)


def test_the_operations_of_a_step_grow_with_the_size_of_a_model() -> None:
    def operations(sections: int) -> int:
        step = with_step_of(chain(sections).program(), Method.ROS2).implicit_step
        assert step is not None
        return sum(1 for node in nodes_of(step.functions) if node.args)

    counts = [operations(sections) for sections in (20, 40, 80)]
    assert counts[2] - counts[1] == pytest.approx(2 * (counts[1] - counts[0]), rel=0.02)


def test_a_block_that_is_too_large_is_refused_by_name() -> None:
    with pytest.raises(SimulationError, match=r"derivatives of 25 unknowns that must be solved for together \(u0, u1"):
        build_machine(implicit(25).program(), Method.ROS2)
