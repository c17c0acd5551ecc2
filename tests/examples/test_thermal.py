"""Thermal examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from propermodel.analysis.balance import energy_balance
from tests.examples.runs import answer


def test_a_kettle_warms_up_exponentially():
    run = answer("heater")
    expected = 150.0**2 / 50.0 / 5.0 * (1 - np.exp(-run.time * 5.0 / 2000.0))
    np.testing.assert_allclose(run["water.port.effort"], expected, atol=1e-7)
    # All that the supply gave and the water cannot give back as work is lost: C (T - T_a) - T_a C ln(T / T_a) is left.
    above = expected[-1]
    left = 2000.0 * (above - 300.0 * math.log1p(above / 300.0))
    assert energy_balance(run).dissipated == pytest.approx(150.0**2 / 50.0 * 600.0 - left, rel=1e-9)


def test_a_wall_by_its_heat_flows():
    run = answer("thermal_wall")
    capacity = np.array([2.0e4, 3.0e5, 3.0e4])
    conductance = np.array([8.0, 6.0, 6.0, 20.0])

    def rates(t, T):
        heat = conductance * -np.diff([20.0, *T, 0.0])
        return -np.diff(heat) / capacity

    expected = solve_ivp(rates, (0, 259200), np.zeros(3), "LSODA", run.time, rtol=1e-10, atol=1e-10).y
    for layer, temperature in zip(("plaster", "brick", "render"), expected, strict=True):
        np.testing.assert_allclose(run[f"{layer}.port.effort"], temperature, atol=1e-5)


def test_a_counterflow_exchanger_ends_where_its_heat_flows_balance():
    run = answer("heat_exchanger")
    n, hot, cold, wall = 10, 400.0, 800.0, 60.0
    a, b = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    for k in range(n):
        h, c = k, n + k
        a[h, h], a[h, c], a[c, c], a[c, h] = hot + wall, -wall, cold + wall, -wall
        if k:
            a[h, h - 1] = -hot
        else:
            b[h] = hot * 60.0
        if k < n - 1:
            a[c, c + 1] = -cold
    steady = np.linalg.solve(a, b)
    assert run.at_end("cells[9].hot_outlet") == pytest.approx(steady[n - 1], abs=1e-3)
    assert run.at_end("cells[0].cold_outlet") == pytest.approx(steady[n], abs=1e-3)
    # With ever more cells: the effectiveness of counterflow (Incropera et al., ch. 11).
    ntu, ratio = n * wall / hot, hot / cold
    effectiveness = (1 - math.exp(-ntu * (1 - ratio))) / (1 - ratio * math.exp(-ntu * (1 - ratio)))
    assert 1 - steady[n - 1] / 60.0 == pytest.approx(effectiveness, abs=0.05)
