"""The run of a linear model with the inputs that a full model had: exact for inputs that are straight between rows."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propermodel.analysis.linearise import linearise
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.modelling.model import ElementKind, TableValues, Variable
from propermodel.simulation.trajectory import Trajectory

Matrix = FloatArray | NDArray[np.complex128]

STEPS = 2000


@dataclass(frozen=True, eq=False)
class LinearRun:
    """dx/dt = A x + B u, y = y_0 + C x + D u, x(0) = 0, with inputs u over evenly spaced instants.

    The last input is the constant 1, whose column of B is the rate with which the model starts.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    time: FloatArray
    inputs: FloatArray  # (inputs, instants)
    start: FloatArray  # y_0
    expected: FloatArray  # (outputs, instants): the run of the full model

    @classmethod
    def of(cls, compiled: CompiledModel, run: Trajectory, outputs: Sequence[Path]) -> LinearRun:
        """The linear model at the start of a run, and the inputs of the run.

        Raises:
            SimulationError: it has no derivatives there, an output follows the rate of an input, or an input was not
                recorded.
        """
        model = linearise(compiled, run.scenario, outputs=outputs)
        B, D = model.input_matrices()
        time = np.linspace(run.scenario.start, run.scenario.stop, STEPS + 1)
        given = np.array([_values(compiled, run, path, time) for path in model.inputs]).reshape(-1, len(time))
        # The states of `input_matrices` are x - B_rate u, so u counts from its value at the start.
        moved = given - given[:, :1]
        return cls(
            A=model.A,
            B=np.column_stack([B, model.point.rates]),
            C=model.C,
            D=np.column_stack([D, np.zeros(len(outputs))]),
            time=time,
            inputs=np.vstack([moved, np.ones(len(time))]),
            start=model.point.outputs,
            expected=np.array([np.interp(time, run.time, run[path]) for path in outputs]),
        )

    @property
    def misfit(self) -> float:
        """How far the whole linear model is from the run of the full one."""
        return self.error(self.response(self.A, self.B, self.C, self.D))

    def error(self, found: FloatArray) -> float:
        """The largest root mean square of the difference of an output from the run, over its range there."""
        ranges = np.ptp(self.expected, axis=1)
        return float(np.max(np.sqrt(np.mean((found - self.expected) ** 2, axis=1)) / ranges))

    def response(self, A: Matrix, B: Matrix, C: Matrix, D: FloatArray) -> FloatArray:
        """(outputs, instants) of a model in other, perhaps fewer, states; they begin at zero."""
        from scipy.linalg import expm

        n, m = B.shape
        step = float(self.time[1] - self.time[0])
        whole = np.zeros((n + 2 * m, n + 2 * m), dtype=np.result_type(A, B))
        whole[:n, :n], whole[:n, n : n + m] = A * step, B * step
        whole[n : n + m, n + m :] = np.eye(m)
        powers = np.array(expm(whole))[:n]
        stay, first, second = powers[:, :n], powers[:, n : n + m], powers[:, n + m :]
        x = np.zeros(n, dtype=whole.dtype)
        states = [x]
        for before, after in itertools.pairwise(self.inputs.T):
            x = stay @ x + (first - second) @ before + second @ after
            states.append(x)
        found = C @ np.array(states).T + D @ self.inputs
        return self.start[:, np.newaxis] + np.real(found)


def _values(compiled: CompiledModel, run: Trajectory, path: Path, time: FloatArray) -> FloatArray:
    given = run.scenario.inputs.get(path)
    if isinstance(given, TableValues):
        return np.interp(time, np.array(given.grids[0]), np.array(given.values))
    if given is not None:
        return np.full(len(time), float(given))
    return np.interp(time, run.time, run[_recorded(compiled, path)])


def _recorded(compiled: CompiledModel, path: Path) -> Path:
    """The observable that tells the value of an input: of a source, what it imposes at its port."""
    source = compiled.graph.original.elements.get(path)
    if source is None or source.kind not in (ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE):
        return path
    variable = Variable.EFFORT if source.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
    return path / source.ports[0] / variable.value
