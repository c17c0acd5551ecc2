"""Short runs of random graphs with the interpreted backend, where a compiler would take longer than the run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propermodel.codegen.build import build_machine
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import Backend, CompiledModel
from propermodel.diagnostics import parse_path
from propermodel.modelling import Scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import begin
from propermodel.simulation.trajectory import Trajectory

STOP = 0.2


def run(model: CompiledModel, start: Mapping[str, float], step: float) -> Trajectory:
    """A run with RK4 from a start of the states; it must reach its end."""
    scenario = Scenario(stop=STOP, initial={parse_path(path): value for path, value in start.items()})
    trajectory = simulate(model, scenario, method=Method.RK4, step=step, record_every=STOP / 5, integrals_every=STOP)
    assert trajectory.ending.is_complete, trajectory.ending.message
    return trajectory


def numeric_jacobian(model: CompiledModel, states: FloatArray, time: float = 0.0) -> FloatArray:
    """The matrix of d(rates)/d(states), by central differences."""
    machine = build_machine(model.lowered.program, Method.EULER, backend=Backend.INTERPRETED)
    memory = begin(model, Scenario(stop=1.0))
    memory.time = time
    width = 1e-5
    columns: list[FloatArray] = []
    for number in range(len(states)):
        sides: list[FloatArray] = []
        for sense in (1.0, -1.0):
            memory.state[:] = states
            memory.state[number] += sense * width
            sides.append(machine.rates(memory)[0].copy())
        columns.append((sides[0] - sides[1]) / (2.0 * width))
    return np.array(columns).T.reshape(len(states), len(states))
