"""Runs of the full model and of candidates beside it: what a set of removals does to the outputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.analysis.comparison import Comparison, compare
from propermodel.analysis.features import Undefined
from propermodel.analysis.tolerances import Tolerance
from propermodel.bondgraph.flatten import flatten
from propermodel.causality.complete import complete_causality
from propermodel.codegen.fingerprint import fingerprint
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, ReductionError
from propermodel.modelling.files import FileName
from propermodel.modelling.model import Removal, Scenario
from propermodel.reduction.candidates import Candidate, Verdict, is_fragile
from propermodel.reduction.claim import Condition
from propermodel.reduction.divisions import divisions_by_zero
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.prediction import Prediction, Replacement, predict_errors
from propermodel.reduction.proposals import Choice, Proposals, Proposed, removals_of
from propermodel.reduction.refusals import fewest_refused
from propermodel.reduction.results_file import KnownRuns, identity_of
from propermodel.reduction.watched_run import WatchedRun, run_watched
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory
from propermodel.simulation.zeros import listed

ROWS = 2000  # recorded of each run, where nothing else is asked for


@dataclass(frozen=True, eq=False)
class Prepared:
    """A candidate that has equations, compiled. Different removals may leave the same model, with one fingerprint."""

    node: Proposed
    removals: tuple[Removal, ...]
    compiled: CompiledModel
    fingerprint: str


class Trials:
    """Runs the full model, and candidates beside it."""

    def __init__(
        self,
        full: CompiledModel,
        scenarios: tuple[Scenario, ...],
        tolerances: Mapping[Path, Tolerance],
        first: Trajectory,
        record_every: float | None,
        results: FileName | None,
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
        identity = identity_of(full.model, self.conditions, tolerances, self._stepping)
        self.known = KnownRuns() if results is None else KnownRuns.opened(results, identity)
        self._hardness = [0.0] * len(scenarios)  # the last score on each scenario

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

    def prepare(self, node: Proposed) -> Prepared | Candidate:
        """Reformulate and compile what a choice leaves; a candidate that is refused where that has no equations."""
        try:
            removals, compiled = self._reformulated(node.choice)
            if turned := divisions_by_zero(compiled, self.runs):
                names = listed(map(str, turned))
                return self._refused(node, f"it would divide by the modulus of {names}, which passes zero")
            compiled.machine(self._stepping.method)
        except ProperModelError as error:
            return self._refused(node, error.diagnostics[0].message)
        lost = [str(path) for path in self.tolerances if path not in compiled.lowered.observables]
        if lost:
            return self._refused(node, f"{', '.join(lost)} would not exist")
        program = compiled.lowered.program
        return Prepared(node, removals, compiled, fingerprint((program, tuple(compiled.graph.parameters.values()))))

    def fewest_refused(self, choice: Choice) -> Choice | None:
        """The fewest rows of a refused choice that are refused together, whatever else goes; None if there are none.

        A conflict of strokes and an output that is gone stay, whatever else goes. Not so what equations alone show:
        storage that depends on its own answer may no longer do so when its neighbour has gone as well.
        """

        def has_no_strokes(part: Choice) -> bool:
            try:
                complete_causality(flatten(self.full.model.without(_sorted(part))))
            except ProperModelError:
                return True
            return False

        def has_lost_an_output(part: Choice) -> bool:
            try:
                _, compiled = self._reformulated(part)
            except ProperModelError:
                return False
            return any(path not in compiled.lowered.observables for path in self.tolerances)

        # Strokes say it far sooner than equations.
        for is_refused in (has_no_strokes, has_lost_an_output):
            if is_refused(choice):
                return fewest_refused(choice, is_refused)
        return None

    def judge(self, prepared: Prepared) -> tuple[Candidate, int]:
        """Simulate a candidate on every scenario, the hardest first, until one is outside; how many runs that took."""
        node, compiled = prepared.node, prepared.compiled
        comparisons: dict[str, Comparison] = {}
        score, wall_s, simulated, why, verdict, runs = 0.0, 0.0, 0.0, "", Verdict.WITHIN, 0
        for number in sorted(range(len(self.scenarios)), key=lambda k: -self._hardness[k]):
            scenario = self.scenarios[number]
            run = self.known.find(prepared.removals, number)
            if run is None or (run.score(self.tolerances) <= 1.0 and run.comparison is None):
                run = self._watched(prepared, number)
                runs += 1
            self._hardness[number] = run.score(self.tolerances)
            score = max(score, self._hardness[number])
            wall_s += run.wall_s
            simulated += run.time - scenario.start
            if run.failure:
                verdict, why = Verdict.FAILED, run.failure
                break
            if run.comparison is None:
                why = f"on {scenario.name} its error had used more than the tolerance by {run.time:g} s"
            else:
                comparisons[scenario.name] = run.comparison
            if not score <= 1.0:
                verdict = Verdict.OUTSIDE
                break
        candidate = Candidate(
            rows=tuple(sorted({*node.choice, *self._gone(compiled)})),
            removals=prepared.removals,
            predicted=node.score,
            score=score,
            verdict=verdict,
            why=why,
            states=len(compiled.system.states),
            comparisons=comparisons,
            cost=wall_s / simulated if simulated > 0.0 else math.nan,
            fragile=self._fragile(node.choice, score) if verdict is Verdict.WITHIN else (),
        )
        return candidate, runs

    def _watched(self, prepared: Prepared, number: int) -> WatchedRun:
        """A run of a candidate on one scenario, which is remembered."""
        scenario = self.scenarios[number]
        every = period_of(scenario, self._record_every)
        reference = self.runs[number]
        try:
            run = run_watched(prepared.compiled, scenario, reference, self.tolerances, self._stepping, every)
        except ProperModelError as error:  # it cannot start: a loop of the smaller model has no solution
            message = error.diagnostics[0].message
            run = WatchedRun(failure=message, time=scenario.start, comparison=None, reached={}, wall_s=0.0)
        self.known.keep(prepared.removals, number, run)
        return run

    def renamed(self, known: Candidate, prepared: Prepared) -> Candidate:
        """What is known of a model that other removals have left, for these."""
        return replace(
            known,
            rows=tuple(sorted({*prepared.node.choice, *self._gone(prepared.compiled)})),
            removals=prepared.removals,
            predicted=prepared.node.score,
        )

    def _gone(self, compiled: CompiledModel) -> set[Path]:
        return {row.path for row in self.full.system.rows} - {row.path for row in compiled.system.rows}

    def _fragile(self, choice: Choice, score: float) -> tuple[Path, ...]:
        """The rows that alone, however replaced, are predicted to change far more than all do: errors cancel."""
        return tuple(sorted(row for row in choice if is_fragile(self.proposals.alone.get(row, math.inf), score)))

    def _reformulated(self, choice: Choice) -> tuple[tuple[Removal, ...], CompiledModel]:
        """The model that a choice leaves, and the removals with the signals that keep a constant.

        Raises:
            ProperModelError: it has no equations.
        """
        replacements = _sorted(choice)
        removals = (*replacements, *signals_to_freeze(self._evidence, replacements))
        return removals, compile_quietly(self.full.model.without(removals))

    def _refused(self, node: Proposed, why: str) -> Candidate:
        return Candidate(
            rows=tuple(sorted(node.choice)),
            removals=_sorted(node.choice),
            predicted=node.score,
            score=math.inf,
            verdict=Verdict.REFUSED,
            why=why,
            states=len(self.full.system.states),
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


def _sorted(choice: Choice) -> tuple[Replacement, ...]:
    return tuple(sorted(removals_of(choice), key=lambda removal: removal.bond))


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
