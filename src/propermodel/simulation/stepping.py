"""How a run takes its steps: the method, and what it needs to know."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from propermodel.codegen.machine import Method
from propermodel.diagnostics import Diagnostic

DEFAULT_STEP = 2e-4  # s, of methods with steps of one length
DEFAULT_TOLERANCE = 1e-4
REFINEMENT = 10.0  # of a tolerance, where a step would be halved


@dataclass(frozen=True, slots=True)
class Stepping:
    """A method, with the step or the tolerance it goes by.

    `step` is the length of steps, s, which is shortened to meet instants; for a method that controls its steps it is
    the largest one, by default as long as instants are apart. `tolerance` is the error that such a method makes in one
    step, as a share of the size of each state.
    """

    method: Method = Method.SEMI_IMPLICIT
    step: float | None = None
    jacobian_every: int = 1
    tolerance: float = DEFAULT_TOLERANCE

    def longest(self, *spans: float) -> float:
        """The longest step, s, where instants are so far apart."""
        if not self.method.is_adaptive:
            return DEFAULT_STEP if self.step is None else self.step
        return min((math.inf if self.step is None else self.step, *spans))

    def refined(self) -> Stepping:
        """A finer one, whose answers show how good those of this one are."""
        if self.method.is_adaptive:
            return replace(self, tolerance=self.tolerance / REFINEMENT)
        return replace(self, step=self.longest() / 2.0)

    def faults(self) -> Iterator[Diagnostic]:
        """What no run can have."""
        if self.step is not None and not 0.0 < self.step < math.inf:
            yield Diagnostic(
                "simulation/step",
                f"the step is {self.step} s; it must be positive and finite",
                help="give a step well below the shortest period or time constant: simulate(..., step=1e-3)",
            )
        if self.jacobian_every < 1:
            yield Diagnostic(
                "simulation/step",
                f"{self.jacobian_every} steps shall share a Jacobian; it serves at least 1",
                help="give a whole number: simulate(..., method=Method.ROS2, jacobian_every=4)",
            )
        if not 0.0 < self.tolerance < 1.0:
            yield Diagnostic(
                "simulation/tolerance",
                f"the tolerance is {self.tolerance}; it is a share, between 0 and 1",
                help="give the error of a step as a share of each state: simulate(..., tolerance=1e-5)",
            )

    def __str__(self) -> str:
        if self.method.is_adaptive:
            return f"{self.method}, tolerance {self.tolerance:g}"
        return f"{self.method}, step {self.longest():g} s"
