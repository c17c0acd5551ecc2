"""The half car: a gas-sprung body on two wheels."""

import math
from dataclasses import replace

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import Method, compile_model
from propermodel.diagnostics import parse_path
from propermodel.library.vehicle.half_car import HalfCar
from propermodel.modelling import Scenario, TableValues, elaborate
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate


@pytest.fixture(scope="module")
def half_car():
    return compile_model(elaborate(HalfCar()))


def wavy_road(stop, delay):
    """Two waves that reach the rear wheel later."""
    t = np.linspace(0.0, stop, int(1000 * stop) + 1)

    def velocity(time):
        return np.where(time > 0.0, 0.1 * np.sin(7.0 * time) + 0.05 * np.sin(23.0 * time), 0.0)

    def over_time(values):
        return TableValues((tuple(t.tolist()),), tuple(values.tolist()))

    return Scenario(
        stop=stop,
        inputs={
            parse_path("front_road.flow"): over_time(velocity(t)),
            parse_path("rear_road.flow"): over_time(velocity(t - delay)),
        },
    )


def test_each_degree_of_freedom_is_a_state(half_car):
    assert len(half_car.system.states) == 10
    assert not half_car.system.causal.derivative


def test_its_energy_balances(half_car):
    run = simulate(half_car, wavy_road(10.0, 0.2), step=1e-4)
    balance = energy_balance(run)
    assert balance.relative_residual < 1e-3
    assert abs(balance.wiring_residual) < 1e-9 * balance.throughput


def test_on_an_even_road_it_stays_where_it_is(half_car):
    level = Scenario(stop=1.0, inputs={parse_path("front_road.flow"): 0.0, parse_path("rear_road.flow"): 0.0})
    run = simulate(half_car, level, step=1e-3)
    for path in ("heave.flange.flow", "pitch.shaft.flow", "front.strut.gas.port.effort"):
        assert run.at_end(path) == 0.0


def test_the_body_bounces_at_the_rate_of_its_gas_springs(half_car):
    # Both wheels are lifted; the slow body then swings between isothermal and adiabatic stiffness, tyres in series.
    lifted = Scenario(
        stop=4.0,
        inputs={parse_path("front_road.flow"): 0.0, parse_path("rear_road.flow"): 0.0},
        initial={parse_path("heave.momentum"): 60.0},
        parameters={parse_path("front.strut.damping"): 50.0, parse_path("rear.strut.damping"): 50.0},
    )
    run = simulate(half_car, lifted, step=2e-4)
    speed = run["heave.flange.flow"]
    crossings = run.time[1:][(speed[1:] > 0.0) & (speed[:-1] <= 0.0)]
    found = 1.0 / np.mean(np.diff(crossings))

    def bounce(ratio):
        gas = ratio * 3e6 * 1.2e-3**2 / 0.8e-3
        return math.sqrt(2.0 * gas * 2e5 / (gas + 2e5) / 600.0) / (2.0 * math.pi)

    assert bounce(1.0) * 0.97 < found < bounce(1.4) * 1.03


def test_without_their_walls_the_gas_springs_are_adiabatic(half_car):
    # Heat matters little on a rough road: a wall is small against its gas, although only the two meet at a junction.
    subject = load_subject("half-car")
    scenario = replace(subject.scenario, stop=10.0)
    full = simulate(half_car, scenario, method=Method.RK4, record_every=0.005)
    reduction = plan_reduction(half_car, full, rank_activity(full), threshold=0.99, protected=subject.outputs)
    walls = [d for d in reduction.removed if d.row.path.name == "wall"]
    assert [str(d.row.path) for d in walls] == ["front.strut.wall", "rear.strut.wall"]
    assert all(d.meaning == "no flow" for d in walls)
    reduced = simulate(
        compile_model(half_car.model.without(reduction.removals)), scenario, method=Method.RK4, record_every=0.005
    )
    entropy = parse_path("front.strut.gas.wall.displacement")
    assert np.ptp(reduced[entropy]) < 1e-6 * np.ptp(full[entropy])
    for output in subject.outputs:
        assert np.max(np.abs(reduced[output] - full[output])) < 0.005 * np.ptp(full[output])
