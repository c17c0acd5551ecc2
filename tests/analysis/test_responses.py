"""Responses and transfer functions against closed forms and SciPy."""

import math

import numpy as np
import pytest
from scipy import signal

from propermodel.analysis.linearise import linearise
from propermodel.compiler import compile_model
from propermodel.diagnostics import SimulationError
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling import Scenario, connect, elaborate
from tests.analysis.linear_systems import C, L, R, circuit, free_mass, free_pair, lags, linear, two_masses
from tests.cli.quarter_car import QuarterCar
from tests.parts import Mass, Velocity
from tests.physics.systems import system


def test_step_of_a_series_circuit_is_its_damped_oscillation():
    model = linear(circuit(), outputs=["capacitor.port.effort"])
    answer = model.step_response(duration=5e-3, points=400)
    decay, natural = 0.5 * R / L, 1.0 / math.sqrt(L * C)
    damped = math.sqrt(natural**2 - decay**2)
    t = answer.time
    expected = 1.0 - np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))
    sign = np.sign(answer.values[-1, 0])
    np.testing.assert_allclose(sign * answer["capacitor.port.effort"], expected, atol=1e-11)


def test_impulse_of_a_series_circuit_is_the_derivative_of_its_step():
    model = linear(circuit(), outputs=["capacitor.port.effort", "coil.port.effort"])
    answer = model.impulse_response("supply", points=300)
    decay, natural = 0.5 * R / L, 1.0 / math.sqrt(L * C)
    damped = math.sqrt(natural**2 - decay**2)
    t = answer.time
    expected = natural**2 / damped * np.exp(-decay * t) * np.sin(damped * t)
    np.testing.assert_allclose(np.abs(answer["capacitor.port.effort"]), np.abs(expected), atol=1e-9 * natural)
    # The whole impulse of voltage stands on the coil.
    np.testing.assert_allclose(np.abs(answer.impulse), [0.0, 1.0], atol=1e-14)
    assert t[-1] == pytest.approx(7.0 * 2.0 * L / R)


def test_a_free_mass_answers_a_step_of_force_with_a_ramp_of_velocity():
    model = linear(free_mass(), outputs=["mass.flange.flow"])
    answer = model.step_response(duration=4.0, points=5)
    np.testing.assert_allclose(np.abs(answer["mass.flange.flow"]), [0.0, 0.5, 1.0, 1.5, 2.0], rtol=1e-14)


def test_frequency_response_of_a_quarter_car_is_that_of_its_equations_of_motion():
    model = linear(QuarterCar(), outputs=["body.flange.flow"])
    frequency = np.geomspace(0.1, 30.0, 25)
    found = model.frequency_response(2.0 * math.pi * frequency)
    s = 2j * math.pi * frequency
    suspension, tyre = 1.5e3 + 2.0e4 / s, 1.5e2 + 2.4e5 / s
    body, wheel = 1200.0 * s + suspension, 80.0 * s + suspension + tyre
    expected = suspension * tyre / (body * wheel - suspension**2)
    np.testing.assert_allclose(found.of(), expected, rtol=1e-11)
    np.testing.assert_allclose(found.magnitude(), np.abs(expected), rtol=1e-11)
    np.testing.assert_allclose(found.phase(), np.unwrap(np.angle(expected)), atol=1e-11)
    np.testing.assert_allclose(found.frequency, frequency)


def test_transfer_function_of_a_quarter_car_has_the_zeros_of_its_damper_and_tyre():
    made = linear(QuarterCar(), outputs=["body.flange.flow"]).transfer_function("road.flow", "body.flange.flow")
    np.testing.assert_allclose(np.sort(made.zeros.real), [-2.4e5 / 1.5e2, -2.0e4 / 1.5e3], rtol=1e-10)
    assert made.gain == pytest.approx(1.5e3 * 1.5e2 / (1200.0 * 80.0), rel=1e-12)
    assert made.static_gain == pytest.approx(1.0, rel=1e-12)
    assert made.relative_degree == 2
    assert str(made) == (
        "body.flange.flow / road.flow =\n"
        "            2.34375 (s+13.3333) (s+1600)\n"
        "  -----------------------------------------------\n"
        "  (s^2+1.07058 s+15.4738) (s^2+20.8044 s+3231.26)"
    )
    omega = np.geomspace(0.5, 200.0, 15)
    np.testing.assert_allclose(
        signal.freqresp(made.to_scipy(), omega)[1],
        linear(QuarterCar(), outputs=["body.flange.flow"]).frequency_response(omega).of(),
        rtol=1e-10,
    )


