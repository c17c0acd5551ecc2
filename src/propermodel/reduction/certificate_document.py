"""Certificates as documents: versioned JSON of plain data, checked entry by entry within limits when it is read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from propermodel.analysis.comparison import Feature
from propermodel.analysis.features import Undefined
from propermodel.analysis.spectral_change import CriticalMode, SpectralChange, Spectrum
from propermodel.analysis.tolerances import Tolerance
from propermodel.codegen.machine import Method
from propermodel.diagnostics import ReductionError
from propermodel.modelling.documents import (
    SharedEntries,
    opened,
)
from propermodel.modelling.formats import REMOVAL
from propermodel.modelling.limits import LIMITS, Limits, exceeded
from propermodel.modelling.schema import (
    BOOLEAN,
    COUNT,
    FINITE,
    NUMBER,
    PATH,
    TEXT,
    UNIT,
    Codec,
    Json,
    Place,
    as_object,
    by_path,
    choice,
    many,
    number_data,
    optional,
    read_number,
    record,
)
from propermodel.reduction.certificate import (
    Certificate,
    CertifiedOutput,
    CertifiedRun,
    CertifiedScenario,
    RemovedRow,
    Size,
)
from propermodel.reduction.ranges import ParameterRange, SampledRanges, WorstCase
from propermodel.simulation.stepping import Stepping

FORMAT = "propermodel-certificate"
VERSION = 1
MOST_SAMPLES = 100_000  # sets of parameters that somebody else's certificate may have run


@dataclass(frozen=True, slots=True, kw_only=True)
class FileBeside:
    """A file in the folder of a certificate, as it was when that was written."""

    file: str
    sha256: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FilesBeside:
    """The files that a certificate speaks of."""

    full_model: FileBeside
    reduced_model: FileBeside
    scenarios: tuple[FileBeside, ...]


@dataclass(frozen=True, slots=True)
class Summary:
    """What follows from the numbers of a certificate, for readers."""

    within: bool
    error_over_tolerance: float | None
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, certificate: Certificate) -> Summary:
        """The summary of a certificate."""
        return cls(certificate.is_within, certificate.score, certificate.warnings)


# -- the format ---------------------------------------------------------------------------------------------


def _read_file_name(data: Json, place: Place) -> str:
    name = TEXT.read(data, place)
    if name in ("", ".", "..") or any(mark in name for mark in "/\\:"):
        raise place.fault(f"{name[:60]!r} is not the name of a file beside the certificate")
    return name


def _by_feature(inner: Codec[Any]) -> Codec[Mapping[Feature, Any]]:
    known = choice(Feature)
    return Codec(
        lambda values, refs: {feature.value: inner.write(value, refs) for feature, value in values.items()},
        lambda data, place: {
            known.read(name, place): inner.read(value, place.key(name))
            for name, value in as_object(data, place).items()
        },
    )


def _read_error(data: Json, place: Place) -> float | Undefined:
    if isinstance(data, dict):
        return UNDEFINED.read(data, place)
    return read_number(data, place)


def _read_errors(data: Json, place: Place) -> Mapping[Feature, float | Undefined]:
    errors = _EACH_ERROR.read(data, place)
    for feature in Feature:
        if feature not in errors:
            raise place.fault(f"the entry '{feature.value}' is missing")
    return errors


def _read_tolerance(data: Json, place: Place) -> Tolerance:
    shares = _SHARES.read(data, place)
    try:
        return Tolerance(**{feature.value: share for feature, share in shares.items()})
    except ReductionError as error:
        raise place.fault(error.diagnostics[0].message) from None


def _read_texts(data: Json, place: Place) -> Mapping[str, str]:
    return {name: TEXT.read(value, place.key(name)) for name, value in as_object(data, place).items()}


def _full(codec: Codec[Any], entries: Iterable[str]) -> Codec[Any]:
    """A record that is written with all entries, for readers who do not know what is usual."""
    names = tuple(entries)

    def write(value: Any, refs: Any) -> Json:
        given = codec.write(value, refs)
        return {name: given[name] if name in given else getattr(value, name) for name in names}

    return Codec(write, codec.read)


UNDEFINED = record(Undefined, why=TEXT)
_SHARES: Codec[Mapping[Feature, float]] = _by_feature(FINITE)
TOLERANCE: Codec[Tolerance] = Codec(lambda value, refs: _SHARES.write(value.shares, refs), _read_tolerance)
_EACH_ERROR: Codec[Mapping[Feature, float | Undefined]] = _by_feature(
    Codec(
        lambda value, refs: UNDEFINED.write(value, refs) if isinstance(value, Undefined) else number_data(value),
        _read_error,
    )
)
ERRORS: Codec[Mapping[Feature, float | Undefined]] = Codec(_EACH_ERROR.write, _read_errors)
TEXTS: Codec[Mapping[str, str]] = Codec(lambda value, _: dict(value), _read_texts)
STEPPING: Codec[Stepping] = _full(
    record(Stepping, method=choice(Method), step=optional(FINITE), jacobian_every=COUNT, tolerance=FINITE),
    ("method", "step", "jacobian_every", "tolerance"),
)
SIZE = record(Size, rows=COUNT, states=COUNT)
ROW = record(
    RemovedRow,
    row=PATH,
    kind=TEXT,
    removals=many(REMOVAL),
    why=TEXT,
    alone=by_path(NUMBER),
    is_fragile=BOOLEAN,
)
OUTPUT = record(CertifiedOutput, path=PATH, unit=UNIT, reference_range=FINITE, errors=ERRORS)
RUN = record(CertifiedRun, steps=COUNT, supplied=FINITE, stored=FINITE, dissipated=FINITE, relative_residual=FINITE)
SPECTRUM = record(Spectrum, order=COUNT, radius=FINITE, slowest=FINITE, unstable=COUNT)
CRITICAL_MODE = record(CriticalMode, real=FINITE, imaginary=FINITE, state=PATH)
CHANGE = record(
    SpectralChange,
    time=FINITE,
    full=SPECTRUM,
    reduced=SPECTRUM,
    lost=many(CRITICAL_MODE),
    gained=many(CRITICAL_MODE),
)
SCENARIO_RUNS = record(
    CertifiedScenario,
    name=TEXT,
    start=FINITE,
    stop=FINITE,
    record_every=FINITE,
    integrals_every=FINITE,
    outputs=many(OUTPUT),
    full=RUN,
    reduced=RUN,
    spectra=many(CHANGE),
    notes=many(TEXT),
)
RANGES = record(
    SampledRanges,
    ranges=many(record(ParameterRange, parameter=PATH, unit=UNIT, low=FINITE, high=FINITE)),
    samples=COUNT,
    unusable=COUNT,
    worst=many(
        record(
            WorstCase,
            scenario=TEXT,
            output=PATH,
            feature=choice(Feature),
            error=NUMBER,
            parameters=by_path(FINITE),
        )
    ),
)
CERTIFICATE = record(
    Certificate,
    model=TEXT,
    method=TEXT,
    full=SIZE,
    reduced=SIZE,
    tolerances=by_path(TOLERANCE),
    predicted=optional(NUMBER),
    removed=many(ROW),
    removals=many(REMOVAL),
    scenarios=many(SCENARIO_RUNS),
    ranges=optional(RANGES),
    stepping=STEPPING,
    versions=TEXTS,
    not_checked=many(TEXT),
    recheck=TEXT,
)
SUMMARY = record(Summary, within=BOOLEAN, error_over_tolerance=optional(NUMBER), warnings=many(TEXT))
BESIDE = record(FileBeside, file=Codec(TEXT.write, _read_file_name), sha256=TEXT)
FILES = record(FilesBeside, full_model=BESIDE, reduced_model=BESIDE, scenarios=many(BESIDE))


# -- documents ---------------------------------------------------------------------------------------------


def to_certificate_document(certificate: Certificate, files: FilesBeside) -> dict[str, Json]:
    """The document of a certificate: plain data that JSON can hold."""
    shared = SharedEntries()
    return {
        "format": FORMAT,
        "version": VERSION,
        "summary": SUMMARY.write(Summary.of(certificate), shared),
        **CERTIFICATE.write(certificate, shared),
        "files": FILES.write(files, shared),
    }


def from_certificate_document(document: Json, *, limits: Limits = LIMITS) -> tuple[Certificate, FilesBeside]:
    """The certificate that a document holds, and the files it speaks of.

    Raises:
        DocumentError: the document is not of this format or version, goes beyond a limit, something in it is malformed,
            or its summary is not that of its numbers.
    """
    top = Place("", SharedEntries(limits))
    given = opened(document, FORMAT, top, VERSION)
    for name in ("files", "summary"):
        if name not in given:
            raise top.fault(f"the entry '{name}' is missing")
    files = FILES.read(given.pop("files"), top.key("files"))
    summary = SUMMARY.read(given.pop("summary"), top.key("summary"))
    certificate = CERTIFICATE.read(given, top)
    _check(certificate, files, summary, top)
    return certificate, files


def _check(certificate: Certificate, files: FilesBeside, summary: Summary, top: Place) -> None:
    """See that the parts of a certificate fit each other."""
    if not certificate.scenarios:
        raise top.key("scenarios").fault("a certificate without scenarios says nothing")
    if len(files.scenarios) != len(certificate.scenarios):
        raise top.key("files").fault("there must be a file for every scenario")
    outputs = [output.path for output in certificate.scenarios[0].outputs]
    if any([output.path for output in scenario.outputs] != outputs for scenario in certificate.scenarios):
        raise top.key("scenarios").fault("every scenario must have the same outputs in the same order")
    for path in certificate.tolerances:
        if path not in outputs:
            raise top.key("tolerances").fault(f"'{path}' has a tolerance and no measured error")
    if not all(s.record_every > 0.0 and s.integrals_every > 0.0 and s.stop > s.start for s in certificate.scenarios):
        raise top.key("scenarios").fault("periods of recording and the window of a run must be above zero")
    if certificate.ranges is not None:
        _check_ranges(certificate, certificate.ranges, top.key("ranges"))
    for fault in certificate.stepping.faults():
        raise top.key("stepping").fault(fault.message, fault.help)
    for s in certificate.scenarios:
        if (s.stop - s.start) / min(s.record_every, s.integrals_every) > top.references.limits.table_points:
            raise exceeded("table_points", "a run would be recorded at too many instants", "scenarios")
    if (summary.within, summary.error_over_tolerance) != (certificate.is_within, certificate.score):
        raise top.key("summary").fault("the summary is not what the numbers of the certificate say")


def _check_ranges(certificate: Certificate, ranges: SampledRanges, place: Place) -> None:
    names = {scenario.name for scenario in certificate.scenarios}
    for case in ranges.worst:
        tolerance = certificate.tolerances.get(case.output)
        if case.scenario not in names or (tolerance is not None and case.feature not in tolerance.shares):
            raise place.key("worst").fault(
                f"the {case.feature.value} of '{case.output}' on {case.scenario!r} has no tolerance or no scenario"
            )
    if not all(r.low < r.high for r in ranges.ranges) or not ranges.ranges:
        raise place.key("ranges").fault("a range must hold something")
    if not 1 <= ranges.samples <= MOST_SAMPLES:
        raise place.key("samples").fault(f"there must be 1 to {MOST_SAMPLES} sets of parameters")
