"""Electrical examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from tests.examples.runs import answer


def linear(a: np.ndarray, b: np.ndarray, times: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """The answer of x' = A x + b at equally spaced times, exactly."""
    n = len(b)
    big = np.zeros((n + 1, n + 1))
    big[:n, :n], big[:n, n] = a, b
    step = expm(big * (times[1] - times[0]))
    x = np.append(np.zeros(n) if start is None else start, 1.0)
    rows = [x]
    for _ in times[1:]:
        x = step @ x
        rows.append(x)
    return np.array(rows)[:, :n]


def test_the_step_response_of_a_series_circuit():
    run = answer("rlc")
    R, L, C, V = 20.0, 10e-3, 1e-6, 10.0
    decay, w = R / (2 * L), math.sqrt(1 / (L * C) - (R / (2 * L)) ** 2)
    t = run.time
    voltage = V * (1 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    current = V / (w * L) * np.exp(-decay * t) * np.sin(w * t)
    np.testing.assert_allclose(run["capacitor.port.effort"], voltage, atol=1e-6)
    np.testing.assert_allclose(run["inductor.port.flow"], current, atol=1e-9)


def test_a_motor_with_a_fan():
    run = answer("dc_motor")
    R, L, k, J, d, V = 0.5, 2e-3, 0.1, 1e-3, 2e-3 + 1e-5, 12.0
    expected = linear(np.array([[-R / L, -k / L], [k / J, -d / J]]), np.array([V / L, 0.0]), run.time)
    np.testing.assert_allclose(run["motor.pin.flow"], expected[:, 0], atol=1e-4)
    np.testing.assert_allclose(run["fan.shaft.flow"], expected[:, 1], atol=1e-4)


def test_a_bridge_is_kirchhoffs_equations():
    run = answer("wheatstone_bridge")
    for t, current in zip(run.time, run["galvanometer.port.flow"], strict=True):
        gauge = 118.0 + 4.0 * t
        nodes = np.array([[2 / 120 + 1e-3, -1e-3], [-1e-3, 1 / 120 + 1 / gauge + 1e-3]])
        left, right = np.linalg.solve(nodes, [5 / 120, 5 / 120])
        assert current == pytest.approx((left - right) / 1000.0, abs=1e-15)


def test_a_chain_of_gyrators_is_a_skew_symmetric_system():
    run = answer("gyrator_chain")
    g = 1.0 / 1000.0 / 1e-6
    # i into the far side is v/r: each capacitor is charged from the left and discharged to the right.
    a = np.diag([g] * 3, -1) - np.diag([g] * 3, 1)
    expected = linear(a, np.zeros(4), run.time, np.array([1.0, 0.0, 0.0, 0.0]))
    got = np.stack([run[f"{n}.port.effort"] for n in ("first", "second", "third", "fourth")], axis=1)
    np.testing.assert_allclose(got, expected, atol=1e-7)


def test_coupled_coils_are_two_loops_of_kirchhoff():
    run = answer("coupled_coils")
    inductance = np.array([[20e-3, 8e-3], [8e-3, 5e-3]])
    resistance = np.diag([2.0, 5.0])
    inverse = np.linalg.inv(inductance)
    expected = linear(-inverse @ resistance, inverse @ [10.0, 0.0], run.time)
    np.testing.assert_allclose(run["coils.primary.flow"], expected[:, 0], atol=1e-6)
    np.testing.assert_allclose(run["load.port.flow"], -expected[:, 1], atol=1e-6)
