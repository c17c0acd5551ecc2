"""The operating points of a run: instants at which the slopes of what matters are alike.

A pump that works now and then, a gear, standstill: no slope stands for the whole run there. Instants are divided in two
by the slopes that vary, again and again, as long as that explains much of how they vary.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray

IntArray = NDArray[np.int64]

MOST_POINTS = 4
VARYING = 3.0  # a slope varies that is so many times larger in a tenth of the run than in another
RELEVANT = 0.1  # of the largest term of its equation: what a term must be somewhere in the run, to count
ENOUGH = 0.85  # of all variation: what operating points need not explain better
LEAST_SHARE = 0.03  # of the instants: smaller points are not kept apart


def operating_points(rows: Sequence[int], slopes: FloatArray, terms: FloatArray) -> IntArray:
    """The operating point of every instant.

    Args:
        rows: The equation of each coefficient.
        slopes: The value of each coefficient (rows) at the instants (columns).
        terms: The same, times the variable that it is a coefficient of.

    Returns:
        Numbers from zero; all zero where nothing that matters varies.
    """
    features = _features(np.asarray(rows), slopes, terms)
    points = np.zeros(slopes.shape[1], dtype=np.int64)
    if not len(features):
        return points
    total = _variation(features)
    refused: set[int] = set()
    while points.max() + 1 < MOST_POINTS:
        spread = [0.0 if k in refused else _variation(features[:, points == k]) for k in range(points.max() + 1)]
        left = sum(_variation(features[:, points == k]) for k in range(points.max() + 1))
        widest = int(np.argmax(spread))
        if left <= (1.0 - ENOUGH) * total or spread[widest] == 0.0:
            break
        inside = np.flatnonzero(points == widest)
        other = _halves(features[:, inside])
        if min(np.sum(other), np.sum(~other)) < LEAST_SHARE * len(points):
            refused.add(widest)
            continue
        points[inside[other]] = points.max() + 1
    return points


def _features(rows: IntArray, slopes: FloatArray, terms: FloatArray) -> FloatArray:
    """The slopes that vary and matter, as shares of their largest; every equation counts alike."""
    is_finite = np.all(np.isfinite(slopes) & np.isfinite(terms), axis=1)
    rows, slopes, terms = rows[is_finite], slopes[is_finite], terms[is_finite]
    if not len(rows):
        return slopes
    sizes = np.sqrt(np.mean(terms**2, axis=1))
    largest = np.zeros(int(rows.max()) + 1)
    np.maximum.at(largest, rows, sizes)
    heights = np.abs(slopes)
    low, high = np.quantile(heights, [0.1, 0.9], axis=1)
    peak = np.max(heights, axis=1)
    matters = (sizes >= RELEVANT * largest[rows]) & (peak > 0.0)
    chosen = np.flatnonzero(matters & (np.maximum(high, 0.1 * peak) > VARYING * low))
    if not chosen.size:
        return np.zeros((0, slopes.shape[1]))
    counts = np.bincount(rows[chosen], minlength=len(largest))
    found = slopes[chosen] / (peak[chosen] * np.sqrt(counts[rows[chosen]]))[:, np.newaxis]
    return np.unique(np.round(found, 9), axis=0)


def _variation(features: FloatArray) -> float:
    return float(np.sum((features - np.mean(features, axis=1, keepdims=True)) ** 2))


def _halves(features: FloatArray) -> NDArray[np.bool_]:
    """Two groups of instants by the distance from two means (Lloyd 1982), from the direction that varies most."""
    centred = features - np.mean(features, axis=1, keepdims=True)
    _, directions = np.linalg.eigh(centred @ centred.T)
    along = directions[:, -1] @ centred
    in_second = along > 0.0
    for _ in range(50):
        if in_second.all() or not in_second.any():
            break
        first, second = np.mean(centred[:, ~in_second], axis=1), np.mean(centred[:, in_second], axis=1)
        nearer = (second - first) @ (centred - 0.5 * (first + second)[:, np.newaxis]) > 0.0
        if np.array_equal(nearer, in_second):
            break
        in_second = nearer
    return in_second
