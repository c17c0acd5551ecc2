"""A linear model of small deviations, with physical names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from propermodel.analysis.modes import Modes, modes_of
from propermodel.analysis.responses import (
    FrequencyResponse,
    TimeResponse,
    frequency_response,
    impulse_response,
    step_response,
)
from propermodel.analysis.spectrum import all_values, roots_of
from propermodel.analysis.transfer import TransferFunction, transfer_function
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, SimulationError, one_of
from propermodel.expressions.core import Expr
from propermodel.simulation.observables import observable_path

MOST_PRINTED = 12  # larger matrices are not written out


@dataclass(frozen=True, eq=False, kw_only=True)
class OperatingPoint:
    """Where a model was linearised: values in SI, in the order of the model's states, inputs and outputs."""

    description: str
    time: float
    states: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    rates: FloatArray  # of the states; zero at an equilibrium


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementVariables:
    """Small deviations at every port of a storage or resistance, as rows over the states.

    `efforts` and `others` are effort and displacement of a compliance, flow and momentum of an inertia, effort and flow
    of a resistance. Ports whose law has a vertical tangent at the point are left out.
    """

    paths: tuple[Path, ...]
    is_storage: tuple[bool, ...]
    efforts: csr_array
    others: csr_array


@dataclass(frozen=True, eq=False, kw_only=True)
class LinearModel:
    """Small deviations: dx/dt = A x + B u + B_rate du/dt and y = C x + D u + D_rate du/dt, in SI.

    The terms with rates of inputs are zero unless an input imposes the motion of dependent storage (a mass that a
    prescribed velocity carries along).
    """

    name: str
    states: tuple[Path, ...]
    state_units: tuple[str, ...]
    inputs: tuple[Path, ...]
    input_units: tuple[str, ...]
    outputs: tuple[Path, ...]
    output_units: tuple[str, ...]
    A: FloatArray  # states x states
    B: FloatArray  # states x inputs
    C: FloatArray  # outputs x states
    D: FloatArray  # outputs x inputs
    B_rate: FloatArray
    D_rate: FloatArray
    point: OperatingPoint
    elements: ElementVariables

    @property
    def poles(self) -> np.ndarray[Any, np.dtype[np.complex128]]:
        """The eigenvalues of A, 1/s, slowest first."""
        return all_values(roots_of(self.A))

    @property
    def is_stable(self) -> bool:
        """Whether every small deviation decays."""
        return bool(np.all(self.poles.real < 0.0))

    @property
    def is_proper(self) -> bool:
        """Whether no output follows the rate of an input."""
        return not self.D_rate.any()

    def input_index(self, name: Expr | Path | str | None = None) -> int:
        """The number of an input; of the only one where no name is given.

        Raises:
            SimulationError: there is no such input.
        """
        return _index(name, self.inputs, "input")

    def output_index(self, name: Expr | Path | str | None = None) -> int:
        """The number of an output; of the only one where no name is given.

        Raises:
            SimulationError: there is no such output.
        """
        return _index(name, self.outputs, "output")

    def input_matrices(self) -> tuple[FloatArray, FloatArray]:
        """The B and D of an equal model without rates of inputs, whose states are x - B_rate u.

        Raises:
            SimulationError: an output follows the rate of an input, so there is no such model.
        """
        if not self.is_proper:
            row, column = np.argwhere(self.D_rate)[0]
            raise SimulationError.of(
                "linear/improper",
                f"the output {self.outputs[row]} follows the rate of change of the input {self.inputs[column]}",
                help="choose other outputs, or use the frequency response, which exists all the same",
            )
        return self.B + self.A @ self.B_rate, self.D + self.C @ self.B_rate

    def modes(self) -> Modes:
        """How small deviations decay, oscillate or grow by themselves, and which states and elements take part."""
        return modes_of(self)

    def frequency_response(self, omega: Iterable[float] | FloatArray) -> FrequencyResponse:
        """The steady answer of every output to harmonic inputs.

        Args:
            omega: Angular frequencies, rad/s.

        Raises:
            SimulationError: an undamped mode has one of the frequencies.
        """
        return frequency_response(self, omega)

    def step_response(
        self, input: Expr | Path | str | None = None, *, duration: float | None = None, points: int = 501
    ) -> TimeResponse:
        """The answer to an input that grows by 1 (in SI) at time 0 and stays.

        Args:
            input: Which input; may be left out if there is only one.
            duration: Length of the answer, s; by default long enough for the slowest mode.
            points: Number of instants, equidistant. Values are exact at each.

        Raises:
            SimulationError: the input is unknown, an output follows its rate, or the answer grows beyond all numbers.
        """
        return step_response(self, input, duration, points)

    def impulse_response(
        self, input: Expr | Path | str | None = None, *, duration: float | None = None, points: int = 501
    ) -> TimeResponse:
        """The answer to an input that is an impulse of area 1 (in SI) at time 0; arguments as for a step."""
        return impulse_response(self, input, duration, points)

    def transfer_function(
        self, input: Expr | Path | str | None = None, output: Expr | Path | str | None = None
    ) -> TransferFunction:
        """Zeros, poles and gain from an input to an output; names may be left out where there is only one.

        Raises:
            SimulationError: there is no such input or output.
        """
        return transfer_function(self, input, output)

    def to_control(self) -> Any:
        """The model as a `StateSpace` of python-control, with names; needs the extra `control`.

        Its names cannot hold dots, so those of paths become underscores, with a number where two would be the same.

        Raises:
            SimulationError: an output follows the rate of an input, or python-control is not installed.
        """
        try:
            import control
        except ImportError:
            raise SimulationError.of(
                "linear/no-control",
                "python-control is not installed",
                help="pip install 'propermodel[control]'",
            ) from None
        B, D = self.input_matrices()
        return control.StateSpace(
            self.A,
            B,
            self.C,
            D,
            inputs=_labels(self.inputs),
            outputs=_labels(self.outputs),
            states=_labels(self.states),
            name=self.name,
            remove_useless_states=False,
        )

    def to_pandas(self) -> Any:
        """A, B, C and D as one pandas DataFrame with names; needs the extra `data`."""
        import pandas as pd

        rows = [*(f"d/dt {path}" for path in self.states), *map(str, self.outputs)]
        columns = [*map(str, self.states), *map(str, self.inputs)]
        return pd.DataFrame(np.block([[self.A, self.B], [self.C, self.D]]), index=rows, columns=columns)

    def __str__(self) -> str:
        point = self.point
        lines = [
            f"linear model of {self.name} at {point.time:g} s ({point.description})",
            f"  {len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs",
        ]
        for what, paths, units, values in (
            ("state", self.states, self.state_units, point.states),
            ("input", self.inputs, self.input_units, point.inputs),
            ("output", self.outputs, self.output_units, point.outputs),
        ):
            width = max((len(str(path)) for path in paths), default=0)
            lines.extend(
                f"  {what:<6}  {path!s:<{width}}  {value:.6g} {unit}".rstrip()
                for path, unit, value in zip(paths, units, values, strict=True)
            )
        for letter, matrix in (("A", self.A), ("B", self.B), ("C", self.C), ("D", self.D)):
            lines.extend(_matrix_lines(letter, matrix))
        for letter, matrix in (("B_rate", self.B_rate), ("D_rate", self.D_rate)):
            if matrix.any():
                lines.extend(_matrix_lines(letter, matrix))
        return "\n".join(lines)


