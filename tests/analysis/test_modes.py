"""Modes against closed forms."""

import math

import numpy as np
import pytest

from propermodel.analysis.spectrum import all_values, roots_of
from propermodel.diagnostics import parse_path
from tests.analysis.linear_systems import C, L, R, circuit, free_pair, linear, two_masses


def test_a_series_circuit_rings_as_its_textbook_says():
    (mode,) = linear(circuit()).modes()
    assert mode.natural_frequency == pytest.approx(1.0 / math.sqrt(L * C) / (2.0 * math.pi), rel=1e-12)
    assert mode.damping_ratio == pytest.approx(0.5 * R * math.sqrt(C / L), rel=1e-12)
    assert mode.time_constant == pytest.approx(2.0 * L / R, rel=1e-12)
    assert mode.frequency == pytest.approx(mode.natural_frequency * math.sqrt(1.0 - mode.damping_ratio**2), rel=1e-12)
    assert mode.is_oscillation


def test_critical_damping_is_one_double_mode():
    (mode,) = linear(circuit(resistance=2.0 * math.sqrt(L / C))).modes()
    assert mode.multiplicity == 2
    assert mode.eigenvalue == pytest.approx(-1.0 / math.sqrt(L * C), rel=1e-12)
    assert mode.damping_ratio == 1.0
    assert mode.frequency == 0.0


def test_equal_masses_swing_together_undamped_and_against_each_other_damped():
    still, together, against = linear(two_masses(damping=1.0)).modes()
    # Three springs between fixed walls: the sum of their lengths never changes.
    assert still.eigenvalue == 0.0
    assert still.time_constant == math.inf
    assert {str(path) for path in still.states} == {"left.displacement", "middle.displacement", "right.displacement"}
    assert together.eigenvalue == pytest.approx(1j * math.sqrt(50.0 / 2.0), rel=1e-12)
    assert together.dissipation == {}
    assert {str(path): share for path, share in together.energy.items()} == pytest.approx(
        {"one": 0.25, "two": 0.25, "left": 0.25, "right": 0.25}
    )
    # x1 = -x2: 2 x'' + 2 d x' + 3 k x = 0.
    assert against.eigenvalue == pytest.approx(-0.5 + 1j * math.sqrt(3.0 * 50.0 / 2.0 - 0.25), rel=1e-12)
    assert against.energy[parse_path("middle")] == pytest.approx(4.0 / 12.0, rel=1e-9)
    assert against.dissipation == {parse_path("damper"): 1.0}


def test_a_free_pair_moves_on_and_oscillates_about_its_centre():
    along, about = linear(free_pair()).modes()
    assert along.eigenvalue == 0.0
    assert along.energy == pytest.approx({parse_path("two"): 0.75, parse_path("one"): 0.25})
    assert along.dissipation == {}
    reduced_mass = 1.0 * 3.0 / 4.0
    assert about.natural_frequency == pytest.approx(math.sqrt(30.0 / reduced_mass) / (2.0 * math.pi), rel=1e-12)
    assert about.damping_ratio == pytest.approx(0.6 / (2.0 * math.sqrt(30.0 * reduced_mass)), rel=1e-12)
    assert about.states[parse_path("spring.displacement")] == pytest.approx(0.5, abs=1e-12)


def test_the_table_of_modes_reads_well():
    assert str(linear(free_pair()).modes()) == (
        "modes of system\n"
        "  frequency Hz  damping  time constant s    states\n"
        "             0        0              inf    two.momentum 75 %, one.momentum 25 %\n"
        "       1.00457  0.06325              2.5    "
        "spring.displacement 50 %, one.momentum 38 %, two.momentum 13 %"
    )


def test_participation_does_not_depend_on_units():
    A = linear(two_masses(damping=1.0)).A
    sizes = np.array([1e-6, 1e3, 1e5, 1.0, 1e-2])
    for one, other in zip(roots_of(A), roots_of(A * sizes[:, np.newaxis] / sizes), strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-9)
        np.testing.assert_allclose(one.shares, other.shares, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_defective_matrices_are_seen_through_rounding(seed: int):
    mixed = np.random.default_rng(seed).normal(size=(6, 6))
    jordan = np.diag([-1.0, -1.0, -1.0, 0.0, 0.0, 5.0])
    jordan[0, 1] = jordan[1, 2] = jordan[3, 4] = 1.0
    roots = roots_of(mixed @ jordan @ np.linalg.inv(mixed))
    assert [(root.multiplicity, root.is_pair) for root in roots] == [(2, False), (3, False), (1, False)]
    assert roots[0].value == 0.0
    np.testing.assert_allclose([root.value for root in roots[1:]], [-1.0, 5.0], rtol=1e-9)
    for root, members in zip(roots, ([3, 4], [0, 1, 2], [5]), strict=True):
        projection = mixed[:, members] @ np.linalg.inv(mixed)[members]
        np.testing.assert_allclose(root.shares, np.diag(projection), atol=1e-5)


def test_eigenvalues_and_vectors_of_a_full_matrix_are_those_of_lapack():
    A = np.random.default_rng(7).normal(size=(40, 40))
    roots = roots_of(A)
    np.testing.assert_allclose(np.sort_complex(all_values(roots)), np.sort_complex(np.linalg.eigvals(A)), rtol=1e-9)
    for root in roots:
        np.testing.assert_allclose(A @ root.vector, root.value * root.vector, atol=1e-11)
        assert np.sum(root.shares) == pytest.approx(1.0, abs=1e-9)
