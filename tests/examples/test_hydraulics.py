"""Hydraulic examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.examples.runs import answer


def solved(rates, start, times, **options):
    """Hand-written equations by an independent integrator, tightly."""
    done = solve_ivp(rates, (times[0], times[-1]), start, t_eval=times, rtol=1e-10, atol=1e-12, **options)
    assert done.success
    return done.y


def test_two_tanks_by_torricelli_and_poiseuille():
    run = answer("two_tanks")
    rho, g = 1000.0, 9.80665
    conductance = math.pi * 0.010**4 / (128 * 1e-3 * 2.0) * rho * g

    def rates(t, levels):
        pipe = conductance * (levels[0] - levels[1])
        out = 0.61 * 4e-5 * math.sqrt(2 * g * max(levels[1], 0.0))
        return [-pipe / 0.10, (pipe - out) / 0.05]

    upper, lower = solved(rates, [1.0, 0.0], run.time)
    np.testing.assert_allclose(run["upper.port.effort"] / (rho * g), upper, atol=2e-4)
    np.testing.assert_allclose(run["lower.port.effort"] / (rho * g), lower, atol=2e-4)


def test_an_accumulator_smooths():
    run = answer("accumulator")

    def rates(t, V):
        pressure = 5e6 * (1e-3 / (1e-3 - V)) ** 1.4 - 101325.0
        inflow = 3e-4 * (1 + np.sin(20 * math.pi * t))
        return inflow - 0.61 * 3e-6 * np.sqrt(2 * pressure / 870.0)

    oil = solved(rates, [1e-4], run.time, method="DOP853", max_step=0.01)[0]
    np.testing.assert_allclose(run["accumulator.port.displacement"], oil, atol=1e-9)


def test_a_water_hammer_is_joukowskys():
    run = answer("water_hammer")
    rho, K, area, n, length = 1000.0, 2.2e9, math.pi * 0.05**2 / 4, 40, 2.5
    inertia, capacity = rho * length / area, area * length / K
    loss = 128 * 1e-3 * length / (math.pi * 0.05**4)

    def rates(t, y):
        Q, p = y[:n], y[n:]
        ahead = np.append(Q[1:], np.interp(t, [0.01, 0.06], [1e-3, 0.0]))
        return [*((np.append(1e6, p[:-1]) - p - loss * Q) / inertia), *((Q - ahead) / capacity)]

    start = [1e-3] * n + [1e6] * n
    expected = solved(rates, start, run.time, method="DOP853", max_step=5e-3)
    np.testing.assert_allclose(run["pipe[39].oil.port.effort"], expected[-1], atol=100.0)
    assert run["pipe[39].oil.port.effort"].min() > 0.0  # the water does not boil
    rise = run["pipe[39].oil.port.effort"][run.time < 0.14].max() - 1e6
    assert rise == pytest.approx(rho * math.sqrt(K / rho) * 1e-3 / area, rel=0.05)


def test_a_press_multiplies_force_by_the_ratio_of_areas():
    run = answer("hydraulic_press")
    assert run.at_end("workpiece.spring.port.effort") == pytest.approx(10_000.0, rel=1e-6)
    assert run.at_end("oil.port.effort") == pytest.approx(1e6, rel=1e-6)


def test_a_relief_valve_takes_the_flow_of_the_pump():
    run = answer("pump_and_relief_valve")
    flow = 3e-6 * 150.0

    def relieved(p):
        width = 1e5
        above = 0.5 * (p - 15e6 + math.hypot(p - 15e6, width)) - 0.5 * (-15e6 + math.hypot(15e6, width))
        return 5e-10 * above + 1e-15 * p - flow

    assert run.at_end("line.port.effort") == pytest.approx(brentq(relieved, 1e7, 2e7), rel=1e-6)
    open_pressure = run["line.port.effort"][90]  # Q = C_d A sqrt(2 p / rho), after seven time constants of the oil
    assert open_pressure == pytest.approx(870.0 / 2 * (flow / (0.61 * 5e-6)) ** 2, rel=2e-3)


def test_a_position_servo_by_merritts_equations():
    run = answer("hydraulic_servo")
    gain = 0.61 * 1e-5 * math.sqrt(2 / 870.0)
    stiffness = 1.7e9 / 2e-4

    def orifice(opening, dp):
        return gain * opening * dp / (dp * dp + 1e8) ** 0.25

    def rates(t, y):
        p1, p2, v, x = y[0] * 1e5, y[1] * 1e5, y[2], y[3]
        s = min(max((np.interp(t, [0.1, 0.6], [0.0, 0.1]) - x) / 0.1, -1.0), 1.0)
        forward, backward = max(s, 0.0), max(-s, 0.0)
        Q1 = orifice(forward, 1e7 - p1) - orifice(backward, p1)
        Q2 = orifice(backward, 1e7 - p2) - orifice(forward, p2)
        force = 1e-3 * p1 - 7e-4 * p2 - 3000.0 * v
        return [stiffness * (Q1 - 1e-3 * v) / 1e5, stiffness * (Q2 + 7e-4 * v) / 1e5, force / 200.0, v]

    expected = solved(rates, np.zeros(4), run.time, method="LSODA", max_step=1e-3)
    np.testing.assert_allclose(run["sensor.position"], expected[3], atol=2e-6)
    late = run.time > 1.8
    assert abs(run["sensor.position"][late] - 0.1).max() < 2e-4  # it has come to rest, in spite of the springy oil
