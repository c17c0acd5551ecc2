"""Closed kinematic loops against closed forms and independent solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import propermodel as pm
from propermodel.compiler import Backend
from propermodel.modelling.documents import from_document, to_document
from tests.physics.mechanisms import (
    GRAVITY,
    CartesianPendulum,
    DoublePendulum,
    FourBar,
    LightRodSliderCrank,
    MassOnParabola,
    SliderCrank,
    SumWithAHeldInput,
)
from tests.physics.systems import run


def energy(trajectory: pm.Trajectory) -> np.ndarray:
    """Kinetic and potential energy of the pendulum's bob, J."""
    squares = trajectory["bob.along.flange.flow"] ** 2 + trajectory["bob.upward.flange.flow"] ** 2
    return squares + 2.0 * GRAVITY * trajectory["rod.displacement.point_y"]


def test_cartesian_pendulum_swings_with_the_period_of_the_elliptic_integral() -> None:
    # Released at rest from the horizontal: T = 4 sqrt(l / g) K(sin^2(45 degrees)).
    period = 4.0 * math.sqrt(1.0 / GRAVITY) * ellipk(math.sin(math.pi / 4.0) ** 2)
    swing = run(CartesianPendulum(), period, step=1e-3, every=period / 2.0)
    assert swing["rod.displacement.point_x"][1] == pytest.approx(-1.0, abs=1e-8)
    assert swing["rod.displacement.point_x"][2] == pytest.approx(1.0, abs=1e-8)
    assert abs(swing["bob.along.flange.flow"][2]) < 1e-6


def test_cartesian_pendulum_stays_on_its_circle_and_keeps_its_energy_for_100_s() -> None:
    swing = run(CartesianPendulum(), 100.0, step=1e-3, every=0.01)
    assert np.abs(swing["rod.displacement.excess"]).max() < 1e-12
    assert np.abs(energy(swing)).max() < 1e-8
    # The rod pulls with m v^2 / l + m g sin: three times the weight at the bottom.
    assert -swing["rod.excess.effort"].min() == pytest.approx(3.0 * 2.0 * GRAVITY, rel=1e-4)


def test_cartesian_pendulum_turns_over() -> None:
    # Faster than sqrt(5 g l) at the bottom it goes all the way round, through y = 0 and overhead.
    start = {"rod.displacement.point_x": 0.0, "rod.displacement.point_y": -1.0, "bob.along.momentum": 16.0}
    turning = run(CartesianPendulum(), 5.0, step=1e-3, every=0.001, initial=start)
    angle = np.unwrap(np.arctan2(turning["rod.displacement.point_x"], -turning["rod.displacement.point_y"]))
    assert angle[-1] > 4.0 * math.pi
    assert np.all(np.diff(angle) > 0.0)
    assert turning["rod.displacement.point_y"].max() == pytest.approx(1.0, abs=1e-4)
    assert np.ptp(energy(turning)) < 1e-7
    assert np.abs(turning["rod.displacement.excess"]).max() < 1e-12


