"""Least and greatest values of signals between two rows, found after every step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Memory, Method, Outcome, Request, Status
from propermodel.expressions.core import TIME, where
from tests.codegen.programs import Draft, implicit, oscillator

BACKENDS = pytest.mark.parametrize("backend", Backend)
METHODS = pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
FIXED = pytest.mark.parametrize(
    "method", [method for method in Method if method.is_generated and not method.is_adaptive]
)
STEP = 1e-3


def asked(draft: Draft, until: float, **changes: object) -> Request:
    request = Request(until=until, step=STEP, row_period=0.05, selected=np.arange(draft.signals), has_extremes=True)
    return replace(request, **changes)  # type: ignore[arg-type]


def with_spike() -> Draft:
    """An oscillator, and a signal that is high after the step from 0.036 s to 0.037 s alone, and low after the next."""
    draft = oscillator()
    pulse = where(abs(TIME - 0.037) < 0.4 * STEP, 1.0, 0.0)
    draft.signal(pulse - where(abs(TIME - 0.038) < 0.4 * STEP, 2.0, 0.0))
    draft.signal(TIME)
    return draft


@FIXED
@BACKENDS
def test_a_spike_of_one_step_survives_coarse_rows(backend: Backend, method: Method) -> None:
    draft = with_spike()
    machine = build_machine(draft.program(), method, backend=backend)
    seen = machine.run(draft.memory(), asked(draft, 0.2))
    every = machine.run(draft.memory(), asked(draft, 0.2, row_period=STEP, has_extremes=False))
    assert seen.rows[:, -2].tolist() == [0.0] * 5
    assert seen.greatest[:, -2].tolist() == [0.0, 1.0, 0.0, 0.0, 0.0]
    assert seen.least[:, -2].tolist() == [0.0, -2.0, 0.0, 0.0, 0.0]
    for row in range(1, 5):
        between = every.rows[50 * (row - 1) : 50 * row + 1]
        np.testing.assert_allclose(seen.least[row], between.min(axis=0), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(seen.greatest[row], between.max(axis=0), rtol=1e-9, atol=1e-12)
    assert every.least.shape == (0, draft.signals)


@METHODS
def test_a_row_and_what_is_before_and_after_it_belong_to_both_intervals(method: Method) -> None:
    draft = with_spike()
    seen = build_machine(draft.program(), method).run(draft.memory(), asked(draft, 0.2))
    np.testing.assert_array_equal(seen.greatest[:, -1], seen.row_times)
    np.testing.assert_array_equal(seen.least[:, -1], [0.0, *seen.row_times[:-1]])


@METHODS
@pytest.mark.parametrize("draft", [with_spike(), implicit(2)], ids=["spike", "implicit"])
def test_looking_changes_nothing_and_both_backends_see_the_same(method: Method, draft: Draft) -> None:
    found: list[tuple[Memory, Outcome]] = []
    for backend, has_extremes in ((Backend.NATIVE, True), (Backend.NATIVE, False), (Backend.INTERPRETED, True)):
        memory = draft.memory()
        machine = build_machine(draft.program(), method, backend=backend)
        request = asked(draft, 0.2, has_extremes=has_extremes, jacobian_every=3, row_period=0.07)
        found.append((memory, machine.run(memory, request)))
    (watched, seen), (unwatched, unseen), (slow, oracle) = found
    np.testing.assert_array_equal(watched.state, unwatched.state)
    np.testing.assert_array_equal(watched.activity, unwatched.activity)
    np.testing.assert_array_equal(seen.rows, unseen.rows)
    assert watched.steps_taken == unwatched.steps_taken == slow.steps_taken
    for name in ("least", "greatest"):
        # Residuals of implicit blocks are zero up to the rounding of their functions.
        np.testing.assert_allclose(getattr(seen, name), getattr(oracle, name), rtol=1e-13, atol=1e-15)
        since_last_row = getattr(watched, name), getattr(slow, name)
        np.testing.assert_allclose(*since_last_row, rtol=1e-13, atol=1e-15)


@METHODS
@BACKENDS
def test_both_sides_of_a_jump_count(backend: Backend, method: Method) -> None:
    draft = Draft()
    period, x = draft.parameter("period", 0.02), draft.state("x")
    count = draft.discrete("count")
    draft.rate(x, 0.0 * x + 1.0)
    draft.sample(period, {count: count + 1.0})
    draft.signal(TIME - 0.02 * count)  # a saw tooth from -0.02 to 0, of which rows see the lower ends
    machine = build_machine(draft.program(), method, backend=backend)
    seen = machine.run(draft.memory(), asked(draft, 0.12, row_period=0.04))
    np.testing.assert_allclose(seen.rows[:, 0], -0.02, atol=1e-15)
    np.testing.assert_allclose(seen.least[:, 0], -0.02, atol=1e-15)
    np.testing.assert_allclose(seen.greatest[1:, 0], 0.0, atol=1e-15)


@FIXED
@pytest.mark.parametrize("backend", Backend)
def test_lanes_see_what_each_run_sees_alone(backend: Backend, method: Method) -> None:
    draft = with_spike()
    alone = build_machine(draft.program(), method, backend=backend)
    together = build_machine(draft.program(), method, 4, backend=backend)
    wide = draft.memory(lanes=4)
    wide.state *= np.linspace(0.5, 2.0, 4)
    singles = [draft.memory() for _ in range(4)]
    for lane, single in enumerate(singles):
        single.state[:] = wide.state[:, lane]
    seen = together.run(wide, asked(draft, 0.2))
    for lane, single in enumerate(singles):
        own = alone.run(single, asked(draft, 0.2))
        np.testing.assert_array_equal(seen.least[:, :, lane], own.least)
        np.testing.assert_array_equal(seen.greatest[:, :, lane], own.greatest)


@METHODS
@BACKENDS
def test_a_run_in_pieces_sees_what_it_sees_in_one_go(backend: Backend, method: Method) -> None:
    draft = with_spike()
    machine = build_machine(draft.program(), method, backend=backend)
    whole = machine.run(draft.memory(), asked(draft, 0.2, integral_period=0.01))
    memory, parts = draft.memory(), []
    while not parts or parts[-1].status is Status.PAUSED:
        parts.append(machine.run(memory, asked(draft, 0.2, integral_period=0.01, most_ticks=2, most_rows=2)))
    assert len(parts) > 5
    for name in ("rows", "least", "greatest"):
        np.testing.assert_array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(whole, name))


@BACKENDS
def test_numbers_that_are_none_are_passed_over(backend: Backend) -> None:
    draft = oscillator()
    draft.signal(where(TIME < 0.03, math.nan, 1.0) * TIME)
    seen = build_machine(draft.program(), Method.EULER, backend=backend).run(draft.memory(), asked(draft, 0.1))
    np.testing.assert_array_equal(np.isnan(seen.rows[:, -1]), [True, False, False])
    np.testing.assert_allclose(seen.least[1:, -1], [0.03, 0.05], atol=1.1 * STEP)
    np.testing.assert_allclose(seen.greatest[1:, -1], [0.05, 0.1], atol=1e-15)
