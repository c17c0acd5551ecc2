"""Programs with tangents run on both backends and in lanes as any program does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propermodel as pm
from propermodel.codegen.machine import Memory, Request
from propermodel.codegen.program import Array
from propermodel.codegen.tangents import Direction, TangentProgram, with_tangents
from propermodel.compiler import Backend, CompiledTangents
from propermodel.diagnostics import SimulationError
from propermodel.simulation.side_by_side import joined, lane_of
from propermodel.simulation.start import begin, start_of
from propermodel.simulation.start_tangents import start_tangents
from propermodel.simulation.tangent_run import tangent_memory
from tests.examples.runs import module, run_of


def asked(
    name: str, method: pm.Method, *parameters: str
) -> tuple[pm.CompiledModel, pm.Scenario, CompiledTangents, list[pm.Path]]:
    """An example with its tangents along some parameters."""
    compiled = run_of(name)[0].compiled
    paths = [pm.Path(parameter.split(".")) for parameter in parameters]
    directions = tuple(Direction((compiled.graph.parameters[path].symbol,)) for path in paths)
    prepared = compiled.tangents(method, directions, (0, 1), tuple(range(len(compiled.lowered.powers))))
    return compiled, module(name).scenario(), prepared, paths


def memory_of(
    compiled: pm.CompiledModel, scenario: pm.Scenario, tangents: TangentProgram, paths: list[pm.Path]
) -> Memory:
    rates = start_tangents(compiled, scenario, paths, lambda other: start_of(compiled, other), is_declared=True)
    return tangent_memory(tangents, begin(compiled, scenario), rates, range(len(paths)))


def cases() -> list[tuple[str, tuple[str, ...]]]:
    found: list[tuple[str, tuple[str, ...]]] = []
    for name in ("cruise_control", "four_bar_linkage", "gas_spring"):
        compiled = run_of(name)[0].compiled
        chosen = [str(path) for path in compiled.lowered.parameters if path in compiled.graph.parameters]
        found.append((name, tuple(chosen[:2])))
    return found


@pytest.mark.parametrize(("name", "parameters"), cases())
@pytest.mark.parametrize("method", [pm.Method.SEMI_IMPLICIT, pm.Method.RK4, pm.Method.ROS2])
def test_both_backends_carry_the_same_tangents(name: str, parameters: tuple[str, ...], method: pm.Method):
    compiled, scenario, prepared, paths = asked(name, method, *parameters)
    step = run_of(name)[0].step
    ends: list[Memory] = []
    for backend in Backend:
        machine = replace(prepared, backend=backend, _machines={}).machine()
        memory = memory_of(compiled, scenario, prepared.tangents, paths)
        machine.run(memory, Request(until=scenario.start + 30 * step, step=step))
        ends.append(memory)
    for kept in ("state", "discrete", "integral"):
        native, interpreted = (getattr(memory, kept) for memory in ends)
        assert np.abs(native - interpreted).max(initial=0.0) <= 1e-9 * np.abs(native).max(initial=0.0)
    assert ends[0].state[prepared.tangents.state(0)].any()


def test_a_lane_has_the_bits_it_has_alone():
    compiled, scenario, prepared, paths = asked("quarter_car", pm.Method.RK4, "body.mass", "suspension.damper.damping")
    request = Request(until=0.2, step=1e-3)
    memories = [
        memory_of(compiled, replace(scenario, parameters={paths[0]: mass}), prepared.tangents, paths)
        for mass in (1000.0, 1200.0, 1400.0)
    ]
    together = joined(memories, 4)
    prepared.machine(4).run(together, request)
    for lane, memory in enumerate(memories):
        prepared.machine().run(memory, request)
        assert (lane_of(together, lane).state == memory.state).all()
        assert (lane_of(together, lane).integral == memory.integral).all()
    assert memories[0].state[prepared.tangents.state(1)].any()


def test_what_is_integrated_is_the_derivative_of_the_power_and_of_its_size():
    compiled, scenario, prepared, paths = asked("quarter_car", pm.Method.EULER, "body.mass")
    tangents = prepared.tangents
    memory = memory_of(compiled, scenario, tangents, paths)
    machine = prepared.machine()
    machine.run(memory, Request(until=0.3, step=1e-3))
    power = machine.rates(memory)[1]
    own = power[: tangents.powers]
    assert (power[tangents.absolute_power(0)] == np.sign(own) * power[tangents.power(0)]).all()
    assert len(power) == tangents.program.layout.lengths[Array.POWER] == 3 * len(compiled.lowered.powers)


def test_programs_with_ideal_switches_have_no_tangents():
    program = run_of("buck_converter")[0].compiled.lowered.program
    with pytest.raises(ValueError, match="ideal switches"):
        with_tangents(program, [], [], [])


def test_a_large_block_is_refused_by_name(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.codegen.tangent_rules.MOST_UNKNOWNS", 1)
    compiled = run_of("four_bar_linkage")[0].compiled
    path = compiled.lowered.parameters[0]
    with pytest.raises(SimulationError, match="sensitivities need the derivatives of"):
        compiled.tangents(pm.Method.RK4, (Direction((compiled.graph.parameters[path].symbol,)),), (), ())
