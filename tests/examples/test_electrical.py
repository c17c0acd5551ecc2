"""Electrical examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

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


def test_a_charged_plate_settles_where_spring_and_field_balance():
    run = answer("electrostatic_transducer")
    epsilon, area, gap, stiffness, V = 8.8541878128e-12, 4e-8, 2e-6, 1.0, 2.0

    def pull(x):
        return epsilon * area * V**2 / (2 * (gap - x) ** 2) - stiffness * x

    rest = brentq(pull, 0.0, gap / 3)
    assert run["plates.approach"][-1] == pytest.approx(rest, rel=1e-4)
    assert math.sqrt(8 * stiffness * gap**3 / (27 * epsilon * area)) == pytest.approx(2.59, abs=5e-3)

    def rates(t, y):
        x, v, q = y
        voltage = q * (gap - x) / (epsilon * area)
        force = q * q / (2 * epsilon * area)
        return [v, (force - stiffness * x - 3e-5 * v) / 1e-9, (V - voltage) / 5e7]

    scale = [1e-12, 1e-9, 1e-19]
    expected = solve_ivp(rates, (0, 2e-3), [0, 0, 0], "Radau", run.time, rtol=1e-8, atol=scale).y[0]
    np.testing.assert_allclose(run["plates.approach"], expected, atol=1e-11)


def impedance_of_loudspeaker(s: complex) -> complex:
    mechanical = 20e-3 * s + 1.4 + 2000.0 / s
    return 6.0 + 0.5e-3 * s + 7.0**2 / mechanical


def test_a_loudspeaker_by_its_impedance():
    run = answer("loudspeaker")
    s = 2j * math.pi * 100.0
    current = 10.0 / impedance_of_loudspeaker(s)
    late = run.time > 0.15
    expected = (current * np.exp(s * run.time[late])).imag
    np.testing.assert_allclose(run["coil.port.flow"][late], expected, atol=2e-4)
    velocity = 7.0 * current / (20e-3 * s + 1.4 + 2000.0 / s)
    np.testing.assert_allclose(run["cone.flange.flow"][late], (velocity * np.exp(s * run.time[late])).imag, atol=2e-4)


def test_a_line_delays_and_a_matched_end_gives_hardly_an_echo():
    run = answer("transmission_line")
    n, L, C, R = 30, 25e-9, 10e-12, 50.0
    # currents i_1..i_n, voltages v_1..v_n; time in ns.
    a = np.zeros((2 * n, 2 * n))
    for k in range(n):
        a[k, n + k] = -1 / L
        a[k, n + k - 1 if k else k] = 1 / L if k else -R / L
        a[n + k, k] = 1 / C
        if k + 1 < n:
            a[n + k, k + 1] = -1 / C
    a[2 * n - 1, 2 * n - 1] = -1 / (R * C)
    drive = np.zeros(2 * n)
    drive[0] = 1 / L

    def rates(t, x):
        voltage = np.interp(t, [0.0, 3.0, 6.0], [0.0, 2.0, 0.0])
        return 1e-9 * (a @ x + drive * voltage)

    expected = solve_ivp(
        rates, (0, 40), np.zeros(2 * n), "DOP853", run.time * 1e9, rtol=1e-10, atol=1e-10, max_step=0.2
    )
    np.testing.assert_allclose(run["load.port.effort"], expected.y[-1], atol=1e-5)
    delay = run.time[run["load.port.effort"].argmax()] - 3e-9
    assert delay == pytest.approx(n * math.sqrt(L * C), rel=0.05)
    first = run["sections[0].capacitor.port.effort"]
    assert abs(first[run.time > 25e-9]).max() < 0.08 * first.max()  # of lumped sections


def test_the_limit_cycle_of_van_der_pol():
    run = answer("van_der_pol")

    def rates(t, y):
        return [-1.5 * y[0] * (y[0] ** 2 - 1) - y[1], y[0]]

    expected = solve_ivp(rates, (0, 40), [0.1, 0.0], "DOP853", run.time, rtol=1e-11, atol=1e-12).y
    np.testing.assert_allclose(run["capacitor.port.effort"], expected[0], atol=1e-6)
    np.testing.assert_allclose(run["coil.port.flow"], expected[1], atol=1e-6)


def test_a_load_behind_a_transformer_is_ratio_squared_times_itself():
    run = answer("transformer_load")
    s = 2j * math.pi * 50.0
    late = run.time > 0.08
    load = 325.0 / (0.1 * s + 10.0**2) * 10.0 * 1.0
    np.testing.assert_allclose(run["load.port.effort"][late], (load * np.exp(s * run.time[late])).imag, atol=1e-4)


def test_an_inverting_low_pass_by_its_frequency_response():
    run = answer("low_pass_amplifier")
    s = 2j * math.pi * 1000.0
    feedback = 1 / (1 / 10e3 + s * 15.9155e-9)
    open_loop = 2 * math.pi * 1e6 / (s + 2 * math.pi * 1e6 / 1e5)
    # Virtual ground v_m: (v_in - v_m) / R1 = (v_m - v_out) / Z, v_out = -A v_m.
    gain = -(feedback / 1e3) / (1 + (1 + feedback / 1e3) / open_loop)
    late = run.time > 3e-3
    expected = (0.1 * gain * np.exp(s * run.time[late])).imag
    np.testing.assert_allclose(run["load.port.effort"][late], expected, atol=1e-6)
    assert abs(gain) == pytest.approx(10.0 / math.sqrt(2.0), rel=0.01)


def test_a_rectifier_by_shockleys_law():
    run = answer("smoothed_rectifier")

    def current(drop: float) -> float:
        if drop <= 0.0:
            return 0.0  # a nanoampere flows back

        def excess(i: float) -> float:
            return drop - 0.5 * i - 0.02585 * math.log1p(i / 1e-9)

        return brentq(excess, 0.0, drop / 0.5, xtol=1e-14)

    def rates(t, y):
        return [(current(20 * math.sin(100 * math.pi * t) - y[0]) - y[0] / 100.0) / 1e-3]

    expected = solve_ivp(rates, (0, 0.1), [0.0], "LSODA", run.time, rtol=1e-8, atol=1e-9, max_step=2e-4).y[0]
    np.testing.assert_allclose(run["load.port.effort"], expected, atol=2e-4)


def test_a_coil_runs_down_through_a_diode():
    run = answer("freewheeling_diode")
    R, L, saturation, thermal, leakage = 4.0, 0.1, 1e-9, 0.02585, 1e-3

    # In the voltage of the diode as the variable no law has to be inverted.
    def current(v):
        return saturation * np.expm1(v / thermal) + leakage * v

    def rate(t, v):
        return (-R * current(v) - v) / (L * (saturation / thermal * np.exp(v / thermal) + leakage))

    start = brentq(lambda v: current(v) - 0.5, 0.0, 0.8, xtol=1e-15)
    voltage = solve_ivp(rate, (0.0, 0.06), [start], "LSODA", run.time, rtol=1e-11, atol=1e-13).y[0]
    np.testing.assert_allclose(run["coil.port.flow"], current(voltage), atol=1e-7)
    np.testing.assert_allclose(run["diode.port.effort"], voltage, atol=1e-6)
    # The docstring: through a resistor that takes as much at the start it would last longer.
    with_resistor = 0.5 * np.exp(-(R + start / 0.5) / L * run.time)
    assert np.all(run["coil.port.flow"][1:] < with_resistor[1:])


def test_a_buck_converter_is_two_linear_circuits_in_turn():
    run = answer("buck_converter")
    L, C, R, V, period, duty = 200e-6, 100e-6, 5.0, 24.0, 5e-5, 0.25
    a, on = np.array([[0.0, -1 / L], [1 / C, -1 / (R * C)]]), np.array([V / L, 0.0])
    x, opening, ending = np.array([1.0, 5.0]), expm(a * duty * period), expm(a * (1 - duty) * period)
    gain = np.linalg.solve(a, on)
    for k in range(1, 21):
        x = ending @ (opening @ (x + gain) - gain)
        row = np.searchsorted(run.time, k * period - 1e-9)
        assert run["coil.port.flow"][row] == pytest.approx(x[0], rel=1e-6)
        assert run["load.port.effort"][row] == pytest.approx(x[1], rel=1e-6)
        assert x[0] > 0.0  # always a way for the current
    powers = run["switch.port.effort"] * run["switch.port.flow"], run["diode.port.effort"] * run["diode.port.flow"]
    assert np.abs(powers).max() < 1e-12
