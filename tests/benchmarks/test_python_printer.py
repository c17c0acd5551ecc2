"""The printed Python, executed as it is: compilers of Python get no other."""

import numpy as np

from benchmarks.python_peers import numba_loop, numba_space
from propermodel.codegen.machine import Memory, Method, Request
from propermodel.codegen.program import Array
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.compiler import compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import start_of


def test_printed_python_has_the_rates_powers_and_samples_of_the_package():
    truck = compile_model(elaborate(HybridTruck()))
    scenario: Scenario = mission("fmtv_mixed", until=30.0)  # it drives then
    memory: Memory = simulate(truck, scenario, method=Method.ROS2, step=2e-3, record=[]).memory
    machine = truck.machine(Method.ROS2)
    space, tables = numba_space(with_reciprocals(truck.lowered.program), memory)
    given = (memory.time, memory.state, memory.discrete, memory.parameter, memory.unknown, tables)
    rates, powers, _ = space["rates"](*given)
    expected_rates, expected_powers = machine.rates(memory)
    np.testing.assert_allclose(rates, expected_rates, rtol=1e-9, atol=1e-12 * np.abs(expected_rates).max())
    np.testing.assert_allclose(powers, expected_powers, rtol=1e-9, atol=1e-12 * np.abs(expected_powers).max())
    sampled = memory.copy()
    machine.sample(sampled)
    held = memory.discrete
    for k in range(len(truck.lowered.program.samples)):
        held = space[f"sample{k}"](memory.time, memory.state, held, memory.parameter, memory.unknown, tables)[0]
    assert len(held) == truck.lowered.program.layout.lengths[Array.DISCRETE]
    np.testing.assert_allclose(held, sampled.discrete, rtol=1e-12)


def test_the_loop_for_numba_takes_the_steps_of_the_package():
    truck = compile_model(elaborate(HybridTruck()))
    program = with_reciprocals(truck.lowered.program)
    start = start_of(truck, mission("fmtv_mixed")).memory
    ours = start.copy()
    space, tables = numba_space(program, start)
    space["prange"] = range
    exec(numba_loop(program), space)
    y, d, p, u = (array[np.newaxis].copy() for array in (start.state, start.discrete, start.parameter, start.unknown))
    activity = np.zeros((1, len(start.activity)))
    space["mission"](y, d, p, u, tables, activity, start.time, 2, 50, 2e-4)
    truck.machine(Method.SEMI_IMPLICIT).run(ours, Request(until=0.02, step=2e-4, most_ticks=100))
    (fuel,) = (i for i, state in enumerate(truck.system.states) if str(state.path) == "engine.fuel_meter.mass")
    assert ours.state[fuel] > 0.0  # which is neither a momentum nor a displacement
    np.testing.assert_allclose(y[0], ours.state, rtol=1e-9, atol=1e-12)
    gained = ours.activity - start.activity
    assert gained.max() > 0.0
    np.testing.assert_allclose(activity[0], gained, rtol=1e-5, atol=1e-9 * gained.max())
