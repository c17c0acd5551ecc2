"""Runs of the full model and of candidates beside it: what a set of removals does to the outputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from propermodel.analysis.comparison import Comparison, compare
from propermodel.analysis.features import Undefined
from propermodel.analysis.tolerances import Tolerance
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, ReductionError
from propermodel.modelling.model import Removal, Scenario
from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.claim import Condition
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.prediction import Prediction, predict_errors
from propermodel.reduction.proposals import Choice, Proposals, removals_of
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory

ROWS = 2000  # recorded of each run, where nothing else is asked for


class Trials:
    """Runs the full model, and candidates beside it."""

    def __init__(
        self,
        full: CompiledModel,
        scenarios: tuple[Scenario, ...],
        tolerances: Mapping[Path, Tolerance],
        first: Trajectory,
        record_every: float | None,
    ) -> None:
        self.full = full
        self.scenarios = scenarios
        self.tolerances = tolerances
        self._stepping = first.stepping
        self._record_every = record_every
        self.runs = (first, *(self._run(full, scenario, None) for scenario in scenarios[1:]))
        for run in self.runs:
            if run.ending.is_complete:
                _check_features(run, tolerances)
        self.predictions: tuple[Prediction, ...] = tuple(predict_errors(run, tolerances) for run in self.runs)
        self.proposals = Proposals(self.predictions, np.array([t.smallest for t in tolerances.values()]))
        self._evidence = RunEvidence.of(full, self.runs[0])

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """How every scenario is run."""
        return tuple(
            Condition(
                scenario=scenario,
                record_every=period_of(scenario, self._record_every),
                integrals_every=scenario.stop - scenario.start,
            )
            for scenario in self.scenarios
        )

    def try_out(self, choice: Choice, predicted: float) -> tuple[Candidate, int]:
        """Reformulate and simulate what a choice leaves; the candidate, and how many runs it took."""
        replacements = tuple(sorted(removals_of(choice), key=lambda removal: removal.bond))
        removals: tuple[Removal, ...] = replacements
        try:
            removals = (*replacements, *signals_to_freeze(self._evidence, replacements))
            compiled = compile_quietly(self.full.model.without(removals))
        except ProperModelError as error:
            why = error.diagnostics[0].message
            return self._candidate(choice, removals, predicted, Verdict.REFUSED, why), 0
        lost = [str(path) for path in self.tolerances if path not in compiled.lowered.observables]
        if lost:
            why = f"{', '.join(lost)} would not exist"
            return self._candidate(choice, removals, predicted, Verdict.REFUSED, why), 0
        gone = {row.path for row in self.full.system.rows} - {row.path for row in compiled.system.rows}
        comparisons: dict[str, Comparison] = {}
        score = 0.0
        for number, (scenario, reference) in enumerate(zip(self.scenarios, self.runs, strict=True), 1):
            try:
                run = self._run(compiled, scenario, list(self.tolerances))
            except ProperModelError as error:  # it cannot start: a loop of the smaller model has no solution
                why = error.diagnostics[0].message
                return self._candidate(choice, removals, predicted, Verdict.FAILED, why, gone, compiled), number
            if not run.ending.is_complete:
                why = run.ending.message
                return self._candidate(choice, removals, predicted, Verdict.FAILED, why, gone, compiled), number
            found = compare(reference, run, self.tolerances)
            comparisons[scenario.name] = found
            score = max(score, *(self.tolerances[output.path].score(output) for output in found.outputs))
            if not score <= 1.0 and number < len(self.scenarios):
                break
        verdict = Verdict.WITHIN if score <= 1.0 else Verdict.OUTSIDE
        candidate = self._candidate(choice, removals, predicted, verdict, "", gone, compiled, score, comparisons)
        return candidate, len(comparisons)

    def _candidate(
        self,
        choice: Choice,
        removals: tuple[Removal, ...],
        predicted: float,
        verdict: Verdict,
        why: str,
        gone: Iterable[Path] = (),
        compiled: CompiledModel | None = None,
        score: float = float("inf"),
        comparisons: Mapping[str, Comparison] | None = None,
    ) -> Candidate:
        return Candidate(
            rows=tuple(sorted({*choice, *gone})),
            removals=removals,
            predicted=predicted,
            score=score,
            verdict=verdict,
            why=why,
            states=len((compiled or self.full).system.states),
            comparisons={} if comparisons is None else comparisons,
        )

    def _run(self, compiled: CompiledModel, scenario: Scenario, record: Sequence[Path] | None) -> Trajectory:
        return simulate(
            compiled,
            scenario,
            method=self._stepping.method,
            step=self._stepping.step,
            jacobian_every=self._stepping.jacobian_every,
            tolerance=self._stepping.tolerance,
            record=record,
            record_every=period_of(scenario, self._record_every),
            integrals_every=scenario.stop - scenario.start,
        )


def period_of(scenario: Scenario, given: float | None) -> float:
    """The period of recording, s."""
    return (scenario.stop - scenario.start) / ROWS if given is None else given


def _check_features(run: Trajectory, tolerances: Mapping[Path, Tolerance]) -> None:
    """See that the full model's outputs have the features that are to be kept.

    Raises:
        ReductionError: one does not.
    """
    for error in compare(run, run, tolerances).outputs:
        for feature in tolerances[error.path].shares:
            lacking = error.of(feature)
            if isinstance(lacking, Undefined):
                raise ReductionError.of(
                    "reduction/undefined-feature",
                    f"'{error.path}' has no {feature.value} on {run.scenario.name}: {lacking.why}",
                    help="give a tolerance of another feature (rms, final), or a scenario in which it has this one",
                )
