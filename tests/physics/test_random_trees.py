"""Whatever is wired up: energy balances, and the way it is written down does not matter."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.compiler import CompiledModel
from tests.physics.systems import compiled, run, state_matrix
from tests.physics.trees import Tree, Writing, trees, write

STEP = 2e-3
STOP = 1.0


def stable_step(model: CompiledModel) -> float:
    """A step that RK4 resolves well: stiff links can be made of small masses behind large ratios."""
    rates = np.linalg.eigvals(state_matrix(model)) if model.system.states else np.zeros(1)
    return min(STEP, 0.05 / max(float(np.max(np.abs(rates))), 1e-9))


@settings(max_examples=30)
@given(tree=trees())
def test_what_sources_do_is_stored_or_dissipated(tree: Tree):
    model = compiled(write(tree))
    r = run(model, STOP, step=stable_step(model))
    balance = energy_balance(r)
    assert balance.throughput > 0.0
    assert balance.dissipated >= 0.0
    assert abs(balance.integration_residual) < 1e-6 * balance.throughput
    largest = float(np.max(r.memory.activity))
    assert abs(balance.wiring_residual) < 1e-12 * largest * len(r.memory.activity)


@settings(max_examples=16)
@given(tree=trees(), data=st.data())
def test_results_do_not_depend_on_how_a_model_is_written(tree: Tree, data: st.DataObject):
    numbers = range(len(tree.nodes))
    writing = Writing(
        turned=frozenset(data.draw(st.sets(st.sampled_from(list(numbers))))),
        reverse=data.draw(st.booleans()),
        prefix=data.draw(st.sampled_from(["", "z_"])),
        inserted=frozenset(data.draw(st.sets(st.sampled_from(list(numbers))))),
    )
    plain, other = compiled(write(tree)), compiled(write(tree, writing))
    assert len(plain.system.states) == len(other.system.states)
    step = stable_step(plain)
    expected, found = run(plain, STOP, step=step, every=0.05), run(other, STOP, step=step, every=0.05)
    rows, others = rank_activity(expected), rank_activity(found)
    assert others.total == pytest.approx(rows.total, rel=1e-9)
    indices = {str(row.path): row.index for row in rows.rows}
    for row in others.rows:
        assert row.index == pytest.approx(indices[str(row.path).removeprefix(writing.prefix)], abs=1e-9)
    for number, node in enumerate(tree.nodes):
        if node.domain == "T" and node.own[0]:
            before, after = expected[f"mass{number}.flange.flow"], found[writing.name(f"mass{number}.flange.flow")]
            assert after == pytest.approx(before, rel=1e-8, abs=1e-9)
            before, after = expected[f"mass{number}.flange.effort"], found[writing.name(f"mass{number}.flange.effort")]
            assert after == pytest.approx(before, rel=1e-7, abs=1e-7)