def _labels(paths: tuple[Path, ...]) -> list[str]:
    """Names without dots, each once."""
    labels: list[str] = []
    for path in paths:
        name = label = str(path).replace(".", "_")
        number = 2
        while label in labels:
            label, number = f"{name}_{number}", number + 1
        labels.append(label)
    return labels


def _matrix_lines(letter: str, matrix: FloatArray) -> list[str]:
    if matrix.size == 0:
        return []
    if max(matrix.shape) > MOST_PRINTED:
        return [f"  {letter}: {matrix.shape[0]} x {matrix.shape[1]}, {np.count_nonzero(matrix)} entries are not zero"]
    texts = [[f"{value:.6g}" for value in row] for row in matrix.tolist()]
    width = max((len(text) for row in texts for text in row), default=0)
    return [f"  {letter}", *("    " + "  ".join(f"{text:>{width}}" for text in row) for row in texts)]


def _index(name: Expr | Path | str | None, known: tuple[Path, ...], what: str) -> int:
    if name is None and len(known) == 1:
        return 0
    path = None if name is None else observable_path(name)
    if path is None or path not in known:
        message = f"say which {what} is meant" if path is None else f"the linear model has no {what} '{path}'"
        raise SimulationError.of(
            "linear/unknown-name",
            message,
            help=one_of("" if path is None else str(path), map(str, known), f"it has no {what}s")
            + f"; linearise(..., {what}s=[...]) chooses them",
        )
    return known.index(path)
