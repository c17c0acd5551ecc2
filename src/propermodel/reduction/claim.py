"""What is said of a reduced model, so that anybody can run it again: models, scenarios, tolerances, steps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.analysis.tolerances import Tolerance
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ReductionError
from propermodel.modelling.model import Model, Removal, Scenario
from propermodel.reduction.fitting import fitting_scenario
from propermodel.simulation.simulate import simulate
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A scenario with the periods at which runs of it are recorded and integrals of power kept, s."""

    scenario: Scenario
    record_every: float
    integrals_every: float


@dataclass(frozen=True, kw_only=True)
class Claim:
    """That a model without some of its elements answers like the full one, for some outputs on some scenarios."""

    model: Model
    removals: tuple[Removal, ...]
    conditions: tuple[Condition, ...]
    outputs: tuple[Path, ...]
    tolerances: Mapping[Path, Tolerance]  # of some outputs or all
    stepping: Stepping

    @property
    def reduced(self) -> Model:
        """The reduced model."""
        return self.model.without(self.removals)

    def pairs(self) -> list[tuple[Trajectory, Trajectory]]:
        """The runs of both models on every scenario.

        Raises:
            ReductionError: one does not reach its end.
            SimulationError: a scenario does not fit the full model.
        """
        return self._pairs(self.conditions, self.outputs)

    def recorded_pair(self) -> tuple[Trajectory, Trajectory]:
        """The runs of both models on the first scenario, with everything recorded.

        Raises:
            ReductionError: one does not reach its end.
            SimulationError: the scenario does not fit the full model.
        """
        return self._pairs(self.conditions[:1], None)[0]

    def _pairs(
        self, conditions: Iterable[Condition], record: Sequence[Path] | None
    ) -> list[tuple[Trajectory, Trajectory]]:
        full, reduced = compile_quietly(self.model), compile_quietly(self.reduced)
        return [
            (
                self._run(full, condition.scenario, condition, record),
                self._run(reduced, fitting_scenario(reduced, condition.scenario), condition, record),
            )
            for condition in conditions
        ]

    def _run(
        self, compiled: CompiledModel, scenario: Scenario, condition: Condition, record: Sequence[Path] | None
    ) -> Trajectory:
        run = simulate(
            compiled,
            scenario,
            method=self.stepping.method,
            step=self.stepping.step,
            jacobian_every=self.stepping.jacobian_every,
            tolerance=self.stepping.tolerance,
            record=record,
            record_every=condition.record_every,
            integrals_every=condition.integrals_every,
        )
        if not run.ending.is_complete:
            raise ReductionError.of(
                "reduction/incomplete",
                f"a run of {compiled.model.name} on {scenario.name} did not reach its end: {run.ending.message}",
                where=str(run.ending.path),
                help="certify with the step and the scenarios that the reduction was made with",
            )
        return run
