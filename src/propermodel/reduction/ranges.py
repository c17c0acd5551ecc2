"""How far a reduced model is off when parameters move: both models run with the same sets of parameters."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.analysis.comparison import Feature, OutputError, compare_columns
from propermodel.analysis.features import Undefined
from propermodel.bondgraph.parameters import parameter_values
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Diagnostic, Faults, Path, ReductionError, nearest
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Scenario
from propermodel.reduction.claim import Claim, Condition
from propermodel.reduction.fitting import fitting_scenario
from propermodel.simulation.ensemble import Ensemble, simulate_many
from propermodel.simulation.observables import observable_path

SAMPLES = 32
MOST_CORNERS = 16  # sets at the ends of all ranges, where there are no more
STATED = (Feature.RMS, Feature.LARGEST, Feature.FINAL)  # where no tolerance says what counts

Given = float | tuple[float, float]  # a share of the value to both sides, or the least and greatest value in SI
GivenRanges = Mapping[Path, Given] | Mapping[str, Given] | Mapping[Expr, Given]


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterRange:
    """The least and the greatest value of a parameter, in SI."""

    parameter: Path
    unit: str
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The largest error of an output's feature over all sets of parameters, and the set that has it.

    It is infinite where the reduced model does not reach the end of a run, or its output lacks the feature.
    """

    scenario: str
    output: Path
    feature: Feature
    error: float
    parameters: Mapping[Path, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledRanges:
    """What sampling of parameter ranges has found.

    `unusable` counts runs of the full model that did not reach their end, and outputs that lack a feature there: they
    say nothing about the reduced model.
    """

    ranges: tuple[ParameterRange, ...]
    samples: int
    unusable: int
    worst: tuple[WorstCase, ...]


def ranges_of(
    claim: Claim, given: Mapping[Path, Given] | Mapping[str, Given] | Mapping[Expr, Given]
) -> tuple[ParameterRange, ...]:
    """The ranges of parameters, from shares of their values or least and greatest values.

    Raises:
        ReductionError: the model has no such parameter, or a range holds nothing.
    """
    compiled = compile_quietly(claim.model)
    known = compiled.graph.parameters
    values = parameter_values(known, claim.conditions[0].scenario.parameters)
    faults = Faults(ReductionError)
    found: list[ParameterRange] = []
    for name, limits in given.items():
        path = observable_path(name)
        if path not in known:
            faults.add(
                Diagnostic(
                    "reduction/ranges",
                    f"the model has no parameter '{path}'",
                    help=nearest(str(path), map(str, known)) or "propermodel show MODEL --parameters lists them",
                )
            )
            continue
        value = values[known[path].symbol]
        low, high = limits if isinstance(limits, tuple) else sorted((value * (1.0 - limits), value * (1.0 + limits)))
        if not -math.inf < low < high < math.inf:
            faults.add(
                Diagnostic(
                    "reduction/ranges",
                    f"the range {low:g} to {high:g} of '{path}' holds nothing",
                    help="give the least and the greatest value in SI, (900.0, 1500.0), or a share of its value, 0.1",
                )
            )
            continue
        found.append(ParameterRange(parameter=path, unit=known[path].unit, low=float(low), high=float(high)))
    faults.raise_if_any()
    return tuple(found)


def sample_ranges(claim: Claim, ranges: Sequence[ParameterRange], samples: int = SAMPLES) -> SampledRanges:
    """Run both models of a claim with sets of parameters from ranges, and find the largest errors.

    Sets are the ends of all ranges, if there are few, and points of Halton's sequence, the same each time.

    Raises:
        SimulationError: a scenario does not fit the full model, or a value lies outside the range that a parameter is
            declared to have.
    """
    corners = list(_corners(ranges))
    return _sample(claim, ranges, [*corners, *(_at(ranges, shares) for shares in halton(samples, len(ranges)))])


def repeat_samples(claim: Claim, found: SampledRanges) -> SampledRanges:
    """The same sets of parameters again."""
    corners = list(_corners(found.ranges))
    return sample_ranges(claim, found.ranges, max(found.samples - len(corners), 0))


def _sample(claim: Claim, ranges: Sequence[ParameterRange], sets: Sequence[Mapping[Path, float]]) -> SampledRanges:
    full, reduced = compile_quietly(claim.model), compile_quietly(claim.reduced)
    unusable = 0
    worst: list[WorstCase] = []
    for condition in claim.conditions:
        fitting = fitting_scenario(reduced, condition.scenario)
        before = _run(claim, condition, full, [_with(condition.scenario, full, chosen) for chosen in sets])
        after = _run(claim, condition, reduced, [_with(fitting, reduced, chosen) for chosen in sets])
        found, missed = _largest(claim, condition, before, after, sets)
        worst.extend(found)
        unusable += missed
    return SampledRanges(ranges=tuple(ranges), samples=len(sets), unusable=unusable, worst=tuple(worst))


def _corners(ranges: Sequence[ParameterRange]) -> Iterator[Mapping[Path, float]]:
    """The sets at the ends of all ranges, unless there are many."""
    if 2 ** len(ranges) <= MOST_CORNERS:
        for corner in itertools.product((0.0, 1.0), repeat=len(ranges)):
            yield _at(ranges, corner)


def _at(ranges: Sequence[ParameterRange], shares: Sequence[float] | FloatArray) -> Mapping[Path, float]:
    return {r.parameter: float(r.low + share * (r.high - r.low)) for r, share in zip(ranges, shares, strict=True)}


def halton(count: int, dimensions: int) -> FloatArray:
    """Points that fill the unit cube evenly (Halton (1960), Numerische Mathematik 2, 84): count x dimensions."""
    primes: list[int] = []
    candidate = 2
    while len(primes) < dimensions:
        if all(candidate % prime for prime in primes):
            primes.append(candidate)
        candidate += 1
    points = [_mirrored(number, prime) for number in range(1, count + 1) for prime in primes]
    return np.array(points).reshape(count, dimensions)


def _mirrored(number: int, base: int) -> float:
    """The digits of a number behind the point, in reverse."""
    found, size = 0.0, 1.0
    while number:
        size /= base
        found += size * (number % base)
        number //= base
    return found


def _with(scenario: Scenario, compiled: CompiledModel, chosen: Mapping[Path, float]) -> Scenario:
    """The scenario with a set of parameters, as far as the model still has them."""
    own = {path: value for path, value in chosen.items() if path in compiled.graph.parameters}
    return replace(scenario, parameters={**scenario.parameters, **own})


def _run(claim: Claim, condition: Condition, compiled: CompiledModel, scenarios: Sequence[Scenario]) -> Ensemble:
    return simulate_many(
        compiled,
        scenarios,
        method=claim.stepping.method,
        step=claim.stepping.step,
        jacobian_every=claim.stepping.jacobian_every,
        tolerance=claim.stepping.tolerance,
        record=claim.outputs,
        record_every=condition.record_every,
    )


def _largest(
    claim: Claim, condition: Condition, full: Ensemble, reduced: Ensemble, sets: Sequence[Mapping[Path, float]]
) -> tuple[list[WorstCase], int]:
    """The largest error of every feature of every output that counts, and how many comparisons nothing came of."""
    found: list[WorstCase] = []
    missed = len(full.failed)
    usable = [number for number in range(len(sets)) if number not in full.failed]
    for path in claim.outputs:
        unit = full.compiled.lowered.observables[path].unit
        expected, given = full[path], reduced[path]
        errors: dict[int, OutputError | None] = {
            number: None
            if number in reduced.failed
            else compare_columns(path, unit, full.time, expected[number], given[number])
            for number in usable
        }
        features = claim.tolerances[path].shares if path in claim.tolerances else STATED
        for feature in features:
            sizes = {number: _size(error, feature) for number, error in errors.items()}
            known = {number: size for number, size in sizes.items() if size is not None}
            missed += len(sizes) - len(known)
            if known:
                number = max(known, key=lambda n: known[n])
                found.append(
                    WorstCase(
                        scenario=condition.scenario.name,
                        output=path,
                        feature=feature,
                        error=known[number],
                        parameters=sets[number],
                    )
                )
    return found, missed


def _size(error: OutputError | None, feature: Feature) -> float | None:
    """The size of an error; infinite where the reduced model is at fault, None where the full one is."""
    if error is None:
        return math.inf
    size = error.of(feature)
    if not isinstance(size, Undefined):
        return size
    return math.inf if error.is_defined(feature) else None
