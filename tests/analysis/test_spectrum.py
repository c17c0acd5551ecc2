"""Eigenvalues that are known beforehand, in states that hide them."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from propermodel.analysis.spectrum import roots_of
from propermodel.codegen.machine import FloatArray


def jordan(value: float, size: int) -> FloatArray:
    return value * np.eye(size) + np.diag(np.ones(size - 1), 1)


def pair(real: float, imaginary: float) -> FloatArray:
    return np.array([[real, imaginary], [-imaginary, real]])


def hidden(matrix: FloatArray, seed: int) -> FloatArray:
    """The same matrix in other states, moderately mixed."""
    rng = np.random.default_rng(seed)
    first, _ = np.linalg.qr(rng.normal(size=matrix.shape))
    second, _ = np.linalg.qr(rng.normal(size=matrix.shape))
    change = first @ np.diag(np.linspace(0.5, 2.0, len(matrix))) @ second
    return change @ matrix @ np.linalg.inv(change)


@pytest.mark.parametrize("seed", range(8))
def test_a_defective_value_leaves_all_others_as_they_are(seed: int):
    blocks = (jordan(0.0, 3), jordan(-50.0, 2), [[-7.0]], [[-7.001]], pair(-1.0, 20.0), [[-191.0]])
    found = roots_of(hidden(block_diag(*blocks), seed))
    assert [root.multiplicity for root in found] == [3, 1, 1, 1, 2, 1]
    assert [root.value for root in found] == pytest.approx([0.0, -7.0, -7.001, -1.0 + 20.0j, -50.0, -191.0], abs=1e-6)
    for root in found:
        assert root.shares.sum() == pytest.approx(root.multiplicity)


def test_values_that_are_exactly_zero_have_shares_and_no_error():
    chain = np.zeros((5, 5))
    chain[0, 1] = chain[1, 2] = 1.0  # two integrations of a constant
    chain[3, 3], chain[4, 4] = -6.667, 1.26e-4
    with np.errstate(all="raise", under="ignore"):
        found = roots_of(chain)
    assert [(root.value, root.multiplicity) for root in found] == [(0.0, 3), (1.26e-4, 1), (-6.667, 1)]
    assert all(np.isfinite(root.shares).all() for root in found)


def test_defective_pairs_are_told_apart():
    double = np.block([[pair(-1.0, 3.0), np.eye(2)], [np.zeros((2, 2)), pair(-1.0, 3.0)]])
    found = roots_of(hidden(block_diag(double, jordan(-4.0, 2)), 1))
    assert [root.multiplicity for root in found] == [2, 2]
    assert [root.value for root in found] == pytest.approx([-1.0 + 3.0j, -4.0], abs=1e-6)
