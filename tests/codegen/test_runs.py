"""The loop: instants, pauses, statuses, lanes that fail."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Machine, Memory, Method, Outcome, Request, Status
from propermodel.diagnostics import SimulationError
from propermodel.expressions.core import TIME
from tests.codegen.programs import Draft, blow_up, implicit, oscillator, unsolvable

BACKENDS = pytest.mark.parametrize("backend", Backend)


def everything(draft: Draft, until: float, **changes: object) -> Request:
    request = Request(until=until, step=1e-3, row_period=0.01, integral_period=0.03, selected=np.arange(draft.signals))
    return replace(request, **changes)  # type: ignore[arg-type]


def two_rates() -> Draft:
    """Two controllers that count, the second reading the first; their periods meet every 0.06 s."""
    draft = Draft()
    first_period, second_period = draft.parameter("first", 0.02), draft.parameter("second", 0.03)
    x = draft.state("x")
    first, second, seen = draft.discrete("n"), draft.discrete("m"), draft.discrete("seen")
    draft.rate(x, first + 0.0 * x)
    draft.sample(first_period, {first: first + 1.0})
    draft.sample(second_period, {second: second + 1.0, seen: first})
    for signal in (first, second, seen, TIME):
        draft.signal(signal)
    return draft


@BACKENDS
def test_controllers_are_applied_by_rate_at_their_instants_and_before_the_rows(backend: Backend) -> None:
    draft = two_rates()
    memory = draft.memory()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    outcome = machine.run(memory, everything(draft, 0.12))
    expected = [[k // 2 + 1, k // 3 + 1, (k // 3 * 3) // 2 + 1] for k in range(13)]
    np.testing.assert_array_equal(outcome.rows[:, :3], expected)
    np.testing.assert_allclose(outcome.row_times, np.arange(13) * 0.01, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(outcome.rows[:, 3], outcome.row_times)
    np.testing.assert_allclose(outcome.integral_times, np.arange(5) * 0.03, rtol=0, atol=1e-15)
    assert memory.samples_taken.tolist() == [7, 5]
    assert outcome.status is Status.FINISHED
    # Instants of 0.01 s are one tick, however the products of their periods are rounded: ten steps each.
    assert memory.steps_taken == 120


@BACKENDS
def test_steps_are_cut_evenly_so_that_instants_are_met(backend: Backend) -> None:
    draft = oscillator()
    memory = draft.memory()
    build_machine(draft.program(), Method.EULER, backend=backend).run(memory, Request(until=0.05, step=0.015))
    assert memory.steps_taken == 4  # 0.05 s in steps of at most 0.015 s
    assert memory.time == 0.05


@BACKENDS
def test_an_origin_moves_every_instant(backend: Backend) -> None:
    draft = two_rates()
    memory = draft.memory(origin=100.0)
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    outcome = machine.run(memory, everything(draft, 100.06))
    np.testing.assert_allclose(outcome.row_times, 100.0 + np.arange(7) * 0.01, rtol=1e-15)
    assert memory.samples_taken.tolist() == [4, 3]


@BACKENDS
def test_an_infinite_period_records_the_origin_only(backend: Backend) -> None:
    draft = two_rates()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    memory = draft.memory()
    outcome = machine.run(memory, everything(draft, 0.1, row_period=math.inf, integral_period=math.inf))
    assert outcome.row_times.tolist() == [0.0]
    assert outcome.integral_times.tolist() == [0.0]
    assert machine.run(memory, everything(draft, 0.2, row_period=math.inf)).row_times.tolist() == []


def in_pieces(machine: Machine, memory: Memory, draft: Draft, until: float, **changes: object) -> list[Outcome]:
    outcomes = [machine.run(memory, everything(draft, until, **changes))]
    while outcomes[-1].status is Status.PAUSED:
        outcomes.append(machine.run(memory, everything(draft, until, **changes)))
    return outcomes


@pytest.mark.parametrize("changes", [{"most_rows": 3}, {"most_ticks": 2}, {"most_rows": 1, "most_ticks": 1}])
@pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
@BACKENDS
def test_a_run_in_pieces_has_the_bits_of_one_go(backend: Backend, method: Method, changes: dict[str, int]) -> None:
    for draft in (oscillator(), implicit(2), two_rates()):
        machine = build_machine(draft.program(), method, backend=backend)
        whole, parts = draft.memory(), draft.memory()
        expected = machine.run(whole, everything(draft, 0.12))
        outcomes = in_pieces(machine, parts, draft, 0.12, **changes)
        assert len(outcomes) > 3
        assert all(outcome.index == -1 for outcome in outcomes)
        for name in ("rows", "row_times", "integrals", "activities", "integral_times"):
            found = np.concatenate([getattr(outcome, name) for outcome in outcomes])
            np.testing.assert_array_equal(found, getattr(expected, name))
        np.testing.assert_array_equal(parts.state, whole.state)
        assert parts.steps_taken == whole.steps_taken


@BACKENDS
def test_a_copy_continues_on_its_own(backend: Backend) -> None:
    draft = oscillator()
    machine = build_machine(draft.program(), Method.RK4, backend=backend)
    memory = draft.memory()
    machine.run(memory, everything(draft, 0.1))
    copy = memory.copy()
    first = machine.run(memory, everything(draft, 0.2))
    second = machine.run(copy, everything(draft, 0.2))
    np.testing.assert_array_equal(first.rows, second.rows)
    assert first.row_times[0] == pytest.approx(0.11)


def test_rows_do_not_change_where_the_next_iteration_starts() -> None:
    draft = implicit(3)
    machine = build_machine(draft.program(), Method.RK4)
    often, never = draft.memory(), draft.memory()
    machine.run(often, everything(draft, 0.1, row_period=1e-3, step=5e-4))
    machine.run(never, everything(draft, 0.1, row_period=math.inf, integral_period=1e-3, step=5e-4))
    np.testing.assert_array_equal(often.state, never.state)


@pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
@BACKENDS
def test_a_state_that_is_not_finite_is_named_with_its_time(backend: Backend, method: Method) -> None:
    draft = blow_up()
    memory = draft.memory()
    outcome = build_machine(draft.program(), method, backend=backend).run(memory, everything(draft, 5.0))
    if method.is_adaptive:
        # It does not get past the pole, but tells where that is, and before numbers are infinite.
        assert (outcome.status, outcome.index) == (Status.STEP_TOO_SMALL, 1)
        assert outcome.time == pytest.approx(0.5, abs=1e-4)
        return
    assert (outcome.status, outcome.index) == (Status.NOT_FINITE, 1)
    # Past the pole at 0.5 an implicit step grows by a bounded factor, so the largest number is reached later.
    assert 0.5 < outcome.time < (3.0 if method is Method.ROS2 else 0.6)
    assert outcome.time == memory.time
    assert outcome.failures[0].time == outcome.time
    assert len(outcome.row_times) == round(outcome.time / 0.01)


@BACKENDS
def test_a_long_tick_is_left_soon_after_it_has_failed(backend: Backend) -> None:
    draft = blow_up()
    memory = draft.memory()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    outcome = machine.run(memory, Request(until=1000.0, step=1e-3))
    assert outcome.status is Status.NOT_FINITE
    assert memory.steps_taken == 768  # the third look, 256 steps apart
    assert outcome.time == pytest.approx(0.768)


@BACKENDS
def test_a_state_outside_its_limits_is_named_with_its_time(backend: Backend) -> None:
    draft = blow_up()
    memory = draft.memory()
    memory.upper[1] = 4.0
    machine = build_machine(draft.program(), Method.RK4, backend=backend)
    outcome = machine.run(memory, everything(draft, 5.0))
    assert (outcome.status, outcome.index) == (Status.OUT_OF_RANGE, 1)
    # 2 / (1 - 2 t) reaches 4 at 0.25 s; the check comes with the next instant.
    assert outcome.time == pytest.approx(0.26)


@pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
@BACKENDS
def test_an_implicit_block_without_solution_is_named_with_its_time(backend: Backend, method: Method) -> None:
    draft = unsolvable()
    memory = draft.memory()
    request = everything(draft, 5.0, step=1e-2 if method.is_adaptive else 1e-3)
    outcome = build_machine(draft.program(), method, backend=backend).run(memory, request)
    assert (outcome.status, outcome.index) == (Status.NOT_CONVERGED, 1)
    assert outcome.time == pytest.approx(0.5, abs=1.1e-3)


def test_both_backends_name_the_same_failure() -> None:
    draft = unsolvable()
    outcomes = [
        build_machine(draft.program(), Method.RK4, backend=backend).run(draft.memory(), everything(draft, 5.0))
        for backend in Backend
    ]
    assert outcomes[0].failures == outcomes[1].failures
    assert outcomes[0].time == outcomes[1].time


@BACKENDS
def test_an_evaluation_without_solution_raises(backend: Backend) -> None:
    draft = unsolvable()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    with pytest.raises(SimulationError, match="the implicit block of u has no solution at 3 s"):
        machine.rates(draft.memory(origin=3.0))


@BACKENDS
def test_lanes_fail_one_by_one_and_the_others_go_on(backend: Backend) -> None:
    draft = blow_up()
    machine = build_machine(draft.program(), Method.RK4, 4, backend)
    memory = draft.memory(4)
    memory.parameter[0] = [1.0, 0.0, -1.0, 2.0]
    outcome = machine.run(memory, everything(draft, 1.0))
    assert outcome.status is Status.FINISHED
    assert [(failure.lane, failure.status, failure.index) for failure in outcome.failures] == [
        (3, Status.NOT_FINITE, 1),
        (0, Status.NOT_FINITE, 1),
    ]
    assert memory.alive.tolist() == [False, True, True, False]
    alone = draft.memory()
    alone.parameter[0] = -1.0
    build_machine(draft.program(), Method.RK4, 1, backend).run(alone, everything(draft, 1.0))
    np.testing.assert_array_equal(memory.state[:, 2], alone.state)
    memory.parameter[0] = 1.0
    outcome = machine.run(memory, everything(draft, 3.0))
    assert outcome.status is Status.NOT_FINITE
    assert {failure.lane for failure in outcome.failures} == {1, 2}
    with pytest.raises(ValueError, match="every lane of this memory has failed"):
        machine.run(memory, everything(draft, 4.0))


@BACKENDS
def test_implicit_blocks_fail_lane_by_lane_too(backend: Backend) -> None:
    draft = unsolvable()
    machine = build_machine(draft.program(), Method.EULER, 2, backend)
    memory = draft.memory(2)
    memory.parameter[0] = [0.2, 9.0]
    outcome = machine.run(memory, everything(draft, 0.5))
    assert outcome.status is Status.FINISHED
    assert [(failure.lane, failure.index) for failure in outcome.failures] == [(0, 1)]
    assert outcome.failures[0].time == pytest.approx(0.2, abs=1.1e-3)
    memory.parameter[0] = 0.6
    assert machine.run(memory, everything(draft, 1.0)).status is Status.NOT_CONVERGED


def test_threads_may_share_a_machine() -> None:
    draft = oscillator()
    machine = build_machine(draft.program(), Method.RK4)
    memories = [draft.memory() for _ in range(8)]
    for k, memory in enumerate(memories):
        memory.state[0] = 0.1 * k
    alone = [memory.copy() for memory in memories]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda memory: machine.run(memory, everything(draft, 2.0)), memories))
    for memory, expected in zip(memories, alone, strict=True):
        machine.run(expected, everything(draft, 2.0))
        np.testing.assert_array_equal(memory.state, expected.state)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"step": 0.0}, "the step is 0.0 s; it must be positive"),
        ({"until": math.inf}, "the end is inf s; it cannot be reached"),
        ({"row_period": 0.0}, "the periods of rows must be positive"),
        ({"most_rows": 0}, "most_rows and most_ticks must be at least 1"),
        ({"selected": np.array([99])}, "selected signals must be between 0 and 5"),
    ],
)
@BACKENDS
def test_requests_are_checked(backend: Backend, changes: dict[str, object], message: str) -> None:
    draft = oscillator()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    with pytest.raises(ValueError, match=message):
        machine.run(draft.memory(), replace(everything(draft, 1.0), **changes))  # type: ignore[arg-type]


@BACKENDS
def test_memories_are_checked(backend: Backend) -> None:
    draft = oscillator()
    machine = build_machine(draft.program(), Method.EULER, 2, backend)
    with pytest.raises(ValueError, match=r"memory\.state is float64 of shape \(2,\), expected float64 \(2, 2\)"):
        machine.run(draft.memory(), everything(draft, 1.0))
    memory = draft.memory(2)
    memory.parameter[3] = [0.1, 0.2]
    with pytest.raises(ValueError, match="differs between lanes"):
        machine.run(memory, everything(draft, 1.0))
    memory.parameter[3] = 0.0
    with pytest.raises(ValueError, match=r"the sample period in parameter 3 is 0\.0; it must be positive"):
        machine.run(memory, everything(draft, 1.0))
    with pytest.raises(ValueError, match="at least one lane"):
        build_machine(draft.program(), Method.EULER, 0)