@pytest.mark.parametrize("method", list(pm.Method))
def test_backends_agree_on_a_constraint(method: pm.Method) -> None:
    ends = [
        run(CartesianPendulum(), 0.3, step=1e-3, method=method, backend=backend).final_signals for backend in Backend
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("jacobian_every", [1, 4])
def test_implicit_steps_keep_their_order_on_a_constraint(jacobian_every: int) -> None:
    model = pm.compile_model(pm.elaborate(CartesianPendulum()))
    start = {"rod.displacement.point_x": 0.0, "rod.displacement.point_y": -1.0, "bob.along.momentum": 8.0}
    exact = run(model, 1.0, step=5e-4, every=1.0, initial=start).memory.state
    errors = [
        np.abs(
            run(
                model,
                1.0,
                step=step,
                method=pm.Method.ROS2,
                jacobian_every=jacobian_every,
                every=1.0,
                initial=start,
            ).memory.state
            - exact
        ).max()
        for step in (4e-3, 2e-3)
    ]
    assert errors[1] < 3e-4
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


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


def test_slider_crank_follows_its_reduced_equation() -> None:
    # M(a) a'' + M'(a) a'^2 / 2 = torque - d a', with the rod angle and the piston as functions of the crank angle a.
    r, l, torque, damping = 0.05, 0.15, 2.0, 0.05

    def inertia(a: float) -> float:
        rod = -r * math.cos(a) / math.sqrt(l * l - (r * math.sin(a)) ** 2)
        piston = -r * math.sin(a) - r * math.sin(a) * r * math.cos(a) / math.sqrt(l * l - (r * math.sin(a)) ** 2)
        return 0.02 + 0.001 * rod * rod + 2.0 * piston * piston

    def rates(_: float, y: np.ndarray) -> list[float]:
        slope = (inertia(y[0] + 1e-5) - inertia(y[0] - 1e-5)) / 2e-5
        return [y[1], (torque - damping * y[1] - 0.5 * slope * y[1] * y[1]) / inertia(y[0])]

    start = {"linkage.displacement.crank": 0.3, "wheel.momentum": 0.4}
    turning = run(SliderCrank(), 1.0, step=2e-4, initial=start, inputs={"torque": torque})
    expected = solve_ivp(rates, (0.0, 1.0), [0.3, 20.0], rtol=1e-10, atol=1e-12, t_eval=turning.time)
    assert turning["linkage.displacement.crank"] == pytest.approx(expected.y[0], abs=2e-6)
    assert turning["wheel.shaft.flow"] == pytest.approx(expected.y[1], abs=2e-5)
    assert turning["linkage.displacement.crank"][-1] > 4.0 * math.pi  # through both dead centres
    assert np.abs(turning["linkage.displacement.gap_y"]).max() < 1e-12
    balance = pm.energy_balance(turning)
    assert balance.relative_residual < 1e-8


def test_slider_crank_with_a_light_rod_follows_its_reduced_equation() -> None:
    r, l = 0.05, 0.15
    turning = run(LightRodSliderCrank(), 1.0, step=2e-4)
    a, speed = turning["linkage.displacement.crank"], turning["wheel.shaft.flow"]
    piston = -r * np.sin(a) - r * np.sin(a) * r * np.cos(a) / np.sqrt(l * l - (r * np.sin(a)) ** 2)
    assert turning["piston.flange.flow"] == pytest.approx(piston * speed, abs=1e-9)
    energy = 0.5 * (0.02 + 2.0 * piston * piston) * speed * speed
    assert energy == pytest.approx(np.full_like(energy, energy[0]), rel=1e-7)
    assert np.abs(turning["linkage.displacement.gap_y"]).max() < 1e-12
    assert turning.compiled.system.causal.constraints == ()


def test_four_bar_follows_multipliers_in_all_coordinates() -> None:
    lengths, inertias = np.array([0.2, 0.5, -0.4]), np.array([0.1, 0.2, 0.3])

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q, w = y[:3], y[3:]
        slopes = np.array([-lengths * np.sin(q), lengths * np.cos(q)])
        turned = np.array([-lengths * np.cos(q), -lengths * np.sin(q)]) @ (w * w)
        matrix = slopes @ (slopes.T / inertias[:, None])
        efforts = np.linalg.solve(matrix, -turned)
        return np.concatenate([w, (slopes.T @ efforts) / inertias])

    turning = run(FourBar(), 3.0, step=5e-4, initial={"loop.displacement.crank": 1.0, "crank.momentum": 0.5})
    names = ("crank", "coupler", "rocker")
    q = [turning[f"loop.displacement.{name}"] for name in names]
    w = [turning[f"{name}.shaft.flow"] for name in names]
    assert q[0][0] == 1.0
    assert w[0][0] == 5.0
    start = np.array([column[0] for column in (*q, *w)])
    expected = solve_ivp(rates, (0.0, 3.0), start, rtol=1e-11, atol=1e-12, t_eval=turning.time)
    for column, independent in zip((*q, *w), expected.y, strict=True):
        assert column == pytest.approx(independent, abs=2e-7)
    assert q[0][-1] > 2.0 * math.pi
    assert pm.energy_balance(turning).relative_residual < 1e-4


def test_four_bar_does_not_drift_in_100_s() -> None:
    start = {"loop.displacement.crank": 1.0, "crank.momentum": 0.5}
    turning = run(FourBar(), 100.0, step=1e-3, every=0.1, initial=start)
    assert np.abs(turning["loop.displacement.gap_x"]).max() < 1e-9
    assert np.abs(turning["loop.displacement.gap_y"]).max() < 1e-9
    kinetic = sum(
        0.5 * j * turning[f"{name}.shaft.flow"] ** 2 for name, j in (("crank", 0.1), ("coupler", 0.2), ("rocker", 0.3))
    )
    assert np.ptp(kinetic) < 1e-6 * kinetic[0]


def test_double_pendulum_keeps_both_rods_and_its_energy() -> None:
    swing = run(DoublePendulum(), 10.0, step=5e-4, every=0.01)
    total = 0.0
    for name, mass, y in (("upper", 2.0, "first.displacement.point_y"), ("lower", 1.0, "second.displacement.b_y")):
        squares = swing[f"{name}.along.flange.flow"] ** 2 + swing[f"{name}.upward.flange.flow"] ** 2
        total = total + 0.5 * mass * squares + mass * GRAVITY * swing[y]
    assert np.ptp(total) < 1e-7
    assert np.abs(swing["first.displacement.excess"]).max() < 1e-9
    assert np.abs(swing["second.displacement.excess"]).max() < 1e-9


def test_an_input_that_is_held_does_not_hold_what_the_others_move() -> None:
    swing = run(SumWithAHeldInput(), 1.0)
    assert swing["mass.flange.flow"] == pytest.approx(np.cos(5.0 * swing.time), abs=1e-9)
    assert swing.compiled.system.closures == ()


def test_a_signal_gives_the_displacement_of_an_input() -> None:
    # Energy is kept: (m + 3 (x / 1 m)^2) v^2 / 2, with v_y = x v_x / 1 m.
    moving = run(MassOnParabola(), 2.0)
    x, speed = moving["sensor.position"], moving["mover.flange.flow"]
    assert [str(state.path) for state in moving.compiled.system.states] == ["mover.momentum", "sensor.odometer.covered"]
    start = (2.0 + 3.0 * 0.3**2) * speed[0] ** 2
    assert (2.0 + 3.0 * x**2) * speed**2 == pytest.approx(np.full_like(x, start), rel=1e-9)
    assert moving["lifted.flange.flow"] == pytest.approx(x * speed, abs=1e-9)
    assert moving["follower.displacement.y"] == pytest.approx(0.5 * x * x, abs=1e-12)
