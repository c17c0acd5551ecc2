"""The figures of a gallery: how often the optimum was found, and how well errors were predicted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.galleries.cases import BORDER
from benchmarks.measure import Json


@dataclass(frozen=True, slots=True)
class Tally:
    """What came of some cases."""

    cases: int
    optimum: int  # found models with as few elements as any, or fewer
    smaller: int  # of these, with fewer
    one_more: int
    two_more: int  # or still more
    outside: int  # by simulation or by the judge
    judged: int  # of which the judge knows the error of what was found
    simulations: float  # median
    many_simulations: float  # 90 % quantile
    most_each: float  # largest number of simulations for each element
    largest_share: float  # of simulations in all sets


@dataclass(frozen=True, slots=True)
class Prediction:
    """How well the errors of single removals are known beforehand."""

    median: float  # of Spearman's coefficient over systems
    low: float  # its 10 % quantile
    activity_median: float
    activity_low: float
    within_two: float  # share of removals


def tally(cases: Sequence[Json]) -> Tally:
    """Count the cases."""
    missed = np.array([case["missed"] for case in cases], dtype=int)
    simulations = np.array([case["simulations"] for case in cases], dtype=float)
    if not len(cases):
        return Tally(0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0)
    return Tally(
        cases=len(cases),
        optimum=int(np.sum(missed <= 0)),
        smaller=int(np.sum(missed < 0)),
        one_more=int(np.sum(missed == 1)),
        two_more=int(np.sum(missed >= 2)),
        outside=sum(case["error"] > 1.0 or (case["judged"] or 0.0) > 1.0 + BORDER for case in cases),
        judged=sum(case["judged"] is not None for case in cases),
        simulations=float(np.median(simulations)),
        many_simulations=float(np.quantile(simulations, 0.9)),
        most_each=float(np.max(simulations / [case["elements"] for case in cases])),
        largest_share=float(np.max(simulations / [case["exhaustive"] for case in cases])),
    )


def prediction_of(forecasts: Sequence[Json]) -> Prediction:
    """Compare predicted errors, and activities, with true errors."""
    predicted = [spearman(f["predicted"], f["true"]) for f in forecasts]
    activity = [spearman(f["activity"], f["true"]) for f in forecasts]
    ratios = np.array([ratio for f in forecasts for ratio in f["ratios"]])
    return Prediction(
        median=float(np.median(predicted)),
        low=float(np.quantile(predicted, 0.1)),
        activity_median=float(np.median(activity)),
        activity_low=float(np.quantile(activity, 0.1)),
        within_two=float(np.mean((ratios >= 0.5) & (ratios <= 2.0))),
    )


def spearman(first: Sequence[float], second: Sequence[float]) -> float:
    """Spearman's coefficient over the pairs in which both are finite."""
    from scipy.stats import rankdata

    a, b = np.array(first), np.array(second)
    is_known = np.isfinite(a) & np.isfinite(b)
    return float(np.corrcoef(rankdata(a[is_known]), rankdata(b[is_known]))[0, 1])
