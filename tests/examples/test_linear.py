"""Examples of linear analysis and of equilibria, against matrices and polynomials written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals
from scipy.signal import TransferFunction, lsim, step

from propermodel.analysis.linearise import linearise
from propermodel.simulation.equilibrium import Stability, find_equilibrium
from tests.examples.runs import answer, module

MASSES = np.diag([300.0, 40.0])
STIFFNESS = np.array([[1.8e4, -1.8e4], [-1.8e4, 1.8e4 + 1.8e5]])
DAMPING = np.array([[1.2e3, -1.2e3], [-1.2e3, 1.2e3 + 50.0]])


def test_the_modes_of_a_quarter_car_are_those_of_its_mass_and_stiffness_matrices():
    modes = module("suspension_modes").linear(answer("suspension_modes")).modes()
    nothing, one = np.zeros((2, 2)), np.eye(2)
    roots = eigvals(np.block([[nothing, one], [-STIFFNESS, -DAMPING]]), np.block([[one, nothing], [nothing, MASSES]]))
    expected = sorted(roots[roots.imag > 0.0], key=abs)
    np.testing.assert_allclose([mode.eigenvalue for mode in modes], expected, rtol=1e-9)
    assert len(modes) == 2
    # The undamped modes, body and wheel, are where the docstring says.
    hertz = np.sqrt(eigh(STIFFNESS, MASSES)[0]) / (2 * math.pi)
    assert [mode.natural_frequency for mode in modes] == pytest.approx(hertz, rel=0.03)
    for mode, mass in zip(modes, ("body", "wheel"), strict=True):
        assert str(next(iter(mode.energy))) == mass
        dampers = {str(path): share for path, share in mode.dissipation.items()}
        assert dampers["suspension.damper"] > 0.9
        assert sum(dampers.values()) == pytest.approx(1.0)


def test_the_road_reaches_body_and_wheel_as_their_impedances_let_it():
    linear = module("suspension_modes").linear(answer("suspension_modes"))
    omega = np.geomspace(1.0, 300.0, 40)
    response = linear.frequency_response(omega)
    for row, output in enumerate(module("suspension_modes").OUTPUTS):
        expected = []
        for w in omega:
            s = 1j * w
            expected.append(np.linalg.solve(MASSES * s * s + DAMPING * s + STIFFNESS, [0.0, 50.0 * s + 1.8e5])[row])
        np.testing.assert_allclose(response.of("road.flow", output), expected, rtol=1e-9)


def test_a_bump_of_the_road_by_the_transfer_functions():
    run = answer("suspension_modes")
    # By hand: numerators and denominator of (M s^2 + D s + K)^-1 [0, c s + k].
    body = np.poly1d([300.0, 1.2e3, 1.8e4])
    wheel = np.poly1d([40.0, 1250.0, 1.98e5])
    between, tyre = np.poly1d([1.2e3, 1.8e4]), np.poly1d([50.0, 1.8e5])
    denominator = body * wheel - between * between
    road = np.interp(run.time, [0.5, 0.525, 0.55], [0.0, 2.0, 0.0])
    for output, numerator in (("body.flange.flow", between * tyre), ("wheel.flange.flow", body * tyre)):
        expected = lsim(TransferFunction(numerator.coeffs, denominator.coeffs), road, run.time)[1]
        np.testing.assert_allclose(run[output], expected, atol=1e-5)


def test_a_motor_has_the_transfer_functions_of_its_two_equations():
    linear = module("motor_transfer_function").linear(answer("motor_transfer_function"))
    R, L, k, J, d = 0.5, 5e-3, 0.1, 1e-3, 2e-3
    denominator = [L * J, R * J + L * d, R * d + k * k]
    for output, numerator in (("load.shaft.flow", [k]), ("motor.pin.flow", [J, d])):
        function = linear.transfer_function("voltage", output)
        np.testing.assert_allclose(sorted(function.poles.real), sorted(np.roots(denominator)), rtol=1e-9)
        np.testing.assert_allclose(function.zeros, np.roots(numerator), rtol=1e-9)
        assert function.gain == pytest.approx(numerator[0] / denominator[0], rel=1e-12)


def test_a_motor_runs_as_its_step_response():
    run = answer("motor_transfer_function")
    R, L, k, J, d = 0.5, 5e-3, 0.1, 1e-3, 2e-3
    denominator = [L * J, R * J + L * d, R * d + k * k]
    for output, numerator in (("load.shaft.flow", [k]), ("motor.pin.flow", [J, d])):
        expected = step(TransferFunction(numerator, denominator), T=run.time)[1]
        np.testing.assert_allclose(run[output], expected, atol=1e-9)


def test_a_clicking_spring_rests_where_its_cubic_has_roots():
    example, run = module("two_equilibria"), answer("two_equilibria")
    m, d, k, k3, load = 0.05, 3.0, -1.0e3, 4.0e7, 0.05 * 9.80665
    roots = sorted(np.roots([k3, 0.0, k, -load]).real)
    rests = [find_equilibrium(run.compiled, example.scenario(start)) for start in example.STARTS]
    np.testing.assert_allclose([rest["leaf.displacement"] for rest in rests], roots, rtol=1e-10)
    assert [rest.stability for rest in rests] == [Stability.STABLE, Stability.UNSTABLE, Stability.STABLE]
    for rest, x in zip(rests, roots, strict=True):
        expected = np.roots([m, d, k + 3 * k3 * x * x])
        poles = linearise(run.compiled, rest).poles
        np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(expected), rtol=1e-8)
    assert run.at_end("leaf.port.displacement") == pytest.approx(roots[0], abs=1e-6)


def test_a_clicking_spring_that_starts_at_its_unstable_rest_falls_the_way_it_is_pushed():
    example, run = module("two_equilibria"), answer("two_equilibria")
    unstable = find_equilibrium(run.compiled, example.scenario(0.0))["leaf.displacement"]
    assert unstable > example.LET_GO
    assert run["leaf.port.displacement"].max() < unstable
