"""Certificates repeated: the same runs made again, and every number compared with the one that was recorded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from propermodel.analysis.features import Undefined
from propermodel.analysis.spectral_change import Spectrum
from propermodel.reduction.certificate import Certificate, CertifiedOutput, CertifiedRun, CertifiedScenario
from propermodel.reduction.certify import CertifiedModel, examine, size_of
from propermodel.reduction.ranges import SampledRanges, repeat_samples

REPEATS = 0.01  # of a number: within it, it is the same on another machine
NOTHING = 1e-6  # of a range or of exchanged energy, likewise


@dataclass(frozen=True, slots=True)
class Check:
    """A number of a certificate, as it was recorded and as it was found."""

    what: str
    recorded: float | str
    found: float | str
    holds: bool

    def __str__(self) -> str:
        verdict = "as recorded" if self.holds else "NOT as recorded"
        return f"{self.what}: recorded {_text(self.recorded)}, found {_text(self.found)}: {verdict}"


@dataclass(frozen=True, kw_only=True)
class Verification:
    """What came of a certificate that was repeated.

    `found` is the certificate with the numbers of the new runs, judged by the same tolerances.
    """

    recorded: Certificate
    found: Certificate
    checks: tuple[Check, ...]

    @property
    def failed(self) -> tuple[Check, ...]:
        """The numbers that are not as recorded."""
        return tuple(check for check in self.checks if not check.holds)

    @property
    def holds(self) -> bool:
        """Whether every number is as recorded, and every error within its tolerance."""
        return not self.failed and self.found.is_within

    def __str__(self) -> str:
        count = len(self.checks) - len(self.failed)
        lines = [f"{self.recorded.model}: {count} of {len(self.checks)} numbers are as recorded"]
        lines += [f"  {check}" for check in self.failed]
        score = self.found.score
        if score is not None:
            verdict = "every error is within its tolerance" if self.found.is_within else "NOT within the tolerances"
            lines.append(f"{verdict}: the largest is {score:.3f} of it")
        lines += [f"warning: {warning}" for warning in self.found.warnings]
        lines.append("the certificate holds" if self.holds else "the certificate does NOT hold")
        return "\n".join(lines)


def verify_certificate(certified: CertifiedModel) -> Verification:
    """Run a certified model and the full model again, and compare every number with the certificate.

    Numbers are taken as equal within 1 %, since other machines round differently, and a run amplifies that.

    Raises:
        ProperModelError: a model has no equations, a scenario does not fit, or a run does not reach its end.
    """
    claim, recorded = certified.claim, certified.certificate
    runs = claim.pairs()
    full, reduced = (size_of(run.compiled) for run in runs[0])
    sampled = None if recorded.ranges is None else repeat_samples(claim, recorded.ranges)
    found = replace(recorded, full=full, reduced=reduced, scenarios=examine(claim, runs), ranges=sampled)
    return Verification(recorded=recorded, found=found, checks=tuple(_checks(recorded, found)))


def _checks(recorded: Certificate, found: Certificate) -> Iterator[Check]:
    for name in ("full", "reduced"):
        before, after = getattr(recorded, name), getattr(found, name)
        yield _count(f"rows of the {name} model", before.rows, after.rows)
        yield _count(f"states of the {name} model", before.states, after.states)
    for before, after in zip(recorded.scenarios, found.scenarios, strict=True):
        yield from _of_scenario(before, after)
    if recorded.ranges is not None and found.ranges is not None:
        yield from _of_ranges(recorded.ranges, found.ranges)


def _of_scenario(recorded: CertifiedScenario, found: CertifiedScenario) -> Iterator[Check]:
    for before, after in zip(recorded.outputs, found.outputs, strict=True):
        yield from _of_output(recorded.name, before, after)
    for name in ("full", "reduced"):
        yield from _of_run(f"{name} run on {recorded.name}", getattr(recorded, name), getattr(found, name))
    yield _count(f"instants with modes on {recorded.name}", len(recorded.spectra), len(found.spectra))
    for before, after in zip(recorded.spectra, found.spectra, strict=False):
        where = f"on {recorded.name} at {before.time:.4g} s"
        yield from _of_spectrum(f"of the full model {where}", before.full, after.full)
        yield from _of_spectrum(f"of the reduced model {where}", before.reduced, after.reduced)
        yield _count(f"critical modes lost {where}", len(before.lost), len(after.lost))
        yield _count(f"unstable modes gained {where}", len(before.gained), len(after.gained))


def _of_ranges(recorded: SampledRanges, found: SampledRanges) -> Iterator[Check]:
    yield _count("sets of parameters", recorded.samples, found.samples)
    yield _count("comparisons over the ranges that say nothing", recorded.unusable, found.unusable)
    yield _count("features over the ranges", len(recorded.worst), len(found.worst))
    again = {(case.scenario, case.output, case.feature): case.error for case in found.worst}
    for case in recorded.worst:
        what = f"largest {case.feature.value} of {case.output} over the ranges on {case.scenario}"
        yield _number(what, case.error, again.get((case.scenario, case.output, case.feature), math.nan), NOTHING)


def _of_output(scenario: str, recorded: CertifiedOutput, found: CertifiedOutput) -> Iterator[Check]:
    yield _number(f"range of {recorded.path} on {scenario}", recorded.reference_range, found.reference_range, 0.0)
    for feature, before in recorded.errors.items():
        after = found.errors[feature]
        what = f"{feature.value} of {recorded.path} on {scenario}"
        if isinstance(before, Undefined) or isinstance(after, Undefined):
            alike = isinstance(before, Undefined) and isinstance(after, Undefined)
            yield Check(what, _as_text(before), _as_text(after), alike)
        else:
            yield _number(what, before, after, NOTHING)


def _of_run(what: str, recorded: CertifiedRun, found: CertifiedRun) -> Iterator[Check]:
    names = ("supplied", "stored", "dissipated")
    scale = max(abs(getattr(recorded, name)) for name in names)
    for name in names:
        yield _number(f"energy {name}, {what}", getattr(recorded, name), getattr(found, name), NOTHING * scale)


def _of_spectrum(what: str, recorded: Spectrum, found: Spectrum) -> Iterator[Check]:
    yield _count(f"order {what}", recorded.order, found.order)
    yield _number(f"largest eigenvalue {what}", recorded.radius, found.radius, 0.0)
    yield _number(f"smallest eigenvalue {what}", recorded.slowest, found.slowest, NOTHING * recorded.radius)


def _count(what: str, recorded: int, found: int) -> Check:
    return Check(what, recorded, found, recorded == found)


def _number(what: str, recorded: float, found: float, least: float) -> Check:
    holds = found == recorded or abs(found - recorded) <= REPEATS * abs(recorded) + least < math.inf
    return Check(what, recorded, found, holds)


def _as_text(value: float | Undefined) -> float | str:
    return value.why if isinstance(value, Undefined) else value


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"
