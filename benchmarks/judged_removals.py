"""What sets of removals do to outputs by simulation, and the smallest models that other methods find with that."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import cached_property

import propermodel as pm
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, parse_path
from propermodel.modelling.model import Removal, Scenario
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.fitting import fitting_scenario
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.prediction import Replacement
from propermodel.reduction.results_file import key_of
from propermodel.simulation.trajectory import Trajectory

THRESHOLDS = (0.95, 0.97, 0.98, 0.99, 0.995, 0.998, 0.999, 0.9995, 0.9999)
ROWS = 2000  # recorded of every run

Tolerances = Mapping[str, float]  # root mean squares, as shares of the ranges of outputs


class Judge:
    """The full model on one scenario, and what becomes of its outputs without some elements; nothing runs twice."""

    def __init__(self, model: pm.Model, scenario: Scenario, step: float, outputs: Iterable[str]) -> None:
        self.full = compile_quietly(model)
        self.simulations = 0
        self._outputs = tuple(outputs)
        self._scenario = scenario
        self._step = step
        self._errors: dict[str, Mapping[str, float] | None] = {}

    @cached_property
    def run(self) -> Trajectory:
        """The run of the full model."""
        return self._simulate(self.full, self._scenario, None)

    def score(self, removals: tuple[Removal, ...], tolerances: Tolerances) -> float:
        """The largest error over its tolerance; infinite where no model is left, or its run fails."""
        key = key_of(removals)
        if key not in self._errors:
            self._errors[key] = self._measured(removals)
        errors = self._errors[key]
        return math.inf if errors is None else max(errors[path] / tolerances[path] for path in tolerances)

    def rows_left(self, removals: tuple[Removal, ...]) -> int:
        """The rows of the model that removals leave."""
        return len(compile_quietly(self.full.model.without(removals)).system.rows)

    def smallest_by_activity(self, tolerances: Tolerances) -> int | None:
        """The rows of the smallest model within the tolerances that a threshold of activity gives; None if none is."""
        within = [removals for removals in self._by_activity if self.score(removals, tolerances) <= 1.0]
        return min(map(self.rows_left, within), default=None)

    def backward(self, tolerances: Tolerances) -> int:
        """Rows left where that whose removal costs least by simulation goes, again and again, while any may.

        Each goes by the replacement that is predicted to cost least alone. A row that cost more in an earlier round
        than another costs in this one is not measured anew in it (lazy evaluation, Minoux 1978); in the last all are.
        """
        cost = {row: self._score_without((way,), tolerances) for row, way in self._ways.items()}
        gone: dict[Path, tuple[Replacement, ...]] = {}
        while True:
            best, least = None, 1.0
            for row in sorted(cost, key=lambda row: cost[row]):
                if best is not None and cost[row] >= least:
                    break
                cost[row] = self._score_without((*gone.values(), self._ways[row]), tolerances)
                if cost[row] <= least:
                    best, least = row, cost[row]
            if best is None:
                return len(self.full.system.rows) - len(gone)
            gone[best] = self._ways[best]
            del cost[best]

    @cached_property
    def _by_activity(self) -> tuple[tuple[Removal, ...], ...]:
        ranking = pm.rank_activity(self.run)
        plans = (
            pm.plan_reduction(self.full, self.run, ranking, threshold=threshold, protected=self._outputs)
            for threshold in THRESHOLDS
        )
        return tuple(plan.removals for plan in plans)

    @cached_property
    def _ways(self) -> Mapping[Path, tuple[Replacement, ...]]:
        prediction = pm.predict_errors(self.run, self._outputs)
        return {row.row: row.best.removals for row in prediction.rows() if row.best is not None}

    @cached_property
    def _evidence(self) -> RunEvidence:
        return RunEvidence.of(self.full, self.run)

    def _score_without(self, ways: Iterable[tuple[Replacement, ...]], tolerances: Tolerances) -> float:
        chosen = tuple(removal for way in ways for removal in way)
        try:
            frozen = signals_to_freeze(self._evidence, chosen)
        except ProperModelError:
            return math.inf
        return self.score((*chosen, *frozen), tolerances)

    def _measured(self, removals: tuple[Removal, ...]) -> Mapping[str, float] | None:
        try:
            reduced = compile_quietly(self.full.model.without(removals))
            if any(parse_path(path) not in reduced.lowered.observables for path in self._outputs):
                return None
            run = self._simulate(reduced, fitting_scenario(reduced, self._scenario), self._outputs)
        except ProperModelError:
            return None
        self.simulations += 1
        if not run.ending.is_complete:
            return None
        return {str(error.path): error.rms for error in pm.compare(self.run, run, self._outputs).outputs}

    def _simulate(self, compiled: CompiledModel, scenario: Scenario, record: tuple[str, ...] | None) -> Trajectory:
        return pm.simulate(
            compiled,
            scenario,
            step=self._step,
            record=record,
            record_every=(scenario.stop - scenario.start) / ROWS,
            integrals_every=scenario.stop - scenario.start,
        )
