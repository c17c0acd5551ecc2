"""Mechanical examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from propermodel.analysis.balance import energy_balance
from tests.examples.runs import answer


def test_geared_inertias_turn_as_one():
    run = answer("geared_inertias")
    rotor = 3.0 / (0.01 + 0.5 / 25.0) * run.time
    np.testing.assert_allclose(run["rotor.shaft.flow"], rotor, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["drum.shaft.flow"], rotor / 5.0, rtol=1e-12, atol=1e-12)


def test_the_period_of_a_wide_swing_is_an_elliptic_integral():
    run = answer("pendulum")
    angle, t = run["weight.shaft.displacement"], run.time
    down = [i for i in range(len(t) - 1) if angle[i] > 0 >= angle[i + 1]]
    at = [t[i] + 0.01 * angle[i] / (angle[i] - angle[i + 1]) for i in down]
    small = 2 * math.pi * math.sqrt(0.5 / 9.80665)
    period = small * 2 / math.pi * ellipk(math.sin(math.radians(60.0)) ** 2)
    assert period / small == pytest.approx(1.373, abs=5e-4)  # what the docstring says
    assert at[1] - at[0] == pytest.approx(period, rel=1e-4)


def simulated(rates, start, run, **options):
    """Hand-written equations by an independent integrator, tightly."""
    options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, **options}
    done = solve_ivp(rates, (run.time[0], run.time[-1]), start, t_eval=run.time, **options)
    assert done.success
    return done.y


def test_a_clutch_keeps_momentum_and_makes_heat():
    run = answer("clutch")
    shared = 0.2 * 100.0 / 0.5
    assert run.at_end("driving.shaft.flow") == pytest.approx(shared, rel=1e-6)
    assert run.at_end("driven.shaft.flow") == pytest.approx(shared, rel=1e-6)
    heat = 0.5 * (0.2 * 0.3 / 0.5) * 100.0**2
    assert energy_balance(run).dissipated == pytest.approx(heat, rel=1e-6)
    # While it slips, the torque is mu r z N(t) = 60 t / s up to 30 N.m.
    slipping = run.time < 0.5
    driven = 0.3 * 0.1 * 2.0 * 500.0 / 0.5 * run.time[slipping] ** 2 / 2 / 0.3
    np.testing.assert_allclose(run["driven.shaft.flow"][slipping], driven, atol=1e-6)


def test_a_spinning_body_keeps_momentum_and_follows_euler():
    run = answer("spinning_body")
    spin = np.stack([run[f"{axis}.shaft.flow"] for axis in ("first", "second", "third")])
    momentum = np.sqrt(np.sum((np.array([[1.0], [2.0], [3.0]]) * spin) ** 2, axis=0))
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)
    expected = simulated(lambda t, w: [-w[1] * w[2], w[0] * w[2], -w[0] * w[1] / 3.0], [0.01, 5.0, 0.0], run)
    np.testing.assert_allclose(spin, expected, atol=1e-5)


def test_a_half_car_by_its_mass_matrix():
    run = answer("half_car")
    k, c, arm = np.array([2.0e4, 2.5e4]), np.array([1.5e3, 1.8e3]), np.array([1.2, -1.5])
    ramps = ([0.1, 0.101, 0.2, 0.201], [0.235, 0.236, 0.335, 0.336])

    def rates(t, y):
        heave, pitch, pressed = y[0], y[1], y[2:]
        road = np.array([np.interp(t, at, [0.0, 0.4, 0.4, 0.0]) for at in ramps])
        slip = road - (heave + arm * pitch)
        force = k * pressed + c * slip
        return [force.sum() / 600.0, (arm * force).sum() / 900.0, *slip]

    expected = simulated(rates, np.zeros(4), run, max_step=1e-3, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(run["heave.flange.flow"], expected[0], atol=2e-5)
    np.testing.assert_allclose(run["pitch.shaft.flow"], expected[1], atol=2e-5)


def test_a_quarter_car_by_its_frequency_response():
    run = answer("quarter_car")
    s = 2j * math.pi
    suspension, tyre = 2.0e4 / s + 1.5e3, 2.4e5 / s + 1.5e2
    body, wheel = np.linalg.solve(
        [[1200 * s + suspension, -suspension], [-suspension, 80 * s + suspension + tyre]], [0, tyre]
    )
    late = run.time > 9.0
    wave = 0.2 * np.exp(s * run.time[late])
    np.testing.assert_allclose(run["body.flange.flow"][late], (body * wave).imag, atol=2e-3)
    np.testing.assert_allclose(run["wheel.flange.flow"][late], (wheel * wave).imag, atol=2e-3)


def test_a_hoist_by_two_equations():
    run = answer("hoist")
    R, L, k, r = 0.4, 2e-3, 0.2, 0.1 / 20.0
    inertia = 5e-3 + 100.0 * r * r

    def rates(t, y):
        voltage = np.interp(t, [0.0, 0.5], [10.0, 48.0])
        return [(voltage - R * y[0] - k * y[1]) / L, (k * y[0] - 1e-3 * y[1] - 100.0 * 9.80665 * r) / inertia]

    current, speed = simulated(rates, [0.0, 0.0], run, max_step=1e-2)
    np.testing.assert_allclose(run["motor.pin.flow"], current, atol=1e-5)
    np.testing.assert_allclose(run["load.flange.flow"], r * speed, atol=1e-7)


def test_a_driveline_by_three_equations():
    run = answer("torsional_driveline")

    def rates(t, y):
        w, twist = y[:3], y[3:]
        shafts = np.array([1e5, 5e3]) * twist + np.array([5.0, 10.0]) * -np.diff(w)
        torque = [100.0 - shafts[0], shafts[0] - shafts[1], shafts[1] - 0.5 * w[2]]
        return [*(np.array(torque) / [0.25, 0.05, 5.0]), *-np.diff(w)]

    expected = simulated(rates, np.zeros(5), run)
    np.testing.assert_allclose(run["engine.shaft.flow"], expected[0], atol=1e-4)
    np.testing.assert_allclose(run["wheels.shaft.flow"], expected[2], atol=1e-6)


def test_a_cruise_control_by_hand():
    run = answer("cruise_control")
    v, integral, h = 25.0, 0.0, 1e-3
    speeds = []
    for sample in range(401):
        speeds.append(v)
        free = 0.4 * (25.0 - v) + integral
        integral += 0.1 * 0.1 * (25.0 - v) if abs(free) < 1.0 else 0.0
        force = 4000.0 * min(max(free, -1.0), 1.0)
        for step in range(100):
            t = 0.1 * sample + h * step

            def rate(t, v, force=force):
                hill = np.interp(t, [10.0, 12.0], [0.0, -686.5])
                return (force + hill - 0.5 * 1.2 * 0.7 * v * v) / 1400.0

            v += h * rate(t + h / 2, v + h / 2 * rate(t, v))
    np.testing.assert_allclose(run["car.flange.flow"], speeds, atol=1e-6)


def test_a_tuned_absorber_by_the_frequency_response():
    run = answer("vibration_absorber")
    s = 2j * math.pi * 5.0
    spring, foundation = 9869.6044 / s + 2.0, 1.0e5 / s + 400.0
    machine, absorber = np.linalg.solve(
        [[100 * s + foundation + spring, -spring], [-spring, 10 * s + spring]], [100.0, 0.0]
    )
    late = run.time > 28.0
    wave = np.exp(s * run.time[late])
    np.testing.assert_allclose(run["machine.flange.flow"][late], (machine * wave).imag, atol=1e-3)
    np.testing.assert_allclose(run["absorber.flange.flow"][late], (absorber * wave).imag, atol=4e-3)
    assert abs(machine) < 0.02 * abs(absorber)


def test_a_maxwell_body_relaxes():
    run = answer("maxwell_body")
    k, tau = 1.0e4, 0.2
    pressed = np.minimum(run.time, 0.1)
    force = 0.1 * k * tau * (1 - np.exp(-pressed / tau)) * np.exp(-(run.time - pressed) / tau)
    np.testing.assert_allclose(run["spring.port.effort"], force, atol=0.1)  # the table goes to zero within 0.1 ms


def test_a_belt_drive_by_three_equations():
    run = answer("belt_drive")

    def rates(t, y):
        slip = 0.03 * y[0] - 0.09 * y[1]
        pull = 5.0e4 * y[2] + 20.0 * slip
        return [(1.0 - 0.03 * pull) / 0.002, (0.09 * pull - 0.05 * y[1]) / 0.05, slip]

    expected = simulated(rates, np.zeros(3), run)
    np.testing.assert_allclose(run["rotor.shaft.flow"], expected[0], atol=1e-5)
    np.testing.assert_allclose(run["spindle.shaft.flow"], expected[1], atol=1e-5)


def test_a_planetary_gear_by_lagrange_multipliers():
    run = answer("planetary_gear")
    z = 2.6
    row = np.array([1.0, -(1 + z), z])  # w_sun - (1 + z) w_carrier + z w_ring = 0
    matrix = np.block([[np.diag([0.02, 0.2, 8.0]), row[:, None]], [row, np.zeros(1)]])
    acceleration = np.linalg.solve(matrix, [-20.0, 80.0, 0.0, 0.0])[:3]
    for name, expected in zip(("generator_rotor", "crankshaft", "wheels"), acceleration, strict=True):
        np.testing.assert_allclose(run[f"{name}.shaft.flow"], expected * run.time, rtol=1e-9, atol=1e-9)


def test_the_period_of_a_hardening_spring():
    run = answer("duffing_oscillator")
    start, k, k3 = 0.1, 100.0, 4.0e4
    frequency = math.sqrt(k + k3 * start**2)
    modulus = k3 * start**2 / (2 * (k + k3 * start**2))
    # The solution is a Jacobi elliptic cosine (Kovacic and Brennan, The Duffing Equation, ch. 2).
    expected = start * ellipj(frequency * run.time, modulus)[1]
    np.testing.assert_allclose(run["spring.port.displacement"], expected, atol=1e-7)
    period = 4 * ellipk(modulus) / frequency
    assert 1.9 < 2 * math.pi / math.sqrt(k) / period < 2.0  # what the docstring says


def test_coupled_pendulums_beat():
    run = answer("coupled_pendulums")

    def rates(t, y):
        weight = 0.5 * 9.80665 * np.sin(y[2:])
        twist = 0.5 * (y[2] - y[3])
        return [(-weight[0] - twist) / 0.25, (-weight[1] + twist) / 0.25, y[0], y[1]]

    expected = simulated(rates, [0.0, 0.0, 0.05, 0.0], run)
    np.testing.assert_allclose(run["left_weight.shaft.displacement"], expected[2], atol=1e-7)
    np.testing.assert_allclose(run["right_weight.shaft.displacement"], expected[3], atol=1e-7)


def test_a_flywheel_runs_down():
    run = answer("stribeck_bearing")

    def rates(t, w):
        return -((1.0 + 0.6 * np.exp(-((w / 2.0) ** 2))) * np.tanh(w / 0.1) + 0.03 * w) / 0.5

    expected = simulated(rates, [40.0], run, max_step=0.01)
    np.testing.assert_allclose(run["flywheel.shaft.flow"], expected[0], atol=1e-5)


def test_a_gas_spring_is_between_isothermal_and_adiabatic():
    run = answer("gas_spring")
    m, V0, A, p0, T0, gamma = 300.0, 1e-3, 2e-3, 1.5e6, 300.0, 1.4
    gas = p0 * V0 / T0
    heat_capacity = gas / (gamma - 1)

    def rates(t, y):
        v, x, T = y
        V = V0 - A * x
        p = gas * T / V
        return [-(p - p0) * A / m, v, (p * A * v - 0.05 * (T - T0)) / heat_capacity]

    expected = simulated(rates, [0.05, 0.0, 300.0], run)
    np.testing.assert_allclose(run["gas.compression"], expected[1], atol=1e-7)
    np.testing.assert_allclose(run["gas.temperature"], expected[2], atol=1e-4)


def test_a_pendulum_by_transformers_is_one_in_its_angle():
    run = answer("pendulum_by_transformers")
    inertia, weight = 0.02 + 2.0 * 0.25, 2.0 * 9.80665 * 0.5
    expected = simulated(lambda t, y: [-weight * math.sin(y[1]) / inertia, y[0]], [6.0, 0.0], run)
    np.testing.assert_allclose(run["sensor.angle"], expected[1], atol=1e-7)
    np.testing.assert_allclose(run["bob_x.flange.flow"], 0.5 * np.cos(expected[1]) * expected[0], atol=1e-6)
    np.testing.assert_allclose(run["bob_y.flange.flow"], 0.5 * np.sin(expected[1]) * expected[0], atol=1e-6)
    assert expected[1].max() == pytest.approx(math.acos(1 - inertia * 36.0 / 2 / weight), abs=1e-4)


def test_a_pendulum_on_a_spring_in_cartesian_coordinates():
    run = answer("pendulum_on_a_spring")

    def rates(t, y):
        place = y[2:]
        distance = np.hypot(*place)
        pull = -2.0e4 * (distance - 0.5) * place / distance
        return [pull[0] / 2.0, pull[1] / 2.0 - 9.80665, *y[:2]]

    expected = simulated(rates, [0.0, 0.0, 0.5, 0.0], run, rtol=1e-12)
    np.testing.assert_allclose(run["x.position"], expected[2], atol=1e-5)
    np.testing.assert_allclose(run["y.position"], expected[3], atol=1e-5)
    # It is nearly a rigid pendulum: the angle of the period agrees with the elliptic integral.
    period = 4 * math.sqrt(0.5 / 9.80665) * ellipk(math.sin(math.pi / 4) ** 2)
    back = run.time[50:][run["x.position"][50:].argmax()]
    assert back % period == pytest.approx(0.0, abs=0.05) or back % period == pytest.approx(period, abs=0.05)


def test_a_slider_crank_by_lagranges_equation():
    run = answer("slider_crank")
    r, rod, J, m = 0.05, 0.15, 0.02, 2.0

    def slope(angle):
        return -r * math.sin(angle) * (1 + r * math.cos(angle) / math.sqrt(rod**2 - (r * math.sin(angle)) ** 2))

    def rates(t, y):
        speed, angle = y
        k, bend = slope(angle), (slope(angle + 1e-6) - slope(angle - 1e-6)) / 2e-6
        return [(2.0 - 0.05 * speed - m * k * bend * speed**2) / (J + m * k * k), speed]

    expected = simulated(rates, [20.0, 0.0], run, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run["flywheel.shaft.flow"], expected[0], atol=1e-5)
    pistons = [slope(angle) * speed for speed, angle in expected.T]
    np.testing.assert_allclose(run["piston.flange.flow"], pistons, atol=1e-6)


def test_a_ball_keeps_the_height_and_period_of_its_bounces():
    run = answer("ball_on_elastic_floor")
    m, k, g, h = 0.2, 2.0e5, 9.80665, 0.5
    speed, w = math.sqrt(2 * g * h), math.sqrt(k / m)
    # In contact the ball swings about its static depth g / w^2.
    contact = 2 * (math.pi - math.atan2(speed, g / w)) / w
    period = 2 * speed / g + contact
    t = run.time % period
    flight = t < 2 * speed / g + contact - 1e-3
    falling = flight & (t < speed / g - 1e-3)
    rising = flight & (t > speed / g + contact + 1e-3)
    height = 0.5 - run["contact.port.displacement"]
    np.testing.assert_allclose(height[falling], h - g * t[falling] ** 2 / 2, atol=2e-4)
    np.testing.assert_allclose(height[rising], h - g * (period - t[rising]) ** 2 / 2, atol=2e-4)
