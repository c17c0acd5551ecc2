"""What the package makes of the networks of a gallery, beside what is true of them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

import propermodel as pm
from benchmarks.galleries.exhaustion import Exhaustion, Meaning, exhaust
from benchmarks.galleries.models import model_of, observable, port_of, scenario_of
from benchmarks.galleries.network import INTERVALS, FloatArray, Network

TOLERANCES = (0.01, 0.02, 0.05)
STEP_TOLERANCE = 1e-7
# No model that would change the answer may have an error this close to a tolerance, as a share of it: whether it is
# within is a matter of how it is simulated. The tolerance is moved up until there is none.
BORDER = 0.02

MEANINGS: Mapping[type, Meaning] = {
    pm.ZeroEffort: Meaning.NO_EFFORT,
    pm.ZeroFlow: Meaning.NO_FLOW,
    pm.ConstantEffort: Meaning.CONSTANT,
    pm.ConstantFlow: Meaning.CONSTANT,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One system at one tolerance."""

    system: str
    family: str
    elements: int
    is_biased: bool
    tolerance: float
    optimum: int  # elements that can go, at most
    found: int  # elements that went
    error: float  # of what was found, simulated, over the tolerance
    judged: float | None  # the same by the judge; None where it has not judged these removals
    simulations: int
    tried: int  # models, those that were refused included
    exhaustive: int  # sets of removals
    seconds: float
    removals: tuple[str, ...]  # of what was found
    best: tuple[str, ...]  # what can go, one of possibly several best sets
    best_error: float | None  # of that set over the tolerance, simulated by the package; None where nothing was missed

    @property
    def missed(self) -> int:
        """By how many elements what was found is too large; negative where a constant did what was not offered."""
        return self.optimum - self.found


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """Predicted and true errors of all single removals of one system."""

    system: str
    family: str
    elements: tuple[str, ...]
    activity: tuple[float, ...]  # index of each element
    predicted: tuple[float, ...]  # of the best way to remove it
    true: tuple[float, ...]
    ratios: tuple[float, ...]  # predicted over true, of every way that changes outputs by 0.01 % to 100 %


def cases_of(network: Network, truth: Exhaustion, tolerances: Sequence[float] = TOLERANCES) -> Iterator[Case]:
    """Search the smallest model of a network at several tolerances."""
    model, scenario = model_of(network), scenario_of(network)
    for nominal in tolerances:
        tolerance = clear_of_borders(truth, nominal)
        begin = time.perf_counter()
        found = pm.find_proper_model(
            model,
            scenario,
            {observable(network, output): tolerance for output in network.outputs},
            method=pm.Method.RODAS,
            step_tolerance=STEP_TOLERANCE,
            record_every=network.stop / INTERVALS,
        )
        best = found.best
        optimum = truth.most_removed(tolerance)
        is_missed = optimum > (0 if best is None else len(best.rows))
        removals = () if best is None else tuple(sorted(map(told, best.removals)))
        yield Case(
            system=network.name,
            family=network.family,
            elements=len(network.elements),
            is_biased=network.is_biased,
            tolerance=tolerance,
            optimum=optimum,
            found=0 if best is None else len(best.rows),
            error=0.0 if best is None else best.score,
            judged=judged(network, truth, removals, tolerance),
            simulations=found.simulations,
            tried=len(found.candidates),
            exhaustive=truth.tried,
            seconds=time.perf_counter() - begin,
            removals=removals,
            best=best_set(network, truth, tolerance),
            best_error=simulated_error(network, best_set(network, truth, tolerance), tolerance) if is_missed else None,
        )


def judged(network: Network, truth: Exhaustion, removals: Sequence[str], tolerance: float) -> float | None:
    """The error of some removals over a tolerance; None where they are not among the sets that were judged."""
    words = {
        f"{element.name} {_words(meaning)}": (k, meaning) for k, element in enumerate(network) for meaning in Meaning
    }
    meanings = [Meaning.KEEP] * len(network.elements)
    for removal in removals:
        if removal not in words:
            return None
        number, meaning = words[removal]
        meanings[number] = meaning
    found = truth.at(meanings)
    return None if found is None else float(np.max(found)) / tolerance


