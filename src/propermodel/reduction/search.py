"""The smallest model whose outputs stay within tolerances: prediction proposes, simulation decides.

Beginning with the largest sets of removals that are predicted to be within the tolerances, models are reformulated and
simulated on every scenario, the best of a size first. A success leads to larger sets; what then remains is refined one
removal at a time. Nothing is simulated twice, and what no simulation has confirmed is not offered.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from propermodel.analysis.comparison import Comparison, compare
from propermodel.analysis.features import Undefined
from propermodel.analysis.tolerances import Tolerance
from propermodel.codegen.machine import Method
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, ReductionError
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Model, Removal, Scenario
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.prediction import Prediction, Replacement, predict_errors
from propermodel.reduction.proposals import PASSING, Choice, Proposals, Proposed, removals_of
from propermodel.simulation.choosing import Choice as MethodChoice
from propermodel.simulation.simulate import simulate
from propermodel.simulation.stepping import DEFAULT_TOLERANCE
from propermodel.simulation.trajectory import Trajectory, observable_path

TRIES_PER_SIZE = 3
TRIES_TO_REFINE = 8
ROWS = 2000  # recorded of each run, where nothing else is asked for
MARGIN = 0.8  # of the tolerance: what a recommended model may use, as other scenarios cost more


Allowed = float | Tolerance  # of an output; a number is a root mean square


class Verdict(StrEnum):
    """What simulation says of a candidate."""

    WITHIN = "within the tolerances"
    OUTSIDE = "outside"
    REFUSED = "refused"  # no equations, or an output that no longer exists
    FAILED = "failed"  # a run did not reach its end


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A model that was tried: what went, what was predicted, and how far its outputs are from those of the full model.

    `score` is the largest error over its tolerance; it is infinite where there is no error to measure.
    """

    rows: tuple[Path, ...]
    removals: tuple[Removal, ...]
    predicted: float  # score
    score: float
    verdict: Verdict
    why: str
    states: int
    comparisons: Mapping[str, Comparison] = field(default_factory=dict[str, Comparison])  # by scenario

    def __str__(self) -> str:
        measured = f"{self.score:.2f}" if np.isfinite(self.score) else "-"
        return (
            f"without {len(self.rows)} rows, {self.states} states: predicted {self.predicted:.2f} of the tolerance, "
            f"measured {measured}: {self.verdict}{f' ({self.why})' if self.why else ''}"
        )


@dataclass(frozen=True, kw_only=True)
class ProperModelSearch:
    """All candidates of a search and what came of it."""

    model: Model
    tolerances: Mapping[Path, Tolerance]
    scenarios: tuple[str, ...]
    rows: int  # of the full model
    states: int
    candidates: tuple[Candidate, ...]  # in the order in which they were tried
    simulations: int
    notes: tuple[str, ...]

    @property
    def best(self) -> Candidate | None:
        """The smallest model within the tolerances, the one with fewer states or less error among equals."""
        within = [c for c in self.candidates if c.verdict is Verdict.WITHIN]
        return min(within, key=lambda c: (-len(c.rows), c.states, c.score), default=None)

    @property
    def recommended(self) -> Candidate | None:
        """The smallest with a margin, for scenarios that were not tried; the best where none has one."""
        within = [c for c in self.candidates if c.verdict is Verdict.WITHIN and c.score <= MARGIN]
        return min(within, key=lambda c: (-len(c.rows), c.states, c.score), default=self.best)

    @property
    def front(self) -> tuple[Candidate, ...]:
        """The candidates that no other beats in size and error, the largest model first."""
        measured = sorted((c for c in self.candidates if np.isfinite(c.score)), key=lambda c: (-len(c.rows), c.score))
        found: list[Candidate] = []
        for candidate in measured:
            if not found or candidate.score < found[-1].score:
                found.append(candidate)
        return tuple(reversed(found))

    def reduced(self, candidate: Candidate | None = None) -> Model:
        """The model of a candidate, by default the recommended one; the full model if nothing can go."""
        chosen = candidate or self.recommended
        return self.model if chosen is None else self.model.without(chosen.removals)

    def __str__(self) -> str:
        head = (
            f"{self.model.name}: {self.rows} rows, {self.states} states; {len(self.candidates)} models tried with "
            f"{self.simulations} simulations on {', '.join(self.scenarios)}"
        )
        lines = [head, *(f"  {path}: {tolerance}" for path, tolerance in self.tolerances.items())]
        lines.append(f"{'rows':>6}{'states':>8}{'error / tolerance':>20}{'predicted':>11}")
        for candidate in self.front:
            mark = (
                " <- recommended" if candidate is self.recommended else " <- smallest" if candidate is self.best else ""
            )
            lines.append(
                f"{self.rows - len(candidate.rows):>6}{candidate.states:>8}{candidate.score:>20.3f}"
                f"{candidate.predicted:>11.3f}{mark}"
            )
        if self.best is None:
            lines.append("nothing can go within these tolerances")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


