"""The printed Python, executed as it is: compilers of Python get no other."""

import numpy as np

from benchmarks.python_peers import numba_space
from propermodel.codegen.machine import Memory, Method
from propermodel.codegen.program import Array
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.compiler import compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate


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
