"""Linear models against central differences, closed forms and python-control."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from propermodel.analysis.linearise import linearise, memory_at
from propermodel.codegen.machine import Memory, Method
from propermodel.compiler import Backend, CompiledModel, compile_model, compile_quietly
from propermodel.diagnostics import SimulationError
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling import Component, Scenario, connect, elaborate
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import begin
from tests.cli.quarter_car import QuarterCar
from tests.parts import Capacitor, Coil, Damper, Force, Ground, Mass, Resistor, Velocity, Voltage
from tests.physics.systems import CubicDamper, system
from tests.rigs import Rig, rigs


def numeric(compiled: CompiledModel, memory: Memory, share: float = 1e-6) -> np.ndarray:
    """The Jacobian of the compiled right-hand side by central differences."""
    machine = compiled.machine(Method.RK4)
    columns = []
    for index, value in enumerate(memory.state):
        change = share * max(abs(float(value)), 1e-2)
        sides = []
        for sign in (1.0, -1.0):
            moved = memory.copy()
            moved.state[index] = value + sign * change
            sides.append((machine.rates(moved)[0], moved.state[index]))
        columns.append((sides[0][0] - sides[1][0]) / (sides[0][1] - sides[1][1]))
    return np.array(columns).T.reshape(len(memory.state), len(memory.state))


def test_state_matrix_of_a_series_circuit_is_the_textbook_one():
    made = compile_model(elaborate(_circuit()))
    model = linearise(made, Scenario(), inputs=["supply"], outputs=["resistor.port.effort"])
    L, C, R = 2e-3, 5e-6, 3.0
    place = {path: index for index, path in enumerate(map(str, model.states))}
    order = [place["capacitor.displacement"], place["coil.momentum"]]
    np.testing.assert_allclose(model.A[np.ix_(order, order)], [[0, 1 / L], [-1 / C, -R / L]], rtol=1e-14)
    np.testing.assert_allclose(np.abs(model.B[order, 0]), [0, 1], rtol=1e-14)
    np.testing.assert_allclose(np.abs(model.C[0, order]), [0, R / L], rtol=1e-14)


def _circuit() -> Component:
    supply, coil = Voltage(voltage=1.0), Coil(inductance=2e-3)
    resistor, capacitor, ground = Resistor(resistance=3.0), Capacitor(capacitance=5e-6), Ground()
    return system(
        connect(supply.a, coil.a),
        connect(coil.b, resistor.a),
        connect(resistor.b, capacitor.a),
        connect(capacitor.b, supply.b, ground.pin),
        supply=supply,
        coil=coil,
        resistor=resistor,
        capacitor=capacitor,
        ground=ground,
    )


def test_frequency_response_of_a_quarter_car_is_that_of_its_equations_of_motion():
    model = linearise(compile_model(elaborate(QuarterCar())), Scenario(), outputs=["body.flange.flow"])
    for frequency in (0.3, 1.3, 11.0):
        s = 2j * math.pi * frequency
        found = (model.C @ np.linalg.solve(s * np.eye(4) - model.A, model.B) + model.D)[0, 0]
        suspension, tyre = 1.5e3 + 2.0e4 / s, 1.5e2 + 2.4e5 / s
        mass = np.array([[1200.0 * s + suspension, -suspension], [-suspension, 80.0 * s + suspension + tyre]])
        expected = np.linalg.solve(mass, [0.0, tyre])[0]
        assert abs(found - expected) < 1e-10 * abs(expected)


@given(rig=rigs())
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
def test_state_matrix_is_the_numeric_jacobian_for_random_rigs(rig: Rig):
    made = compile_quietly(elaborate(rig.component()), backend=Backend.INTERPRETED)
    model = linearise(made, Scenario())
    expected = numeric(made, begin(made, Scenario()))
    np.testing.assert_allclose(model.A, expected, rtol=1e-6, atol=1e-7 * (1.0 + np.abs(expected).max(initial=0.0)))


def test_a_nonlinear_loop_is_differentiated_through():
    mass, one, two = Mass(mass=2.0), CubicDamper(factor=40.0), Damper(damping=15.0)
    shaker = Velocity(velocity=0.3)
    made = compile_model(
        elaborate(
            system(
                connect(mass.flange, one.a),
                connect(one.b, two.a),
                connect(two.b, shaker.flange),
                mass=mass,
                one=one,
                two=two,
                shaker=shaker,
            )
        )
    )
    assert len(made.system.blocks) == 1
    begun = Scenario(initial={"mass.momentum": 2.0})
    outputs = ["mass.flange.flow", "shaker.flange.flow"]
    model = linearise(made, begun, inputs=["shaker"], outputs=outputs)
    np.testing.assert_allclose(model.A, numeric(made, begin(made, begun)), rtol=1e-7)
    # In series the dampers share one force: 1/d = 1/(3 c s^2) + 1/b, where c s^3 = b (v - s).
    slip = abs(float(model.point.outputs[0] - model.point.outputs[1]))
    share = next(x.real for x in np.roots([40.0, 0.0, 15.0, -15.0 * slip]) if abs(x.imag) < 1e-12)
    damping = 1.0 / (1.0 / (120.0 * share**2) + 1.0 / 15.0)
    assert model.A[0, 0] == pytest.approx(-damping / 2.0, rel=1e-9)
    assert abs(model.B[0, 0]) == pytest.approx(damping, rel=1e-9)


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
def test_a_mass_carried_by_its_support_answers_with_the_rate_of_the_velocity():
    mass, shaker = Mass(mass=2.0), Velocity(velocity=0.0)
    made = compile_model(elaborate(system(connect(mass.flange, shaker.flange), mass=mass, shaker=shaker)))
    model = linearise(made, Scenario(), inputs=["shaker"], outputs=["mass.flange.effort", "mass.flange.flow"])
    assert model.A.shape == (0, 0)
    np.testing.assert_allclose(np.abs(model.D_rate), [[2.0], [0.0]])
    np.testing.assert_allclose(np.abs(model.D), [[0.0], [1.0]])
    with pytest.raises(SimulationError, match=r"mass\.flange\.effort follows the rate of change of the input shaker"):
        model.input_matrices()


def test_truck_in_motion_is_linearised_as_by_finite_differences():
    made = compile_model(elaborate(HybridTruck()))
    full = mission("fmtv_mixed")
    run = simulate(made, Scenario(**{**vars(full), "stop": full.start + 20.0}), record=())
    at = full.start + 12.0
    model = linearise(made, run, time=at)
    # A swash plate of 1e-10 stands inside the narrow rounding of a kink: each derivative with the step that suits it.
    worst = np.full(model.A.shape, np.inf)
    for share in (1e-5, 1e-7, 1e-9):
        expected = numeric(made, memory_at(run, at), share=share)
        scale = np.abs(expected) + 1e-5 * np.abs(expected).max(axis=1, keepdims=True) + 1e-12
        worst = np.minimum(worst, np.abs(model.A - expected) / scale)
    assert worst.max() < 2e-3


def test_python_control_gets_the_same_model():
    import control

    model = linearise(compile_model(elaborate(QuarterCar())), Scenario(), outputs=["body.flange.flow"])
    other = model.to_control()
    assert other.input_labels == ["road_flow"]
    np.testing.assert_allclose(np.sort_complex(control.poles(other)), np.sort_complex(model.poles), rtol=1e-9)
    np.testing.assert_allclose(control.dcgain(other), 1.0, rtol=1e-9)


@pytest.mark.filterwarnings("ignore:warning.structure/disconnected:propermodel.ModelWarning")
def test_python_control_gets_every_name_once():
    one, push = Mass(mass=1.0), Force(force=1.0)
    other, pull = Mass(mass=2.0), Force(force=1.0)
    pushed = system(connect(one.flange, push.flange), b_c=one, push=push)
    pulled = system(connect(other.flange, pull.flange), c=other, pull=pull)
    model = linearise(compile_model(elaborate(system(a=pushed, a_b=pulled))), Scenario())
    assert [str(path) for path in model.states] == ["a.b_c.momentum", "a_b.c.momentum"]
    assert model.to_control().state_labels == ["a_b_c_momentum", "a_b_c_momentum_2"]


def test_an_unknown_input_or_output_is_reported_with_the_nearest_name():
    made = compile_model(elaborate(QuarterCar()))
    with pytest.raises(SimulationError, match=r"linear/unknown-input.*'road.flw'(?s:.*)road\.flow"):
        linearise(made, Scenario(), inputs=["road.flw"])
    with pytest.raises(SimulationError, match=r"no observable 'body\.flange\.flw'"):
        linearise(made, Scenario(), outputs=["body.flange.flw"])
