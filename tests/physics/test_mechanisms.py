"""Closed kinematic loops against closed forms and independent solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

import propermodel as pm
from propermodel.compiler import Backend
from propermodel.modelling.documents import from_document, to_document
from tests.physics.mechanisms import GRAVITY, CartesianPendulum
from tests.physics.systems import run


def energy(trajectory: pm.Trajectory) -> np.ndarray:
    """Kinetic and potential energy of the pendulum's bob, J."""
    squares = trajectory["along.flange.flow"] ** 2 + trajectory["upward.flange.flow"] ** 2
    return squares + 2.0 * GRAVITY * trajectory["rod.displacement.y"]


def test_cartesian_pendulum_swings_with_the_period_of_the_elliptic_integral() -> None:
    # Released at rest from the horizontal: T = 4 sqrt(l / g) K(sin^2(45 degrees)).
    period = 4.0 * math.sqrt(1.0 / GRAVITY) * ellipk(math.sin(math.pi / 4.0) ** 2)
    swing = run(CartesianPendulum(), period, step=1e-3, every=period / 2.0)
    assert swing["rod.displacement.x"][1] == pytest.approx(-1.0, abs=1e-8)
    assert swing["rod.displacement.x"][2] == pytest.approx(1.0, abs=1e-8)
    assert abs(swing["along.flange.flow"][2]) < 1e-6


def test_cartesian_pendulum_stays_on_its_circle_and_keeps_its_energy_for_100_s() -> None:
    swing = run(CartesianPendulum(), 100.0, step=1e-3, every=0.01)
    assert np.abs(swing["rod.displacement.excess"]).max() < 1e-12
    assert np.abs(energy(swing)).max() < 1e-8
    # The rod pulls with m v^2 / l + m g sin: three times the weight at the bottom.
    assert -swing["rod.excess.effort"].min() == pytest.approx(3.0 * 2.0 * GRAVITY, rel=1e-4)


def test_cartesian_pendulum_turns_over() -> None:
    # Faster than sqrt(5 g l) at the bottom it goes all the way round, through y = 0 and overhead.
    start = {"rod.displacement.x": 0.0, "rod.displacement.y": -1.0, "along.momentum": 16.0}
    turning = run(CartesianPendulum(), 5.0, step=1e-3, every=0.001, initial=start)
    angle = np.unwrap(np.arctan2(turning["rod.displacement.x"], -turning["rod.displacement.y"]))
    assert angle[-1] > 4.0 * math.pi
    assert np.all(np.diff(angle) > 0.0)
    assert turning["rod.displacement.y"].max() == pytest.approx(1.0, abs=1e-4)
    assert np.ptp(energy(turning)) < 1e-7
    assert np.abs(turning["rod.displacement.excess"]).max() < 1e-12


@pytest.mark.parametrize("method", list(pm.Method))
def test_backends_agree_on_a_constraint(method: pm.Method) -> None:
    ends = [
        run(CartesianPendulum(), 0.3, step=1e-3, method=method, backend=backend).final_signals for backend in Backend
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-12)


def test_constraint_is_explained() -> None:
    compiled = pm.compile_model(pm.elaborate(CartesianPendulum()))
    assert "closes a kinematic loop: its effort keeps its flow" in str(compiled.system.causal)
    assert [str(closure.element) for closure in compiled.system.closures] == ["rod.at_excess.held"]


def test_mechanism_survives_its_document() -> None:
    model = pm.elaborate(CartesianPendulum())
    again = from_document(to_document(model))
    assert again == model
    ends = [run(m, 0.5).final_signals for m in (model, again)]
    assert np.array_equal(*ends)
