"""Mechanisms of bodies, bars and joints against closed forms and Lagrange's equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import propermodel as pm
from propermodel.modelling.documents import from_document, to_document
from tests.physics.frames import (
    BeadInTube,
    DoublePendulum,
    DoublePendulumFromBelow,
    ElasticPendulum,
    FourBar,
    LoopOnSpring,
    Pendulum,
    PendulumOnCart,
    PushedBody,
    Satellite,
    Slider,
    ThrownBody,
)
from tests.physics.systems import run

G = 9.80665


def integrated(rates, start, time: np.ndarray) -> np.ndarray:
    """The solution of an independent system at some instants."""
    return solve_ivp(rates, (time[0], time[-1]), start, rtol=1e-11, atol=1e-12, t_eval=time).y


# -- trees ------------------------------------------------------------------------------------------------


def test_pendulum_swings_with_the_period_of_the_elliptic_integral() -> None:
    # Let go level at rest, 90 degrees from below: T = 4 sqrt(I / (m g l)) K(sin^2(45 degrees)), I about the hinge.
    inertia = 0.1 + 2.0 * 0.8**2
    period = 4.0 * math.sqrt(inertia / (2.0 * G * 0.8)) * ellipk(0.5)
    swing = run(Pendulum(), period, every=period / 2.0)
    assert len(swing.compiled.system.states) == 2
    assert swing["hinge.angle"][1] == pytest.approx(-math.pi, abs=1e-9)
    assert swing["hinge.angle"][2] == pytest.approx(0.0, abs=1e-9)
    assert swing["sensor.x"] == pytest.approx([1.8, 0.2, 1.8], abs=1e-9)
    assert swing["sensor.y"] == pytest.approx([2.0, 2.0, 2.0], abs=1e-9)


def test_pendulum_pulls_at_its_hinge() -> None:
    # At the bottom: m g + m l w^2, with w^2 = 2 m g l / I.
    inertia = 0.1 + 2.0 * 0.8**2
    swing = run(Pendulum(), 2.0, every=1e-3)
    expected = 2.0 * G + 2.0 * 0.8 * (2.0 * 2.0 * G * 0.8 / inertia)
    assert np.abs(swing["ground.frame_y.effort"]).max() == pytest.approx(expected, rel=1e-5)


def double_pendulum(_: float, y: np.ndarray) -> list[float]:
    """Lagrange's equations in the angles of both bars from the x axis."""
    (p, q, wp, wq), a, b, m, n = y, 0.8, 0.6, 2.0, 1.0
    coupling = n * a * b
    matrix = [
        [0.1 + (m + n) * a * a, coupling * math.cos(p - q)],
        [coupling * math.cos(p - q), 0.05 + n * b * b],
    ]
    right = [
        -coupling * math.sin(p - q) * wq * wq - (m + n) * G * a * math.cos(p),
        coupling * math.sin(p - q) * wp * wp - n * G * b * math.cos(q),
    ]
    return [wp, wq, *np.linalg.solve(matrix, right)]


@pytest.mark.parametrize("model", [DoublePendulum, DoublePendulumFromBelow])
def test_double_pendulum_follows_lagrange_in_whatever_order_it_is_written(model: type[pm.Component]) -> None:
    swing = run(model(), 2.0, step=2.5e-4)
    expected = integrated(double_pendulum, [0.5, -0.2, 0.0, 0.0], swing.time)
    assert swing["upper_hinge.angle"] == pytest.approx(expected[0], abs=1e-7)
    assert swing["upper_hinge.angle"] + swing["lower_hinge.angle"] == pytest.approx(expected[1], abs=1e-7)
    assert swing["lower.inertia.shaft.flow"] == pytest.approx(expected[3], abs=1e-6)
    assert len(swing.compiled.system.states) == 4
    assert not swing.compiled.system.closures
    assert pm.energy_balance(swing).relative_residual < 1e-9


def test_a_thrown_body_flies_a_parabola_and_turns() -> None:
    flight = run(ThrownBody(), 1.0, step=1e-3)
    t = flight.time
    angle = 0.5 + 5.0 * t
    x = 1.0 + 3.0 * t + 0.2 * np.cos(angle) - 0.1 * np.sin(angle)
    y = 2.0 + 4.0 * t - 0.5 * G * t * t + 0.2 * np.sin(angle) + 0.1 * np.cos(angle)
    assert flight["sensor.angle"] == pytest.approx(angle, abs=1e-9)
    assert flight["sensor.x"] == pytest.approx(x, abs=1e-9)
    assert flight["sensor.y"] == pytest.approx(y, abs=1e-9)
    across = 5.0 * (0.2 * np.cos(angle) - 0.1 * np.sin(angle))
    assert flight["sensor.velocity_y"] == pytest.approx(4.0 - G * t + across, abs=1e-9)
    assert flight["sensor.angular_velocity"] == pytest.approx(np.full_like(t, 5.0), abs=1e-9)


