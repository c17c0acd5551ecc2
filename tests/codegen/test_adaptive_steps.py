"""Methods that control their step: order, tolerance, stiffness, instants, the integrals of power, and giving up."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Machine, Memory, Method, Request, Status
from propermodel.expressions import cos, sin
from propermodel.expressions.core import TIME
from tests.codegen.programs import Draft, oscillator
from tests.codegen.test_rosenbrock import order, prothero_robinson, van_der_pol

ADAPTIVE = [method for method in Method if method.is_adaptive and method.is_generated]
ORDERS = {Method.RODAS: 4, Method.DOPRI5: 5}


def finished(draft: Draft, method: Method, backend: Backend = Backend.NATIVE, **asked: Any) -> Memory:
    memory = draft.memory()
    machine = build_machine(draft.program(), method, backend=backend)
    assert run_on(machine, memory, replace(Request(until=1.0, step=1.0), **asked))[-1] is Status.FINISHED
    return memory


def run_on(machine: Machine, memory: Memory, request: Request) -> list[Status]:
    """Run to the end over all pauses."""
    statuses = [machine.run(memory, request).status]
    while statuses[-1] is Status.PAUSED:
        statuses.append(machine.run(memory, request).status)
    return statuses


def forced(draft: Draft, method: Method, step: float) -> Memory:
    """A run in steps of one length, with a tolerance that refuses none."""
    memory = draft.memory()
    memory.next_step = step
    request = Request(until=1.0, step=step, tolerance=0.999)
    assert build_machine(draft.program(), method).run(memory, request).status is Status.FINISHED
    assert (memory.steps_taken, memory.steps_rejected) == (round(1.0 / step), 0)
    return memory


def driven() -> Draft:
    """A nonlinear system whose right-hand side depends on time, with a power that keeps its sign and one that does not.

    The second power is the derivative of x^2 / 2.
    """
    draft = Draft()
    x, v = draft.state("x", 1.0), draft.state("v", 0.5)
    slope = v * cos(TIME) + sin(2.0 * TIME)
    draft.rate(x, slope)
    draft.rate(v, -x * x * v - x + TIME * TIME)
    draft.power(1.0 + v * v)
    draft.power(x * slope)
    return draft


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_order_is_that_of_the_method_when_time_counts_too(method: Method) -> None:
    exact = finished(driven(), method, tolerance=1e-12).state
    coarse, fine = (float(np.abs(forced(driven(), method, h).state - exact).max()) for h in (0.1, 0.0125))
    assert order(coarse, fine) / 3.0 > ORDERS[method] - 0.3


@pytest.mark.parametrize("method", ADAPTIVE)
def test_integrals_of_power_are_of_order_four(method: Method) -> None:
    def errors(step: float) -> np.ndarray:
        memory = forced(driven(), method, step)
        (x, _), start = memory.state, 1.0
        return np.array([abs(memory.integral[1] - (x * x - start) / 2.0), abs(memory.activity[0] - exact)])

    exact = finished(driven(), method, tolerance=1e-12).activity[0]
    coarse, fine = errors(0.1), errors(0.05)
    assert np.all(np.log2(coarse / fine) > 3.5)
    assert np.all(fine < 1e-6)


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_absolute_value_of_power_is_integrated_between_its_zeros(backend: Backend, method: Method) -> None:
    draft = Draft()
    draft.rate(draft.state("x", 1.0), 0.0 * TIME)
    powers = (
        (TIME - 0.3, 0.5 * (0.3**2 + 0.7**2)),  # one zero
        ((TIME - 0.2) * (TIME - 0.9), 1 / 3 - 1.1 / 2 + 0.18 + 2.0 * 0.7**3 / 6.0),  # two
        ((TIME - 0.5) * (TIME - 0.5), 1 / 12),  # a double one
        (TIME * TIME + 1.0, 4 / 3),
        (-2.0 + 0.0 * TIME, 2.0),
        (0.0 * TIME, 0.0),
    )
    for power, _ in powers:
        draft.power(power)
    memory = finished(draft, method, backend)
    assert memory.steps_taken < 30
    np.testing.assert_allclose(memory.activity, [exact for _, exact in powers], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_error_follows_the_tolerance(method: Method) -> None:
    exact = finished(van_der_pol(3.0), method, until=8.0, tolerance=1e-11).state
    for tolerance in (1e-3, 1e-5, 1e-7):
        found = finished(van_der_pol(3.0), method, until=8.0, tolerance=tolerance)
        # Phase errors of a limit cycle add up over its turns.
        assert np.abs(found.state - exact).max() < 100.0 * tolerance
        assert found.steps_rejected < found.steps_taken


def test_stiffness_costs_no_steps() -> None:
    taken = [finished(prothero_robinson(rate), Method.RODAS, tolerance=1e-5) for rate in (-1.0, -1e3, -1e6, -1e9)]
    for memory in taken:
        assert abs(float(memory.state[0]) - math.sin(1.0)) < 1e-4
        assert memory.steps_taken < 60


def test_an_explicit_method_keeps_within_its_stable_steps() -> None:
    memory = finished(prothero_robinson(-1e4), Method.DOPRI5, tolerance=1e-4)
    assert abs(float(memory.state[0]) - math.sin(1.0)) < 1e-4
    # It is stable up to 3.3 / rate.
    assert 3000 < memory.steps_taken < 6000


@pytest.mark.parametrize("method", ADAPTIVE)
def test_both_backends_take_and_refuse_the_same_steps(method: Method) -> None:
    found = [
        finished(van_der_pol(5.0), method, backend, until=2.0, row_period=0.3, tolerance=1e-4) for backend in Backend
    ]
    first, second = found
    np.testing.assert_array_equal(first.state, second.state)
    assert first.steps_rejected > 0
    for name in ("steps_taken", "steps_rejected", "next_step", "last_error"):
        assert getattr(first, name) == getattr(second, name)


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_short_remainders_before_instants_do_not_shorten_later_steps(backend: Backend, method: Method) -> None:
    # Instants at multiples of 1 and of 1.001: remainders of some milliseconds, between them long ticks.
    draft = oscillator(damping=0.1, driven=False)
    even = finished(draft, method, backend, until=10.0, row_period=1.0, integral_period=1.0)
    uneven = finished(draft, method, backend, until=10.0, row_period=1.0, integral_period=1.001)
    assert uneven.steps_taken <= even.steps_taken + 22
    assert uneven.next_step > 0.5 * even.next_step


@pytest.mark.parametrize("rate", [1e-3, 1.0, 1e6])
def test_the_first_step_has_the_size_of_the_fastest_change(rate: float) -> None:
    draft = Draft()
    x = draft.state("x", 1e-6)
    draft.rate(x, -rate * x)
    memory = draft.memory()
    machine = build_machine(draft.program(), Method.DOPRI5)
    machine.run(memory, Request(until=1e-9 / rate, step=1e3))
    assert 1e-4 < memory.next_step * rate < 5.0


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_step_without_solution_is_taken_again_shorter(backend: Backend, method: Method) -> None:
    # x' = -z with z^2 = x, so x = (1 - t / 2)^2; too long a step leads to a negative x.
    draft = Draft()
    x = draft.state("x", 1.0)
    z = draft.unknown("z", 1.0)
    draft.rates.append(draft.solve([z], [z * z - x]))
    draft.rate(x, -z)
    memory = draft.memory()
    memory.next_step = 5.0
    outcome = build_machine(draft.program(), method, backend=backend).run(memory, Request(until=1.8, step=5.0))
    assert outcome.status is Status.FINISHED
    assert outcome.failures == ()
    assert memory.steps_rejected > 0
    assert float(memory.state[0]) == pytest.approx(0.01, abs=1e-3)


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_run_that_cannot_go_on_names_the_state_with_the_largest_error(backend: Backend, method: Method) -> None:
    draft = Draft()
    calm, wild = draft.state("calm", 1.0), draft.state("wild", 1.0)
    draft.rate(calm, -calm)
    draft.rate(wild, wild * wild)  # infinite at 1
    memory = draft.memory()
    outcome = build_machine(draft.program(), method, backend=backend).run(memory, Request(until=2.0, step=1.0))
    assert (outcome.status, outcome.index) == (Status.STEP_TOO_SMALL, 1)
    assert outcome.time == pytest.approx(1.0, abs=1e-3)
    assert float(memory.state[0]) == pytest.approx(math.exp(-outcome.time), rel=1e-3)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_very_long_tick_pauses_and_goes_on(method: Method) -> None:
    memory = prothero_robinson(-1e5).memory()
    machine = build_machine(prothero_robinson(-1e5).program(), method)
    statuses = run_on(machine, memory, Request(until=1.0, step=1.0, tolerance=1e-4))
    assert (len(statuses) > 3) is (method is Method.DOPRI5)
    assert abs(float(memory.state[0]) - math.sin(1.0)) < 1e-4
