"""Blocks in the quantities that nonlinear operations see have the solutions of the blocks they come from."""

from __future__ import annotations

import pytest
from scipy.optimize import brentq

from propermodel.diagnostics import Path
from propermodel.equations.condense import condense
from propermodel.expressions.core import Expr, SymbolKind, minimum, symbol, tanh
from propermodel.expressions.interpret import interpret, interpret_all

A, B, C = (symbol(SymbolKind.UNKNOWN, Path((name, "effort"))) for name in "abc")


def solve(unknown: Expr, residual: Expr) -> float:
    return brentq(lambda value: interpret(residual, {unknown: value}), -1e3, 1e3, xtol=1e-14)


def test_two_unknowns_that_are_seen_as_their_sum_become_one() -> None:
    residuals = [A - 3.0 * tanh(A + 2.0 * B) - 1.0, B + 0.5 * tanh(2.0 * (A + 2.0 * B) - 1.0)]
    found = condense([A, B], residuals)
    assert found is not None
    (unknown,), (residual,) = found.unknowns, found.residuals
    value = solve(unknown, residual)
    a, b = (interpret(found.eliminated[x], {unknown: value}) for x in (A, B))
    assert interpret_all(residuals, {A: a, B: b}) == pytest.approx([0.0, 0.0], abs=1e-12)


def test_an_unknown_that_is_seen_itself_stays() -> None:
    residuals = [A - minimum(A, 1.0) * 0.5 + B, B + C - 2.0 + A, C - B + 3.0 * A]
    found = condense([A, B, C], residuals)
    assert found is not None
    assert found.unknowns == (A,)
    value = solve(A, found.residuals[0])
    b, c = (interpret(found.eliminated[x], {A: value}) for x in (B, C))
    assert interpret_all(residuals, {A: value, B: b, C: c}) == pytest.approx([0.0] * 3, abs=1e-12)


def test_unknowns_that_are_seen_one_by_one_are_left_alone() -> None:
    assert condense([A, B], [A - tanh(B), B - tanh(A)]) is None


def test_residuals_that_do_not_determine_what_would_go_leave_the_block_alone() -> None:
    total = A + B
    assert condense([A, B], [total - tanh(total), total * 2.0 - tanh(total) * 3.0]) is None
