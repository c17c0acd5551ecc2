"""Examples that close kinematic loops, against closed forms and equations written by hand in other coordinates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

from tests.examples.runs import answer


def test_a_pendulum_on_a_rod_swings_with_the_period_of_its_angle_and_does_not_drift():
    run = answer("pendulum_on_a_rod")
    length, g = 0.5, 9.80665
    x, y = run["rod.displacement.point_x"], run["rod.displacement.point_y"]
    assert np.abs(np.hypot(x, y) - length).max() < 1e-12
    # sin(angle / 2) = k sn(w t + K): the angle of a pendulum that is let go where sin(angle / 2) = k.
    half = math.sin(math.pi / 4)
    swing = half * ellipj(math.sqrt(g / length) * run.time + ellipk(half**2), half**2)[0]
    angle = 2.0 * np.arcsin(swing)
    np.testing.assert_allclose(x, length * np.sin(angle), atol=1e-6)
    np.testing.assert_allclose(y, -length * np.cos(angle), atol=1e-6)
    # The pull is m v^2 / l + m g cos(angle), with v^2 = 2 g l cos(angle).
    np.testing.assert_allclose(-run["rod.excess.effort"], 3.0 * 2.0 * g * np.cos(angle), atol=2e-4)


def test_a_slider_crank_chain_by_lagranges_equation_in_the_crank_angle():
    run = answer("slider_crank_chain")
    r, length = 0.05, 0.15

    def slopes(angle):
        along = math.sqrt(length**2 - (r * math.sin(angle)) ** 2)
        rod = -r * math.cos(angle) / along
        return rod, -r * math.sin(angle) + r * math.sin(angle) * rod

    def inertia(angle):
        rod, piston = slopes(angle)
        return 0.02 + 0.002 * rod**2 + 2.0 * piston**2

    def rates(t, y):
        bend = (inertia(y[0] + 1e-5) - inertia(y[0] - 1e-5)) / 2e-5
        return [y[1], (2.0 - 0.05 * y[1] - 0.5 * bend * y[1] ** 2) / inertia(y[0])]

    angle, speed = solve_ivp(rates, (0.0, 1.0), [0.3, 20.0], "DOP853", run.time, rtol=1e-10, atol=1e-12).y
    np.testing.assert_allclose(run["flywheel.shaft.flow"], speed, atol=2e-5)
    rod, piston = np.array([slopes(a) for a in angle]).T * speed
    np.testing.assert_allclose(run["rod.shaft.flow"], rod, atol=2e-5)
    np.testing.assert_allclose(run["piston.flange.flow"], piston, atol=2e-5)
    assert angle[-1] > 4 * math.pi
    assert np.abs(run["chain.displacement.gap_y"]).max() < 1e-12


def test_a_four_bar_linkage_by_freudensteins_equation_and_its_energy():
    run = answer("four_bar_linkage")
    a, b, c, d = 0.2, 0.5, 0.4, 0.5
    crank, rocker = run["loop.displacement.crank"], run["loop.displacement.rocker"]
    # Freudenstein: the coupler's length does not change.
    ends = np.hypot(d + c * np.cos(rocker) - a * np.cos(crank), c * np.sin(rocker) - a * np.sin(crank))
    np.testing.assert_allclose(ends, b, atol=1e-11)

    def rocker_at(angle):
        def gap(q):
            return math.hypot(d + c * math.cos(q) - a * math.cos(angle), c * math.sin(q) - a * math.sin(angle)) - b

        return brentq(gap, 0.5, math.pi, xtol=1e-14)

    np.testing.assert_allclose(rocker[::50], [rocker_at(angle) for angle in crank[::50]], atol=1e-10)
    # The extremes, where crank and coupler lie in one line: a triangle with the sides b + a or b - a, c and d.
    for reach, extreme in ((b + a, rocker.min()), (b - a, rocker.max())):
        corner = math.acos((c * c + d * d - reach * reach) / (2 * c * d))
        assert extreme == pytest.approx(math.pi - corner, abs=1e-4)
    assert crank[-1] - crank[0] > 2 * math.pi
    parts = ((0.1, "crank"), (0.02, "coupler"), (0.05, "rocker"))
    kinetic = sum(0.5 * inertia * run[f"{name}.shaft.flow"] ** 2 for inertia, name in parts)
    np.testing.assert_allclose(kinetic, kinetic[0], rtol=1e-8)
    # The speed of the rocker by differences of its angle.
    np.testing.assert_allclose(
        run["rocker.shaft.flow"][1:-1], (rocker[2:] - rocker[:-2]) / (run.time[2:] - run.time[:-2]), atol=2e-3
    )


def test_a_four_bar_linkage_by_lagranges_equation_in_the_crank_angle():
    run = answer("four_bar_linkage")
    a, b, c, d = 0.2, 0.5, 0.4, 0.5

    def slopes(angle):
        # The triangle over the diagonal from the crank's end to the rocker's hinge.
        x, y = d - a * math.cos(angle), -a * math.sin(angle)
        diagonal = math.hypot(x, y)
        lean = math.acos((diagonal**2 + b * b - c * c) / (2 * diagonal * b))
        coupler = math.atan2(y, x) + lean
        rocker = math.atan2(b * math.sin(coupler) - y, b * math.cos(coupler) - x)
        return (
            a * math.sin(angle - rocker) / (b * math.sin(rocker - coupler)),
            a * math.sin(angle - coupler) / (c * math.sin(rocker - coupler)),
        )

    def inertia(angle):
        coupler, rocker = slopes(angle)
        return 0.1 + 0.02 * coupler**2 + 0.05 * rocker**2

    # Nothing drives it, so inertia(angle) speed^2 is kept.
    angle, speed = run["loop.displacement.crank"], run["crank.shaft.flow"]
    level = inertia(1.0) * 25.0
    np.testing.assert_allclose(speed, [math.sqrt(level / inertia(q)) for q in angle], atol=1e-7)
    coupler, rocker = np.array([slopes(q) for q in angle]).T * speed
    np.testing.assert_allclose(run["coupler.shaft.flow"], coupler, atol=1e-8)
    np.testing.assert_allclose(run["rocker.shaft.flow"], rocker, atol=1e-8)


def test_a_double_pendulum_by_lagranges_equations_in_its_angles():
    run = answer("double_pendulum")
    a, b, m, n, g = 0.8, 0.6, 2.0, 1.0, 9.80665

    def rates(t, y):
        p, q, wp, wq = y
        across, along = n * a * b * math.cos(p - q), n * a * b * math.sin(p - q)
        matrix = [[0.02 + (m + n) * a * a, across], [across, 0.01 + n * b * b]]
        right = [-along * wq**2 - (m + n) * g * a * math.cos(p), along * wp**2 - n * g * b * math.cos(q)]
        return [wp, wq, *np.linalg.solve(matrix, right)]

    upper, lower, upper_speed, lower_speed = solve_ivp(
        rates, (0.0, 4.0), [1.6, 1.5, 0.0, 0.0], "DOP853", run.time, rtol=1e-12, atol=1e-12
    ).y
    np.testing.assert_allclose(run["shoulder.angle"], upper, atol=1e-6)
    np.testing.assert_allclose(run["shoulder.angle"] + run["elbow.angle"], lower, atol=1e-6)
    assert np.ptp(run["elbow.angle"]) > 2 * math.pi  # the forearm goes round
    # The ceiling carries the weight and what accelerates both bodies upwards.
    bends = np.array([rates(0.0, y)[2:] for y in zip(upper, lower, upper_speed, lower_speed, strict=True)]).T
    force = (m + n) * (g + a * (np.cos(upper) * bends[0] - np.sin(upper) * upper_speed**2))
    force += n * b * (np.cos(lower) * bends[1] - np.sin(lower) * lower_speed**2)
    np.testing.assert_allclose(np.abs(run["ceiling.frame_y.effort"]), np.abs(force), atol=1e-4)
