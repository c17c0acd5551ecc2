"""Elementary functions in one call: nothing is computed before what it needs, and no bit changes."""

from __future__ import annotations

import numpy as np
import pytest

from propermodel.codegen.build import build_machine
from propermodel.codegen.llvm_bundles import WIDEST, Bundle, bundled
from propermodel.codegen.machine import Method
from propermodel.codegen.print_program import print_program
from propermodel.diagnostics import Path
from propermodel.expressions import atan2, exp, sin, tanh
from propermodel.expressions.core import Expr, SymbolKind, postorder, symbol
from tests.codegen.programs import Draft


class Barrier:
    """What nothing moves past."""


def leaf(name: str) -> Expr:
    return symbol(SymbolKind.STATE, Path((name,)))


def in_order(roots: list[Expr]) -> list[Expr | Bundle | Barrier]:
    return list(bundled([node for node in postorder(roots) if node.args], Barrier))


def test_equal_functions_are_bundled_and_others_are_not():
    x = leaf("x")
    items = in_order([tanh(float(k) * x) for k in range(2, 8)] + [exp(x), sin(x), sin(2.0 * x)])
    bundles = [item.nodes for item in items if isinstance(item, Bundle)]
    assert [len(nodes) for nodes in bundles] == [WIDEST, 2, 2]
    assert exp(x) in items


def test_what_depends_on_another_waits_for_it():
    x, y = leaf("x"), leaf("y")
    inner = tanh(x) + tanh(y)
    items = in_order([tanh(inner), tanh(tanh(x) * 2.0) + exp(tanh(y)), exp(x)])
    done: set[Expr] = set()
    for item in items:
        assert not isinstance(item, Barrier)
        nodes = item.nodes if isinstance(item, Bundle) else (item,)
        for node in nodes:
            assert all(arg in done or not arg.args for arg in node.args)
        done.update(nodes)
    assert len(done) == sum(len(item.nodes) if isinstance(item, Bundle) else 1 for item in items)
    assert [item.nodes for item in items if isinstance(item, Bundle)] == [
        (tanh(x), tanh(y)),
        (tanh(inner), tanh(tanh(x) * 2.0)),
    ]


def test_nothing_moves_past_a_barrier():
    x, y = leaf("x"), leaf("y")
    barrier = Barrier()
    assert list(bundled([exp(x), barrier, exp(y)], Barrier)) == [exp(x), barrier, exp(y)]


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7])
def test_bundled_functions_have_the_bits_of_lanes(count: int):
    draft = Draft()
    states = [draft.state(f"x{k}", 0.37 * k - 0.9) for k in range(count)]
    for x in states:
        draft.rate(x, tanh(x) + exp(-x * tanh(0.5 * x)) * atan2(x, 1.5))
    alone, beside = (build_machine(draft.program(), Method.RK4, lanes) for lanes in (1, 2))
    rates, _ = alone.rates(draft.memory())
    np.testing.assert_array_equal(beside.rates(draft.memory(2))[0][:, 1], rates)
    values = np.array([0.37 * k - 0.9 for k in range(count)])
    expected = np.tanh(values) + np.exp(-values * np.tanh(0.5 * values)) * np.arctan2(values, 1.5)
    np.testing.assert_allclose(rates, expected, rtol=1e-14)


def test_one_call_takes_four_arguments():
    draft = Draft()
    states = [draft.state(f"x{k}", 0.1 * k) for k in range(4)]
    for x in states:
        draft.rate(x, tanh(x))
    text = print_program(draft.program(), Method.EULER).text
    (body,) = (part for part in text.split("define internal void @rates(")[1:])
    body = body.split("\n}")[0]
    assert body.count("@math.tanh.v4f64") == 1
    assert "@math.tanh.f64" not in body
