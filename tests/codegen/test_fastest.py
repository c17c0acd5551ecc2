"""The watch over the fastest mode of a run."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.fastest import LONGEST, LOOK_EVERY, fastest_at
from propermodel.codegen.machine import Memory, Method, Request, Status
from propermodel.expressions.core import TIME, where
from tests.codegen.programs import Draft, implicit, oscillator, unsolvable

BACKENDS = pytest.mark.parametrize("backend", Backend)
METHODS = pytest.mark.parametrize("method", list(LONGEST))


def decays(*rates: float, coupling: float = 0.0) -> Draft:
    """States of very different sizes that decay at these rates; each also feels the one before it."""
    draft = Draft()
    states = [draft.state(f"x{i}", 10.0 ** (3 * i - 4)) for i in range(len(rates))]
    for i, (state, rate) in enumerate(zip(states, rates, strict=True)):
        fed = coupling * 1e3 * states[i - 1] if i else 0.0 * state
        draft.rate(state, fed - rate * state + 0.0 * TIME)
        draft.power(state)
    return draft


def watched(draft: Draft, method: Method, backend: Backend, step: float, until: float) -> Memory:
    memory = draft.memory()
    request = Request(until=until, step=step, integral_period=1.0, is_watched=True)
    assert build_machine(draft.program(), method, backend=backend).run(memory, request).status is Status.FINISHED
    return memory


@METHODS
@BACKENDS
@pytest.mark.parametrize("coupling", [0.0, 2.0])
def test_a_run_knows_its_fastest_decay(backend: Backend, method: Method, coupling: float) -> None:
    draft = decays(3.0, 40.0, 0.5, coupling=coupling)
    assert watched(draft, method, backend, 1e-3, 8.0).fastest == pytest.approx(40.0, rel=1e-3)


@METHODS
def test_an_oscillation_is_as_fast_as_its_frequency(method: Method) -> None:
    memory = watched(oscillator(driven=False), method, Backend.NATIVE, 1e-3, 20.0)
    assert memory.fastest == pytest.approx(5.0, rel=0.3)
    machine = build_machine(oscillator(driven=False).program(), method)
    found = fastest_at(machine, memory)
    assert found is not None
    assert found[0] == pytest.approx(5.0, rel=0.02)


@METHODS
def test_both_backends_see_the_same(method: Method) -> None:
    for draft in (decays(3.0, 40.0, coupling=1.0), implicit(2)):
        native, interpreted = (watched(draft, method, backend, 1e-3, 0.3) for backend in Backend)
        assert native.fastest == pytest.approx(interpreted.fastest, rel=1e-6)
        np.testing.assert_allclose(native.direction, interpreted.direction, rtol=1e-5, atol=1e-6)
        assert native.next_look == interpreted.next_look


@METHODS
@BACKENDS
def test_watching_changes_nothing(backend: Backend, method: Method) -> None:
    for draft in (oscillator(), implicit(2)):
        machine = build_machine(draft.program(), method, backend=backend)
        memories = [draft.memory() for _ in range(2)]
        for memory, is_watched in zip(memories, (True, False), strict=True):
            machine.run(memory, Request(until=0.3, step=1e-3, is_watched=is_watched))
        assert memories[0].fastest > 0.0 == memories[1].fastest
        for name in ("state", "unknown", "integral", "activity"):
            np.testing.assert_array_equal(getattr(memories[0], name), getattr(memories[1], name))


@METHODS
@BACKENDS
def test_a_run_pauses_where_a_mode_becomes_too_fast_for_its_steps(backend: Backend, method: Method) -> None:
    """Just beyond the limit of the method from 2 s on: numbers grow slowly, and would go on to the end."""
    draft, step = Draft(), 1e-3
    x = draft.state("x", 1.0)
    rate = 1.001 * LONGEST[method] / step
    draft.rate(x, -where(TIME > 2.0, rate, 10.0) * x)
    machine = build_machine(draft.program(), method, backend=backend)
    memory = draft.memory()
    request = Request(until=20.0, step=step, integral_period=0.1, is_watched=True)
    assert machine.run(memory, request).status is Status.PAUSED
    assert 2.0 < memory.time < 2.0 + 20 * LOOK_EVERY * step
    assert memory.fastest == pytest.approx(rate, rel=1e-3)
    assert abs(memory.state[0]) < 1.0
    # Going on gives the bits of a run that has not paused.
    straight, until = draft.memory(), memory.time + 0.2
    for paused in (memory, straight):
        assert machine.run(paused, Request(until=until, step=step, integral_period=0.1)).status is Status.FINISHED
    np.testing.assert_array_equal(memory.state, straight.state)


@BACKENDS
def test_equations_without_a_solution_beside_the_run_do_not_end_it(backend: Backend) -> None:
    draft = Draft()
    x, u = draft.state("x", 1.0), draft.unknown("u", 1.0)
    gap = where(x > 1.0, -1.0, 1.0)  # no root as soon as the state is nudged upwards
    draft.rates.append(draft.solve([u], [u * u - gap]))
    draft.rate(x, 0.0 * u)
    memory = watched(draft, Method.EULER, backend, 1e-3, 1.0)
    assert memory.fastest == 0.0
    assert memory.alive.all()
    assert fastest_at(build_machine(draft.program(), Method.EULER, backend=backend), memory) is None


@BACKENDS
def test_a_run_that_fails_says_so_also_when_watched(backend: Backend) -> None:
    draft = unsolvable()
    memory = draft.memory()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    outcome = machine.run(memory, Request(until=10.0, step=1e-3, is_watched=True))
    assert outcome.status is Status.NOT_CONVERGED
    assert math.isfinite(outcome.time)