def find_proper_model(
    model: Model,
    scenarios: Scenario | Iterable[Scenario],
    tolerances: Mapping[Path, Allowed] | Mapping[str, Allowed] | Mapping[Expr, Allowed],
    *,
    method: MethodChoice = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    step_tolerance: float = DEFAULT_TOLERANCE,
    record_every: float | None = None,
    most_simulations: int = 200,
    progress: Callable[[Candidate, int], None] | None = None,
) -> ProperModelSearch:
    """Find the smallest model whose outputs stay within tolerances on all scenarios.

    Args:
        model: The full model.
        scenarios: What it is for. Those that matter most first; scenarios for verification count like all others.
        tolerances: Of each output that matters: the largest root mean square of its change, as a share of its range in
            the full model's run; or a `Tolerance` for other features. Predictions know root mean squares alone and are
            judged by the smallest share of a tolerance; simulation judges every feature.
        method: How a step is taken; with "auto" a short trial of the full model decides for all.
        step: Largest step, s.
        jacobian_every: How many steps of an implicit method may share one Jacobian.
        step_tolerance: The error of one step, where the method controls it.
        record_every: Period of recording, s; by default a two-thousandth of each scenario.
        most_simulations: After so many runs of candidates no further one begins.
        progress: Called with every candidate, and the number of simulations so far.

    Returns:
        Every model that was tried; `recommended`, `best` and `front` choose among them.

    Raises:
        ReductionError: there is no scenario or tolerance, an output lacks a feature that its tolerance names, or a run
            of the full model did not reach its end.
        SimulationError: a scenario does not fit the model.
    """
    every = (scenarios,) if isinstance(scenarios, Scenario) else tuple(scenarios)
    wanted = {observable_path(output): Tolerance.of(allowed) for output, allowed in tolerances.items()}
    if not every or not wanted:
        raise ReductionError.of(
            "reduction/tolerances",
            "a search needs a scenario, and outputs with tolerances",
            help='for 1 % of its range: find_proper_model(model, scenario, {"body.flange.flow": 0.01})',
        )
    full = compile_quietly(model)
    first = simulate(
        full,
        every[0],
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=step_tolerance,
        record_every=_period(every[0], record_every),
        integrals_every=every[0].stop - every[0].start,
    )
    runner = _Runner(full, every, wanted, first, record_every)
    search = _Search(runner, most_simulations, progress)
    search.run()
    return ProperModelSearch(
        model=model,
        tolerances=wanted,
        scenarios=tuple(scenario.name for scenario in every),
        rows=len(runner.full.system.rows),
        states=len(runner.full.system.states),
        candidates=tuple(search.tried.values()),
        simulations=search.simulations,
        notes=runner.predictions[0].notes,
    )


class _Runner:
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
            record_every=_period(scenario, self._record_every),
            integrals_every=scenario.stop - scenario.start,
        )


def _period(scenario: Scenario, given: float | None) -> float:
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


class _Search:
    def __init__(
        self, runner: _Runner, most_simulations: int, progress: Callable[[Candidate, int], None] | None
    ) -> None:
        self._runner = runner
        self._most = most_simulations
        self._progress = progress
        self.tried: dict[frozenset[Replacement], Candidate] = {}
        self.simulations = 0

    def run(self) -> None:
        """Propose, verify from small to large, refine."""
        pools = self._runner.proposals.beam()
        best: Proposed | None = None
        likely = [size for size, nodes in pools.items() if nodes[0].score <= 1.0]
        start = max(likely, default=0)
        for size in sorted((size for size in pools if size <= start), reverse=True):
            best = self._first_within(pools[size][:TRIES_PER_SIZE])
            if best is not None or self._is_spent():
                break
        if best is not None and len(best.choice) == start:
            for size in sorted(size for size in pools if size > start):
                smaller = self._first_within(pools[size][:TRIES_PER_SIZE])
                if smaller is None:
                    break
                best = smaller
        self._refine({} if best is None else best.choice)

    def _refine(self, choice: Choice) -> None:
        """Take one more row away while any that is predicted to be near the tolerance passes."""
        proposals = self._runner.proposals
        while not self._is_spent() and (node := proposals.node(choice)) is not None:
            offers = [extension for extension in node.offers if extension.score <= PASSING][:TRIES_TO_REFINE]
            found = (proposals.extended(node, extension) for extension in offers)
            following = self._first_within([further.alone() for further in found if further is not None])
            if following is None:
                return
            choice = following.choice

    def _first_within(self, nodes: Sequence[Proposed]) -> Proposed | None:
        """The first of some sets that simulation confirms, two at a time where there are two cores."""
        waiting = [node for node in nodes if node.key not in self.tried]
        workers = min(os.cpu_count() or 1, TRIES_PER_SIZE)
        for begin in range(0, len(waiting), workers):
            if self._is_spent():
                break
            group = waiting[begin : begin + workers]
            with ThreadPoolExecutor(workers) as pool:
                answers = list(pool.map(self._try_out, group))
            for node, (candidate, runs) in zip(group, answers, strict=True):
                self.tried[node.key] = candidate
                self.simulations += runs
                if self._progress is not None:
                    self._progress(candidate, self.simulations)
            if any(candidate.verdict is Verdict.WITHIN for candidate, _ in answers):
                break
        within = [node for node in nodes if node.key in self.tried and self._is_within(node)]
        return min(within, key=lambda node: self.tried[node.key].score, default=None)

    def _try_out(self, node: Proposed) -> tuple[Candidate, int]:
        return self._runner.try_out(node.choice, node.score)

    def _is_within(self, node: Proposed) -> bool:
        return self.tried[node.key].verdict is Verdict.WITHIN

    def _is_spent(self) -> bool:
        return self.simulations >= self._most
