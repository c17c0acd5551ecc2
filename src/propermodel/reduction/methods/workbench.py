"""One full model and its run, with smaller models measured against it: what all methods share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from propermodel.analysis.comparison import compare
from propermodel.analysis.linear_model import LinearModel
from propermodel.analysis.linearise import linearise
from propermodel.bondgraph.graph import Bond
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError
from propermodel.equations.system import Row
from propermodel.modelling.model import BondRemoval, JunctionKind, Removal, Scenario, ZeroEffort, ZeroFlow
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.methods.linear_runs import LinearRun
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory

LINEAR = 0.01  # root mean square over range by which a run may differ from that of the linear model at its start


@dataclass(frozen=True, slots=True, kw_only=True)
class SizedModel:
    """A smaller model: its size, and the largest root mean square of an output's change over the output's range.

    `rows` is None where states have no meaning (projections). The error is infinite where there is no run to measure,
    and `why` says why.
    """

    rows: int | None
    states: int
    error: float
    removals: tuple[Removal, ...] = ()
    why: str = ""


class Workbench:
    """The full model, its run with all observables, and a measure of smaller models that never runs one twice."""

    def __init__(
        self, run: Trajectory, outputs: Sequence[Path], *, record_every: float, tolerance: float, threshold: float
    ) -> None:
        """Prepare a comparison.

        Args:
            run: A complete run of the full model with everything recorded.
            outputs: The observables that matter.
            record_every: Period of recording, s.
            tolerance: Root mean square over range at which methods are compared.
            threshold: The share of activity that a ranking keeps, where its method has such a rule.
        """
        self.full = run.compiled
        self.run = run
        self.outputs = tuple(outputs)
        self.tolerance = tolerance
        self.threshold = threshold
        self.record_every = record_every
        self.evidence = RunEvidence.of(run.compiled, run)
        self._measured: dict[frozenset[Removal], SizedModel] = {}
        self._asked: set[frozenset[Removal]] = set()

    @property
    def scenario(self) -> Scenario:
        """What is done to every model."""
        return self.run.scenario

    @property
    def rows(self) -> tuple[Row, ...]:
        """The energy elements, and groups that count as one."""
        return self.full.system.rows

    @cached_property
    def linear(self) -> LinearRun:
        """The linear model at the start of the scenario, with the inputs that it had in the run."""
        return LinearRun.of(self.full, self.run, self.outputs)

    @cached_property
    def why_not_linear(self) -> str:
        """Why a method for linear models does not apply; empty if it does."""
        try:
            share = self.linear.misfit
        except ProperModelError as error:
            return f"there is no linear model to start from: {error.diagnostics[0].message}"
        if share <= LINEAR:
            return ""
        return (
            f"it is a method for linear models, and this run is none: the linear model at its start differs by "
            f"{share:.1%} of the range of an output"
        )

    def linear_model(self, compiled: CompiledModel) -> LinearModel:
        """The linear model of a smaller model at the start of the scenario."""
        return linearise(compiled, self.scenario, outputs=self.outputs)

    def compiled(self, removals: Iterable[Removal]) -> CompiledModel:
        """The smaller model.

        Raises:
            ProperModelError: it has no equations.
        """
        chosen = tuple(removals)
        return compile_quietly(self.full.model.without((*chosen, *signals_to_freeze(self.evidence, chosen))))

    def measure(self, removals: Iterable[Removal]) -> SizedModel:
        """Run a smaller model, and compare it with the full one."""
        chosen = tuple(sorted(removals, key=str))
        key = frozenset(chosen)
        if key not in self._measured:
            self._measured[key] = self._measure(chosen)
        if key:
            self._asked.add(key)
        return self._measured[key]

    def begin(self) -> None:
        """Count simulations anew, for the next method."""
        self._asked.clear()

    @property
    def simulations(self) -> int:
        """How many smaller models a method has asked to run, also those that another has had run before."""
        return sum(1 for key in self._asked if np.isfinite(self._measured[key].error))

    def _measure(self, removals: tuple[Removal, ...]) -> SizedModel:
        rows, states = len(self.rows), len(self.full.system.states)

        def unmeasured(why: str) -> SizedModel:
            return SizedModel(rows=rows, states=states, error=np.inf, removals=removals, why=why)

        try:
            compiled = self.compiled(removals)
            rows, states = len(compiled.system.rows), len(compiled.system.states)
            lost = [str(path) for path in self.outputs if path not in compiled.lowered.observables]
            if lost:
                return unmeasured(f"{', '.join(lost)} would not exist")
            run = self._simulated(compiled)
        except ProperModelError as error:
            return unmeasured(error.diagnostics[0].message)
        if not run.ending.is_complete:
            return unmeasured(run.ending.message)
        worst = max(output.rms for output in compare(self.run, run, self.outputs).outputs)
        error = worst if np.isfinite(worst) else np.inf
        return SizedModel(rows=rows, states=states, error=error, removals=removals)

    def _simulated(self, compiled: CompiledModel) -> Trajectory:
        stepping = self.run.stepping
        return simulate(
            compiled,
            self.scenario,
            method=stepping.method,
            step=stepping.step,
            jacobian_every=stepping.jacobian_every,
            tolerance=stepping.tolerance,
            record=self.outputs,
            record_every=self.record_every,
            integrals_every=self.scenario.stop - self.scenario.start,
        )

    def by_position(self, row: Row) -> tuple[Removal, ...]:
        """Delete the bonds of a row: the term is missing from the sum of its junction, whatever its size there."""
        return tuple(self._deletion(self.evidence.structure.bonds[name]) for name in row.bonds)

    def _deletion(self, bond: Bond) -> BondRemoval:
        end = bond.tail if not bond.tail.port else bond.head
        junction = self.evidence.structure.junctions.get(end.owner)
        is_one = junction is None or junction.kind is JunctionKind.ONE
        return ZeroEffort(bond.name) if is_one else ZeroFlow(bond.name)