def test_a_force_beside_the_centre_of_gravity_turns_a_body() -> None:
    pushed = run(PushedBody(), 2.0, inputs={"force_x": 1.5, "force_y": 0.5, "torque": 0.2})
    t = pushed.time

    def rates(_: float, y: np.ndarray) -> list[float]:
        x, z = 0.2 * math.cos(y[0]) - 0.1 * math.sin(y[0]), 0.2 * math.sin(y[0]) + 0.1 * math.cos(y[0])
        return [y[1], (0.2 + x * 0.5 - z * 1.5) / 0.3]

    angle, speed = integrated(rates, [0.0, 0.0], t)
    assert pushed["motion.turning.angle"] == pytest.approx(angle, abs=1e-8)
    assert pushed["body.inertia.shaft.flow"] == pytest.approx(speed, abs=1e-8)
    assert pushed["motion.along.position"] == pytest.approx(0.5 * 1.5 / 2.0 * t * t, abs=1e-9)
    assert pushed["motion.upward.velocity"] == pytest.approx(0.5 / 2.0 * t, abs=1e-9)


def test_a_motor_turns_two_bodies_against_each_other() -> None:
    turning = run(Satellite(), 1.0, inputs={"torque": 0.3})
    t = turning.time
    assert turning["wheel.inertia.shaft.flow"] == pytest.approx(0.3 / 0.1 * t, abs=1e-9)
    assert turning["body.inertia.shaft.flow"] == pytest.approx(-0.3 / 0.3 * t, abs=1e-9)
    assert turning["hinge.angle"] == pytest.approx(0.5 * (3.0 + 1.0) * t * t, abs=1e-9)
    assert turning["hinge.speed"] == pytest.approx(4.0 * t, abs=1e-9)


# -- slides -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [0.0, 0.5, math.pi / 2.0, math.pi, -2.0])
def test_a_body_slides_in_any_direction(slope: float) -> None:
    sliding = run(Slider(slope=slope), 1.0)
    t = sliding.time
    assert sliding["slide.position"] == pytest.approx(-0.5 * G * math.sin(slope) * t * t, abs=1e-9)
    # The guide carries what acts across it.
    force = sliding["ground.frame_x.effort"], sliding["ground.frame_y.effort"]
    across = math.cos(slope) * force[1] - math.sin(slope) * force[0]
    assert np.abs(across[1:]) == pytest.approx(np.full(len(t) - 1, 3.0 * G * abs(math.cos(slope))), abs=1e-9)
    assert np.abs(sliding["slide.joint.slide.displacement.gap"]).max() < 1e-12


def test_a_pendulum_on_a_cart_on_a_slope_follows_lagrange() -> None:
    slope, cart, bob, length, inertia = 0.4, 3.0, 2.0, 0.8, 0.1

    def rates(_: float, y: np.ndarray) -> list[float]:
        _, angle, speed, turning = y
        # The bob moves with speed along the slope, and across its bar, whose normal is at angle + 90 degrees.
        coupling = bob * length * math.sin(slope - angle)
        matrix = [[cart + bob, coupling], [coupling, inertia + bob * length * length]]
        right = [
            bob * length * math.cos(slope - angle) * turning * turning - (cart + bob) * G * math.sin(slope),
            -bob * G * length * math.cos(angle),
        ]
        return [speed, turning, *np.linalg.solve(matrix, right)]

    rolling = run(PendulumOnCart(), 2.0, step=5e-4)
    expected = integrated(rates, [0.3, -1.0, 0.0, 0.0], rolling.time)
    assert rolling["slide.position"] == pytest.approx(expected[0], abs=1e-7)
    assert rolling["hinge.angle"] == pytest.approx(expected[1], abs=1e-7)
    assert pm.energy_balance(rolling).relative_residual < 1e-8


@pytest.mark.parametrize(("stiffness", "damping"), [(0.0, 0.0), (40.0, 0.0), (40.0, 0.6)])
def test_a_bead_in_a_turning_tube_feels_centrifugal_and_coriolis_forces(stiffness: float, damping: float) -> None:
    def rates(_: float, y: np.ndarray) -> list[float]:
        out, speed, _, turning = y
        inertia = 0.1 + 0.01 + 0.5 * out * out
        force = -stiffness * (out - 0.2) - damping * speed
        return [speed, out * turning * turning + force / 0.5, turning, -2.0 * 0.5 * out * speed * turning / inertia]

    start = {"tube.inertia.momentum": 0.4}
    moving = run(BeadInTube(stiffness=stiffness, damping=damping), 2.0, step=5e-4, initial=start)
    assert moving.at_start("tube.inertia.shaft.flow") == pytest.approx(4.0)
    expected = integrated(rates, [0.2, 0.0, 0.3, 4.0], moving.time)
    assert moving["slide.position"] == pytest.approx(expected[0], abs=1e-7)
    assert moving["hinge.angle"] == pytest.approx(expected[2], abs=1e-7)
    assert moving["tube.inertia.shaft.flow"] == pytest.approx(expected[3], abs=1e-6)
    assert abs(pm.energy_balance(moving).integration_residual) < 1e-10


