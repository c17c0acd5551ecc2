"""Certificates made: both models run by the ordinary route, and what a sceptic would ask measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.analysis.balance import energy_balance
from propermodel.analysis.comparison import Feature, OutputError, compare
from propermodel.analysis.linearise import linearise
from propermodel.analysis.spectral_change import SpectralChange, spectral_change
from propermodel.codegen.versions import versions
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, ReductionError, SimulationError
from propermodel.modelling.model import Model, Removal, Scenario
from propermodel.modelling.removal_words import removal_text
from propermodel.presentation import notebook_html
from propermodel.reduction.candidates import Candidate, ProperModelSearch, Verdict, is_fragile
from propermodel.reduction.certificate import (
    Certificate,
    CertifiedOutput,
    CertifiedRun,
    CertifiedScenario,
    RemovedRow,
    Size,
)
from propermodel.reduction.claim import Claim, Condition
from propermodel.reduction.prediction import PredictedRow
from propermodel.reduction.ranges import SAMPLES, GivenRanges, SampledRanges, ranges_of, sample_ranges
from propermodel.simulation.trajectory import Trajectory

INSTANTS = (0.0, 0.5, 1.0)  # of a run, as shares of it, at which spectra are compared
RECHECK = "propermodel verify certificate.json, with the files it names beside it"
_IDLE = "idle: the other removals leave it nothing to act on"


@dataclass(frozen=True, kw_only=True, eq=False)
class CertifiedModel:
    """A reduced model with its certificate, and what is needed to repeat it: the full model and the scenarios."""

    certificate: Certificate
    full: Model
    scenarios: tuple[Scenario, ...]

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def reduced(self) -> Model:
        """The reduced model."""
        return self.full.without(self.certificate.removals)

    @property
    def claim(self) -> Claim:
        """What the certificate says can be repeated."""
        c = self.certificate
        first = c.scenarios[0].outputs if c.scenarios else ()
        return Claim(
            model=self.full,
            removals=c.removals,
            conditions=tuple(
                Condition(scenario=scenario, record_every=s.record_every, integrals_every=s.integrals_every)
                for scenario, s in zip(self.scenarios, c.scenarios, strict=True)
            ),
            outputs=tuple(output.path for output in first),
            tolerances=c.tolerances,
            stepping=c.stepping,
        )

    def __str__(self) -> str:
        return str(self.certificate)


def certify(
    search: ProperModelSearch,
    candidate: Candidate | None = None,
    *,
    ranges: GivenRanges | None = None,
    samples: int = SAMPLES,
) -> CertifiedModel:
    """Certify a model that a search has found.

    Full and reduced model are formulated and run again on every scenario, by the ordinary route.

    Args:
        search: What `find_proper_model` gave.
        candidate: One of its candidates; by default the recommended one, or where that leaves the tolerances within the
            ranges of parameters, the next larger one that does not.
        ranges: Parameters that may differ from those of the model: a share of the value to both sides, or the least and
            the greatest value in SI. Both models are run with sets of values from them.
        samples: How many sets, besides the ends of all ranges where these are few.

    Returns:
        The reduced model with its certificate, for `write_certificate`.

    Raises:
        ReductionError: the search has found no model within its tolerances, a range holds nothing, or a run does not
            reach its end.
    """
    if candidate is not None:
        return _certified(search, candidate, ranges, samples)
    chosen = search.recommended
    if chosen is None:
        raise ReductionError.of(
            "reduction/nothing-found",
            f"no model smaller than {search.model.name} is within the tolerances, so there is nothing to certify",
            help="allow more, or certify one of search.candidates all the same: certify(search, candidate)",
        )
    first = _certified(search, chosen, ranges, samples)
    if first.certificate.is_within:
        return first
    larger = (c for c in reversed(search.front) if c.verdict is Verdict.WITHIN and len(c.rows) < len(chosen.rows))
    others = (_certified(search, other, ranges, samples) for other in larger)
    return next((other for other in others if other.certificate.is_within), first)


def _certified(
    search: ProperModelSearch,
    chosen: Candidate,
    ranges: GivenRanges | None,
    samples: int,
) -> CertifiedModel:
    claim = Claim(
        model=search.model,
        removals=chosen.removals,
        conditions=search.conditions,
        outputs=tuple(search.tolerances),
        tolerances=search.tolerances,
        stepping=search.stepping,
    )
    sampled = sample_ranges(claim, ranges_of(claim, ranges), samples) if ranges else None
    runs = claim.pairs()
    measured = compare(*runs[0], claim.outputs).outputs
    return make_certificate(
        claim,
        runs,
        method="a search within tolerances",
        removed=_removed_by_search(runs[0][0].compiled, chosen, search, measured),
        predicted=chosen.predicted,
        ranges=sampled,
    )


def make_certificate(
    claim: Claim,
    runs: Sequence[tuple[Trajectory, Trajectory]],
    *,
    method: str,
    removed: Iterable[RemovedRow],
    predicted: float | None = None,
    ranges: SampledRanges | None = None,
) -> CertifiedModel:
    """The certificate of a claim, from runs of the full and the reduced model on each of its conditions."""
    full, reduced = (run.compiled for run in runs[0])
    certificate = Certificate(
        model=claim.model.name,
        method=method,
        full=size_of(full),
        reduced=size_of(reduced),
        tolerances=claim.tolerances,
        predicted=predicted,
        removed=tuple(removed),
        removals=claim.removals,
        scenarios=examine(claim, runs),
        ranges=ranges,
        stepping=claim.stepping,
        versions=versions(),
        not_checked=_not_checked(claim, ranges),
        recheck=RECHECK,
    )
    return CertifiedModel(
        certificate=certificate,
        full=claim.model,
        scenarios=tuple(condition.scenario for condition in claim.conditions),
    )


def examine(claim: Claim, runs: Sequence[tuple[Trajectory, Trajectory]]) -> tuple[CertifiedScenario, ...]:
    """Errors, energy balances and spectra of the runs of a claim."""
    return tuple(
        _scenario(claim, condition, full, reduced)
        for condition, (full, reduced) in zip(claim.conditions, runs, strict=True)
    )


def _scenario(claim: Claim, condition: Condition, full: Trajectory, reduced: Trajectory) -> CertifiedScenario:
    spectra, notes = _spectra(full, reduced)
    return CertifiedScenario(
        name=condition.scenario.name,
        start=condition.scenario.start,
        stop=full.ending.time,
        record_every=condition.record_every,
        integrals_every=condition.integrals_every,
        outputs=tuple(_output(error) for error in compare(full, reduced, claim.outputs).outputs),
        full=_run(full),
        reduced=_run(reduced),
        spectra=spectra,
        notes=notes,
    )


def _output(error: OutputError) -> CertifiedOutput:
    return CertifiedOutput(
        path=error.path,
        unit=error.unit,
        reference_range=error.reference_range,
        errors={feature: error.of(feature) for feature in Feature},
    )


def _run(run: Trajectory) -> CertifiedRun:
    balance = energy_balance(run)
    return CertifiedRun(
        steps=run.statistics.steps,
        supplied=balance.supplied,
        stored=balance.stored,
        dissipated=balance.dissipated,
        relative_residual=balance.relative_residual,
    )


def _spectra(full: Trajectory, reduced: Trajectory) -> tuple[tuple[SpectralChange, ...], tuple[str, ...]]:
    """The changes of the spectrum along a run, and where there is no linear model."""
    start, stop = full.scenario.start, full.ending.time
    found: list[SpectralChange] = []
    notes: list[str] = []
    for share in INSTANTS:
        time = stop if share == 1.0 else start + share * (stop - start)
        try:
            both = [linearise(run.compiled, run, time=time, inputs=()) for run in (full, reduced)]
        except SimulationError as error:
            notes.append(f"no modes at {time:.4g} s: {error.diagnostics[0].message}")
            continue
        found.append(spectral_change(*both, window=stop - start))
    return tuple(found), tuple(notes)


def size_of(compiled: CompiledModel) -> Size:
    """How large a model is."""
    return Size(rows=len(compiled.system.rows), states=len(compiled.system.states))


# -- why each row went -------------------------------------------------------------------------------------


def _removed_by_search(
    full: CompiledModel, chosen: Candidate, search: ProperModelSearch, measured: Sequence[OutputError]
) -> list[RemovedRow]:
    """What a candidate does without, with the predictions of the first scenario."""
    predicted = {row.row: row for row in search.alone}
    together = {error.path: error.rms for error in measured}
    gone = set(chosen.rows)
    found: list[RemovedRow] = []
    for row in full.system.rows:
        if row.path not in gone:
            continue
        own = tuple(removal for removal in chosen.removals if getattr(removal, "bond", None) in row.bonds)
        alone = _alone(predicted.get(row.path))
        found.append(
            RemovedRow(
                row=row.path,
                kind=row.kind,
                removals=own,
                why=_reason(own, alone, together),
                alone=alone,
                is_fragile=_costs_more_alone(alone, together, search),
            )
        )
    return found


def _alone(row: PredictedRow | None) -> Mapping[Path, float]:
    return {} if row is None or row.best is None else row.best.errors


def _reason(own: tuple[Removal, ...], alone: Mapping[Path, float], together: Mapping[Path, float]) -> str:
    meaning = ", ".join(map(removal_text, own)) if own else _IDLE
    if not alone:
        return f"{meaning}; nothing was predicted of it alone"
    worst = max(alone, key=lambda path: alone[path])
    return (
        f"{meaning}; going alone, in its best way, it would change {worst} by {alone[worst]:.3%} (rms, predicted); "
        f"all together change it by {together[worst]:.3%} (measured)"
    )


def _costs_more_alone(alone: Mapping[Path, float], together: Mapping[Path, float], search: ProperModelSearch) -> bool:
    """Whether one removal alone would cost more than all of them, each output counted by what it may change."""
    if not alone:
        return False
    allowed = {path: tolerance.smallest for path, tolerance in search.tolerances.items()}
    return is_fragile(max(alone[p] / allowed[p] for p in alone), max(together[p] / allowed[p] for p in together))


def _not_checked(claim: Claim, ranges: SampledRanges | None) -> tuple[str, ...]:
    """What the runs say nothing about."""
    names = ", ".join(condition.scenario.name for condition in claim.conditions)
    found = [f"scenarios other than {names}", "outputs other than those compared"]
    found.append(
        "parameters other than those of the model and the scenarios"
        if ranges is None
        else "parameters outside the ranges, and between the sets that were tried"
    )
    found.append(f"how far steps matter: both models took theirs alike ({claim.stepping})")
    if not claim.tolerances:
        found.append("tolerances: none were given, so errors are stated and not judged")
    return tuple(found)