def simulated_error(network: Network, removals: Sequence[str], tolerance: float) -> float | None:
    """The largest error of some removals over a tolerance, simulated as in a search; None if one gives a constant.

    It is infinite where the package has no equations for what is left.
    """
    gone = [
        kind(port_of(element))
        for element in network
        for kind, meaning in ((pm.ZeroEffort, Meaning.NO_EFFORT), (pm.ZeroFlow, Meaning.NO_FLOW))
        if f"{element.name} {_words(meaning)}" in removals
    ]
    if len(gone) < len(removals):
        return None
    model, scenario = model_of(network), scenario_of(network)
    try:
        compiled = [pm.compile_model(one) for one in (model, model.without(gone))]
    except pm.ProperModelError:
        return math.inf
    full, reduced = (
        pm.simulate(
            one,
            scenario,
            method=pm.Method.RODAS,
            tolerance=STEP_TOLERANCE,
            record_every=network.stop / INTERVALS,
        )
        for one in compiled
    )
    outputs = [observable(network, output) for output in network.outputs]
    return max(output.rms for output in pm.compare(full, reduced, outputs).outputs) / tolerance


def _words(meaning: Meaning) -> str:
    return meaning.name.lower().replace("_", " ")


def clear_of_borders(truth: Exhaustion, tolerance: float) -> float:
    """The tolerance, or the next larger one at which the number of elements that can go is beyond doubt."""
    while truth.most_removed(tolerance * (1.0 + BORDER)) != truth.most_removed(tolerance * (1.0 - BORDER)):
        tolerance *= 1.0 + BORDER
    return tolerance


def best_set(network: Network, truth: Exhaustion, tolerance: float) -> tuple[str, ...]:
    """The set with the least error among those from which most is gone."""
    counts = np.where(truth.worst <= tolerance, truth.removed, -1)
    most = np.flatnonzero(counts == counts.max())
    chosen = truth.meanings[most[np.argmin(truth.worst[most])]]
    return tuple(
        f"{element.name} {_words(Meaning(meaning))}"
        for element, meaning in zip(network, chosen, strict=True)
        if meaning
    )


def told(removal: pm.Removal) -> str:
    """A removal in the words of `best_set`."""
    if isinstance(removal, pm.Freeze):
        return f"{removal.signal} frozen"
    meaning = MEANINGS.get(type(removal))
    return f"{removal.bond[0]} {type(removal).__name__.lower() if meaning is None else _words(meaning)}"


def forecast_of(network: Network, truth: Exhaustion) -> Forecast:
    """Predict all single removals from one run of the package, and look up what is true."""
    model, scenario = model_of(network), scenario_of(network)
    run = pm.simulate(
        pm.compile_model(model),
        scenario,
        method=pm.Method.RODAS,
        tolerance=STEP_TOLERANCE,
        record_every=network.stop / INTERVALS,
        integrals_every=network.stop,
    )
    prediction = pm.predict_errors(run, [observable(network, output) for output in network.outputs])
    ranking = pm.rank_activity(run)
    singles = _singles(truth)
    names, activity, predicted, true, ratios = [], [], [], [], []
    for number, element in enumerate(network):
        ways: dict[Meaning, tuple[float, float]] = {}
        bond = port_of(element)
        for removal in prediction.ways([bond]):
            meaning = MEANINGS[type(removal[0])]
            forecast = prediction.of(removal)
            if meaning in singles[number] and forecast is not None:
                ways[meaning] = forecast.worst, singles[number][meaning]
        names.append(element.name)
        activity.append(next(row.index for row in ranking.rows if row.path == bond.parent))
        predicted.append(min((p for p, _ in ways.values()), default=math.inf))
        true.append(min(singles[number].values(), default=math.inf))
        ratios += [p / t for p, t in ways.values() if 1e-4 <= t <= 1.0]
    return Forecast(
        system=network.name,
        family=network.family,
        elements=tuple(names),
        activity=tuple(activity),
        predicted=tuple(predicted),
        true=tuple(true),
        ratios=tuple(ratios),
    )


def _singles(truth: Exhaustion) -> list[dict[Meaning, float]]:
    """The largest error of every single removal, by element and meaning."""
    worst: FloatArray = truth.worst
    found: list[dict[Meaning, float]] = [{} for _ in range(truth.meanings.shape[1])]
    for row in np.flatnonzero(truth.removed == 1):
        number = int(np.flatnonzero(truth.meanings[row])[0])
        found[number][Meaning(int(truth.meanings[row, number]))] = float(worst[row])
    return found


def as_data(found: Case | Forecast) -> dict[str, object]:
    """As plain data for a file."""
    return asdict(found)


__all__ = ["BORDER", "TOLERANCES", "Case", "Forecast", "as_data", "cases_of", "exhaust", "forecast_of"]