# -- springs ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damping", [0.0, 1.5])
def test_a_body_on_a_spring_follows_newton(damping: float) -> None:
    def rates(_: float, y: np.ndarray) -> list[float]:
        away, speed = y[:2] - [0.5, 2.0], y[2:]
        distance = math.hypot(*away)
        along = away / distance
        tension = 80.0 * (distance - 1.0) + damping * along @ speed
        return [*speed, *(-tension / 2.0 * along - [0.0, G])]

    moving = run(ElasticPendulum(damping=damping), 2.0, step=5e-4)
    x, y, *_ = integrated(rates, [1.7, 1.6, 0.0, 0.0], moving.time)
    assert moving.at_start("rope.spring.port.effort") == pytest.approx(80.0 * (math.hypot(1.2, 0.4) - 1.0))
    assert moving["motion.along.position"] == pytest.approx(x, abs=1e-7)
    assert moving["motion.upward.position"] == pytest.approx(y, abs=1e-7)
    stretch = np.hypot(x - 0.5, y - 2.0) - 1.0
    assert moving["rope.spring.displacement"] == pytest.approx(stretch, abs=1e-7)
    assert abs(pm.energy_balance(moving).integration_residual) < 1e-8


def test_a_spring_starts_stretched_as_the_closed_loop_has_it() -> None:
    moving = run(LoopOnSpring(), 0.5, step=5e-4)
    assert "were open" in moving.notes[0]
    angle = moving["second_hinge.angle"]
    assert abs(angle[0] - 2.2) > 1e-3
    stretch = np.hypot(1.2 + np.cos(angle), np.sin(angle)) - 0.2
    assert moving.at_start("spring.spring.displacement") == pytest.approx(stretch[0], abs=1e-11)
    assert moving["spring.spring.displacement"] == pytest.approx(stretch, abs=1e-8)
    assert np.ptp(stretch) > 0.1


# -- loops ------------------------------------------------------------------------------------------------


def four_bar(angle: float) -> tuple[float, float]:
    """The angles of coupler and rocker for one of the crank, by the intersection of two circles."""
    x, y = 0.2 * math.cos(angle) - 0.5, 0.2 * math.sin(angle)
    reach = math.hypot(x, y)
    at_base = math.acos((reach * reach + 0.4**2 - 0.5**2) / (2.0 * reach * 0.4))
    rocker = math.atan2(y, x) - at_base
    return math.atan2(0.4 * math.sin(rocker) - y, 0.4 * math.cos(rocker) - x), rocker


def test_four_bar_of_frames_follows_the_equation_of_its_crank() -> None:
    def slopes(angle: float) -> np.ndarray:
        return np.subtract(four_bar(angle + 1e-5), four_bar(angle - 1e-5)) / 2e-5

    def inertia(angle: float) -> float:
        # The body of the crank is at its end, with that of the coupler; the body of the rocker turns about its hinge.
        coupler, rocker = slopes(angle)
        return 0.1 + 1.5 * 0.2**2 + 0.2 * coupler**2 + 0.3 * rocker**2

    def rates(_: float, y: np.ndarray) -> list[float]:
        slope = (inertia(y[0] + 1e-3) - inertia(y[0] - 1e-3)) / 2e-3
        weight = 1.5 * G * 0.2 * math.cos(y[0])
        return [y[1], (-0.5 * slope * y[1] ** 2 - weight) / inertia(y[0])]

    start = {"crank_hinge.joint.motion.counter.turned": 1.0, "crank_body.inertia.momentum": 0.8}
    turning = run(FourBar(), 2.0, step=5e-4, initial=start)
    expected = solve_ivp(rates, (0.0, 2.0), [1.0, 8.0], rtol=1e-9, atol=1e-10, t_eval=turning.time).y
    assert turning["crank_hinge.angle"] == pytest.approx(expected[0], abs=1e-4)
    assert turning["crank_hinge.angle"][-1] > 2.0 * math.pi
    coupler, rocker = np.array([four_bar(angle) for angle in turning["crank_hinge.angle"]]).T
    assert np.cos(turning["rocker_hinge.angle"]) == pytest.approx(np.cos(rocker), abs=1e-9)
    assert np.cos(turning["crank_hinge.angle"] + turning["coupler_hinge.angle"]) == pytest.approx(
        np.cos(coupler), abs=1e-9
    )
    assert np.abs(turning["pin.between.displacement.gap_x"]).max() < 1e-11
    assert pm.energy_balance(turning).relative_residual < 1e-7
    # What a hinge carries on one side it carries on the other.
    assert turning["pin.a_x.effort"] == pytest.approx(-turning["pin.b_x.effort"], abs=1e-9)


def test_mechanism_of_frames_survives_its_document() -> None:
    model = pm.elaborate(FourBar())
    assert from_document(to_document(model)) == model