def test_modes_that_an_output_does_not_show_are_no_poles():
    # Pulled at one mass, the damped difference of two equal masses shows one of the two modes only.
    made = linear(two_masses(damping=1.0), outputs=["middle.displacement"]).transfer_function()
    np.testing.assert_allclose(np.sort_complex(made.poles), np.roots([1.0, 1.0, 75.0])[::-1], rtol=1e-9)
    assert made.zeros.size == 0
    free = linear(free_pair(), outputs=["spring.displacement"])
    made = free.transfer_function()
    assert made.zeros.size == 0
    np.testing.assert_allclose(made.poles.prod().real, 40.0, rtol=1e-12)
    assert abs(made.static_gain) == pytest.approx(1.0 / 40.0, rel=1e-12)


def test_an_integral_has_a_pole_at_zero_and_no_static_gain():
    made = linear(free_mass(), outputs=["mass.flange.flow"]).transfer_function()
    assert made.poles.tolist() == [0.0]
    assert abs(made.gain) == 0.5
    assert made.static_gain == math.inf
    with pytest.raises(ZeroDivisionError):
        made(0.0)


@pytest.mark.filterwarnings("ignore:warning.structure/disconnected:propermodel.ModelWarning")
def test_an_input_that_an_output_does_not_show_has_the_transfer_function_zero():
    mass, other = free_mass(), free_pair()
    made = linear(system(mass=mass, other=other), inputs=["mass.push"], outputs=["other.one.flange.flow"])
    function = made.transfer_function()
    assert (function.gain, function.zeros.size, function.poles.size) == (0.0, 0, 0)
    assert function(1j) == 0.0


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
def test_a_mass_carried_along_answers_with_the_derivative_of_the_velocity():
    mass, shaker = Mass(mass=2.0), Velocity(velocity=0.0)
    carried = system(connect(mass.flange, shaker.flange), mass=mass, shaker=shaker)
    model = linear(carried, inputs=["shaker"], outputs=["mass.flange.effort"])
    function = model.transfer_function()
    assert abs(function.gain) == 2.0
    assert function.zeros.tolist() == [0.0]
    assert function.relative_degree == -1
    np.testing.assert_allclose(model.frequency_response([3.0]).magnitude(), [6.0])
    with pytest.raises(SimulationError, match="linear/improper"):
        model.step_response()


@pytest.mark.parametrize("spread", [0.0, 1e-9, 1e-3, 0.02, 0.5])
def test_a_row_of_lags_has_its_transfer_function_although_its_poles_are_uncertain(spread: float):
    rates = 1.0 + spread * np.arange(16)
    model = lags(rates)
    function = model.transfer_function()
    assert function.zeros.size == 0
    assert function.poles.size == 16
    assert function.gain == pytest.approx(np.prod(rates), rel=1e-12)
    for omega in (0.0, 0.3, 1.0, 5.0):
        expected = np.prod(rates / (1j * omega + rates))
        assert abs(function(1j * omega) - expected) < 1e-9 * abs(expected)
        assert abs(model.frequency_response([omega]).of()[0] - expected) < 1e-13


def test_a_gain_beyond_all_numbers_is_refused_and_the_frequency_response_remains():
    model = lags(np.full(50, 1e9))
    with pytest.raises(SimulationError, match=r"linear/gain.*from u0 to y0"):
        model.transfer_function()
    assert model.frequency_response([1e6]).of()[0] == pytest.approx((1.0 + 1e-3j) ** -50, rel=1e-12)


def test_truck_transfer_functions_are_its_frequency_response():
    made = compile_model(elaborate(HybridTruck()))

    model = linearise(made, Scenario())
    omega = np.geomspace(1.0, 100.0, 4)
    answer = model.frequency_response(omega)
    assert np.isfinite(answer.values).all()
    expected = np.array([model.C @ np.linalg.solve(1j * w * np.eye(len(model.A)) - model.A, model.B) for w in omega])
    np.testing.assert_allclose(answer.values, expected + model.D, atol=1e-9 * np.abs(expected).max(), rtol=1e-6)


def test_a_resonance_without_damping_has_no_steady_answer():
    model = linear(two_masses(), outputs=["one.flange.flow"])
    with pytest.raises(SimulationError, match=r"linear/resonance.*undamped mode at 5 rad/s"):
        model.frequency_response([1.0, 5.0])


def test_a_response_needs_a_duration_and_points():
    model = linear(circuit())
    with pytest.raises(SimulationError, match="linear/duration"):
        model.step_response(duration=-1.0)
    with pytest.raises(SimulationError, match="linear/duration"):
        model.step_response(points=1)


def test_an_unknown_output_is_reported_with_the_nearest_name():
    answer = linear(circuit()).step_response(points=3)
    with pytest.raises(SimulationError, match=r"linear/unknown-name(?s:.*)coil\.momentum"):
        answer["coil.momentun"]
