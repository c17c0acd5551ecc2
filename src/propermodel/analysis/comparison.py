"""Comparison of two runs on the outputs that matter."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr
from propermodel.simulation.observables import observable_path
from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class OutputError:
    """How one output of a run differs from the reference; rms and maximum as shares of the reference's range."""

    path: Path
    unit: str
    reference_range: float
    rms: float
    maximum: float
    at: float  # time of the maximum, s
    reference_final: float
    final: float

    @property
    def final_error(self) -> float:
        """The relative difference of the final values (absolute where the reference ends at zero)."""
        scale = abs(self.reference_final)
        return (self.final - self.reference_final) / scale if scale else self.final - self.reference_final

    def __str__(self) -> str:
        return (
            f"{self.path}: rms {self.rms:.3%} of its range, largest {self.maximum:.3%} at {self.at:.1f} s, "
            f"final {self.reference_final:.6g} -> {self.final:.6g} {self.unit} ({self.final_error:+.3%})"
        )


@dataclass(frozen=True)
class Comparison:
    """The differences of a run from a reference run."""

    outputs: tuple[OutputError, ...]

    def __str__(self) -> str:
        return "\n".join(str(output) for output in self.outputs)


def compare(reference: Trajectory, other: Trajectory, outputs: Iterable[Expr | Path | str]) -> Comparison:
    """Compare a run with a reference, output by output, at the instants of the reference.

    Raises:
        SimulationError: an output is not in both runs.
    """
    errors: list[OutputError] = []
    for output in outputs:
        path = observable_path(output)
        expected = reference[path]
        found = np.interp(reference.time, other.time, other[path])
        span = float(np.ptp(expected)) or float(np.max(np.abs(expected))) or 1.0
        difference = found - expected
        worst = int(np.argmax(np.abs(difference)))
        errors.append(
            OutputError(
                path=path,
                unit=reference.unit(path),
                reference_range=float(np.ptp(expected)),
                rms=float(np.sqrt(np.mean(difference**2))) / span,
                maximum=float(abs(difference[worst])) / span,
                at=float(reference.time[worst]),
                reference_final=float(expected[-1]),
                final=float(found[-1]),
            )
        )
    return Comparison(tuple(errors))
