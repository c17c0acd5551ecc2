"""The certificate of a reduced model: what went and why, how far its answers are off, and what nobody has checked.

Plain data that a stranger can read and repeat; `propermodel.reduction.certify` makes it, `certificate_document` writes
it, `verify` repeats it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from propermodel.analysis.comparison import Feature
from propermodel.analysis.features import Undefined
from propermodel.analysis.spectral_change import SpectralChange
from propermodel.analysis.tolerances import Tolerance
from propermodel.diagnostics import Path
from propermodel.modelling.model import Removal
from propermodel.reduction.candidates import MARGIN
from propermodel.reduction.ranges import SampledRanges
from propermodel.simulation.stepping import Stepping

BALANCED = 1e-2  # residual of an energy balance, as a share, above which it is told


@dataclass(frozen=True, slots=True, kw_only=True)
class RemovedRow:
    """An element or group that the reduced model does without.

    `alone` is the predicted root mean square of each output's change if it alone had gone, in the way that changes them
    least, as a share of the range; it is empty where nothing was predicted. A fragile one costs more alone than all
    removals together: errors cancel, which other scenarios may end.
    """

    row: Path
    kind: str
    removals: tuple[Removal, ...]  # made for it; none where the others leave it nothing to act on
    why: str
    alone: Mapping[Path, float]
    is_fragile: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CertifiedOutput:
    """The errors of one output on one scenario, by feature."""

    path: Path
    unit: str
    reference_range: float
    errors: Mapping[Feature, float | Undefined]


@dataclass(frozen=True, slots=True, kw_only=True)
class CertifiedRun:
    """What a run cost, and its energy balance, J."""

    steps: int
    supplied: float
    stored: float
    dissipated: float
    relative_residual: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CertifiedScenario:
    """What both models did on a scenario."""

    name: str
    start: float
    stop: float
    record_every: float
    integrals_every: float
    outputs: tuple[CertifiedOutput, ...]
    full: CertifiedRun
    reduced: CertifiedRun
    spectra: tuple[SpectralChange, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Size:
    """How large a model is: rows of its ranking, and states."""

    rows: int
    states: int


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """All that a reduced model rests on; `str` is the text for a reader, `warnings` what must not be overlooked."""

    model: str
    method: str  # how the removals were found
    full: Size
    reduced: Size
    tolerances: Mapping[Path, Tolerance]
    predicted: float | None  # largest error over its tolerance, before it was simulated
    removed: tuple[RemovedRow, ...]
    removals: tuple[Removal, ...]
    scenarios: tuple[CertifiedScenario, ...]
    ranges: SampledRanges | None  # of parameters
    stepping: Stepping
    versions: Mapping[str, str]
    not_checked: tuple[str, ...]
    recheck: str

    @property
    def score(self) -> float | None:
        """The largest error over its tolerance; None without tolerances, infinite where a feature was lost."""
        return max((share for _, _, _, share in self._shares()), default=None)

    @property
    def is_within(self) -> bool:
        """Whether every error is within its tolerance; so without tolerances."""
        score = self.score
        return score is None or score <= 1.0

    def _shares(self) -> Iterator[tuple[str, Path, Feature, float]]:
        """Every error over its tolerance: scenario, output, feature, share."""
        for scenario in self.scenarios:
            for output in scenario.outputs:
                tolerance = self.tolerances.get(output.path)
                for feature, share in () if tolerance is None else tolerance.shares.items():
                    error = output.errors[feature]
                    yield (
                        scenario.name,
                        output.path,
                        feature,
                        math.inf if isinstance(error, Undefined) else error / share,
                    )
        for case in () if self.ranges is None else self.ranges.worst:
            if case.output in self.tolerances:
                share = self.tolerances[case.output].shares[case.feature]
                where = ", ".join(f"{path} = {value:.4g}" for path, value in case.parameters.items())
                yield f"{case.scenario} with {where}", case.output, case.feature, case.error / share

    @property
    def warnings(self) -> tuple[str, ...]:
        """What must not be overlooked, in sentences."""
        return tuple(dict.fromkeys(self._warnings()))

    def _warnings(self) -> Iterator[str]:
        for scenario, path, feature, share in self._shares():
            if share > 1.0:
                yield f"outside its tolerance on {scenario}: {feature.value} of {path} ({share:.2f} of it)"
            elif share > MARGIN:
                yield f"little margin on {scenario}: {feature.value} of {path} uses {share:.0%} of its tolerance"
        for row in self.removed:
            if row.is_fragile:
                yield (
                    f"fragile: without {row.row} alone outputs would change more than without all that went "
                    f"(up to {max(row.alone.values()):.2%} predicted), so errors cancel"
                )
        for scenario in self.scenarios:
            yield from self._warnings_of(scenario)

    def _warnings_of(self, scenario: CertifiedScenario) -> Iterator[str]:
        for change in scenario.spectra:
            where = f"{scenario.name} at {change.time:.4g} s"
            yield from (f"lost on {where}: {mode}" for mode in change.lost)
            yield from (f"gained on {where}: {mode}" for mode in change.gained)
        stiffer = max((change for change in scenario.spectra if change.is_stiffer), key=_growth, default=None)
        if stiffer is not None:
            full, reduced = stiffer.full, stiffer.reduced
            yield (
                f"fewer states but stiffer on {scenario.name} at {stiffer.time:.4g} s: {full.order} modes up to "
                f"{full.radius:.4g} 1/s become {reduced.order} up to {reduced.radius:.4g} 1/s"
            )
        for name, run in (("full", scenario.full), ("reduced", scenario.reduced)):
            if run.relative_residual > BALANCED:
                yield f"energy of the {name} run on {scenario.name} does not balance: {run.relative_residual:.1e}"

    def __str__(self) -> str:
        return "\n".join(_lines(self))


def _growth(change: SpectralChange) -> float:
    return change.reduced.radius / change.full.radius if change.full.radius else math.inf


def _lines(certificate: Certificate) -> Iterator[str]:
    c = certificate
    yield f"{c.model}: {c.full.rows} rows and {c.full.states} states become {c.reduced.rows} and {c.reduced.states}"
    yield f"removals found by {c.method}; {c.stepping}"
    yield "what went:"
    width = max((len(str(row.row)) for row in c.removed), default=0)
    yield from (f"  {row.row!s:<{width}}  {row.why}" for row in c.removed)
    for scenario in c.scenarios:
        yield f"{scenario.name}, {scenario.start:g} to {scenario.stop:g} s:"
        for output in scenario.outputs:
            yield f"  {output.path}: {', '.join(_errors(output, c.tolerances.get(output.path)))}"
        yield (
            f"  energy balance: residual {scenario.full.relative_residual:.1e} full, "
            f"{scenario.reduced.relative_residual:.1e} reduced"
        )
        for change in scenario.spectra:
            full, reduced = change.full, change.reduced
            yield (
                f"  modes at {change.time:.4g} s: {full.order} up to {full.radius:.4g} 1/s (stiffness "
                f"{full.stiffness:.2g}) become {reduced.order} up to {reduced.radius:.4g} 1/s ({reduced.stiffness:.2g})"
            )
        yield from (f"  note: {note}" for note in scenario.notes)
    if c.ranges is not None:
        yield from _range_lines(c.ranges)
    yield from (f"warning: {warning}" for warning in c.warnings)
    yield from (f"not checked: {text}" for text in c.not_checked)
    yield f"to repeat it: {c.recheck}"


def _range_lines(ranges: SampledRanges) -> Iterator[str]:
    names = ", ".join(f"{r.parameter} {r.low:.4g} to {r.high:.4g} {r.unit}" for r in ranges.ranges)
    yield f"{ranges.samples} sets of parameters, {names}; the largest errors:"
    for case in ranges.worst:
        where = ", ".join(f"{path} = {value:.4g}" for path, value in case.parameters.items())
        yield f"  {case.output} on {case.scenario}: {case.feature.value} {case.error:.3%} with {where}"
    if ranges.unusable:
        yield f"  {ranges.unusable} comparisons say nothing: the full model did not get to the end, or lacks a feature"


def _errors(output: CertifiedOutput, tolerance: Tolerance | None) -> Iterator[str]:
    if tolerance is None:
        shown: Mapping[Feature, float | None] = dict.fromkeys((Feature.RMS, Feature.LARGEST, Feature.FINAL))
    else:
        shown = tolerance.shares
    for feature, allowed in shown.items():
        error = output.errors[feature]
        size = "lost" if isinstance(error, Undefined) else f"{error:.3%}"
        yield f"{feature.value} {size}{'' if allowed is None else f' of {allowed:.3%}'}"
