"""Implicit blocks."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Method, Request, Status
from propermodel.codegen.schedule import Call, number_solves, sequence
from propermodel.expressions import absolute, atan2, exp, sign, sqrt, where
from propermodel.expressions.core import Expr
from tests.codegen.programs import Draft, implicit

BACKENDS = pytest.mark.parametrize("backend", Backend)


def linear(size: int) -> Draft:
    """As many linear equations, whose matrix needs exchanges of rows (its diagonal vanishes)."""
    draft = Draft()
    x = draft.state("x", 1.5)
    unknowns = [draft.unknown(f"u{i}") for i in range(size)]
    residuals = []
    for i in range(size):
        total: Expr = -(x + float(i))
        for j in range(size):
            if i != j:
                total = total + (1.0 + ((7 * i + 3 * j) % 5)) * unknowns[j]
        residuals.append(total)
    draft.rates.append(draft.solve(unknowns, residuals))
    draft.rate(x, unknowns[0])
    for unknown in unknowns:
        draft.power(unknown)
    return draft


@pytest.mark.parametrize("size", [2, 3, 5, 12, 13, 20])
@BACKENDS
def test_linear_blocks_of_any_size_are_solved(size: int, backend: Backend) -> None:
    draft = linear(size)
    matrix = np.array([[0.0 if i == j else 1.0 + ((7 * i + 3 * j) % 5) for j in range(size)] for i in range(size)])
    expected = np.linalg.solve(matrix, 1.5 + np.arange(size))
    _, powers = build_machine(draft.program(), Method.EULER, backend=backend).rates(draft.memory())
    np.testing.assert_allclose(powers, expected, rtol=1e-10)


def test_blocks_that_are_affine_are_recognised() -> None:
    for draft, is_affine in ((linear(3), True), (implicit(2), False)):
        program = draft.program()
        items = sequence(program.rates, number_solves(program), lambda _: False)
        assert [item.is_affine for item in items if isinstance(item, Call)] == [is_affine]


def scalar(residual: object, start: float = 0.0, x: float = 1.0) -> tuple[Draft, Expr, Expr]:
    draft = Draft()
    state, u = draft.state("x", x), draft.unknown("u", start)
    draft.rates.append(draft.solve([u], [residual(u, state)]))  # type: ignore[operator]
    draft.rate(state, 0.0 * state)
    draft.power(u)
    return draft, state, u


CASES = {
    "overshooting arctangent": (lambda u, x: atan2(u, 1.0) - 0.1 * x, 8.0, np.tan(0.1)),
    "exponential far away": (lambda u, x: exp(u) - 2.0 * x, 30.0, np.log(2.0)),
    "square root law": (lambda u, x: sign(u) * sqrt(absolute(u)) + u - 2.0 * x, 1e-6, 1.0),
    "kink": (lambda u, x: where(u < 0.0, 3.0 * u, u) - x, -5.0, 1.0),
    "start without a slope": (lambda u, x: u * u * u + u - 10.0 * x, float("nan"), 2.0),
}


@pytest.mark.parametrize("name", CASES)
@BACKENDS
def test_scalar_blocks_are_found_from_poor_starts(name: str, backend: Backend) -> None:
    residual, start, expected = CASES[name]
    draft, _, _ = scalar(residual, start)
    _, powers = build_machine(draft.program(), Method.EULER, backend=backend).rates(draft.memory())
    assert powers[0] == pytest.approx(expected, rel=1e-12)


def test_the_solution_follows_its_parameter_as_a_bracketing_method_finds_it() -> None:
    draft = Draft()
    x, u = draft.state("x", 0.0), draft.unknown("u")
    solve = draft.solve([u], [u * absolute(u) + 0.3 * u - x])
    draft.rates.append(solve)
    draft.rate(x, 1.0 - 0.2 * u)
    draft.observe.append(solve)
    draft.signal(x)
    draft.signal(u)
    outcome = build_machine(draft.program(), Method.RK4).run(
        draft.memory(), Request(until=3.0, step=1e-2, row_period=0.5, selected=np.arange(2))
    )
    assert outcome.status is Status.FINISHED

    def residual(v: float, level: float) -> float:
        return v * abs(v) + 0.3 * v - level

    for level, found in outcome.rows:
        assert found == pytest.approx(brentq(residual, -1.0, 10.0, args=(level,), xtol=1e-14), abs=1e-12)


def test_equal_blocks_have_one_number_and_others_follow() -> None:
    draft = implicit(1)
    other = draft.unknown("other")
    draft.observe.append(draft.solve([other], [other - 1.0]))
    numbers = number_solves(draft.program())
    assert list(numbers.values()) == [0, 1]


@BACKENDS
def test_controllers_may_contain_blocks(backend: Backend) -> None:
    draft = Draft()
    period = draft.parameter("period", 0.1)
    x, held = draft.state("x", 1.0), draft.discrete("held")
    u = draft.unknown("u")
    draft.rate(x, -held)
    draft.sample(period, {held: u})
    draft.samples[0].insert(0, draft.solve([u], [u * u * u + u - 2.0 * x]))
    draft.signal(held)
    outcome = build_machine(draft.program(), Method.EULER, backend=backend).run(
        draft.memory(), Request(until=0.1, step=1e-3, row_period=0.1, selected=np.array([0]))
    )
    assert outcome.rows[0, 0] == pytest.approx(1.0, rel=1e-12)
    assert outcome.rows[1, 0] == pytest.approx(brentq(lambda v: v**3 + v - 1.8, 0, 1, xtol=1e-15), rel=1e-12)


@BACKENDS
def test_a_lane_that_is_done_keeps_its_solution_while_others_go_on(backend: Backend) -> None:
    draft, _, _ = scalar(lambda u, x: exp(u) + u - 2.0 * x)
    # The first lane is done after one correction that is small, but not nothing.
    starts = [brentq(lambda v: np.exp(v) + v - 2.0, 0.0, 1.0, xtol=1e-15) + 4e-12, 20.0, -3.0, 0.4]
    together = draft.memory(4)
    together.unknown[0] = starts
    _, powers = build_machine(draft.program(), Method.EULER, 4, backend).rates(together)
    machine = build_machine(draft.program(), Method.EULER, 1, backend)
    for lane, start in enumerate(starts):
        alone = draft.memory()
        alone.unknown[0] = start
        assert machine.rates(alone)[1][0] == powers[0, lane]
