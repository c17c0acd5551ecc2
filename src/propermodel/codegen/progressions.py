"""Sequences of points whose coordinates grow by equal steps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

# How the step from one instance to the next is found: between so many of them and those that follow, in the order of
# their rows, the most frequent ones are tried.
_SAMPLES = 256
_LAGS = 8
_STEPS = 4

Point = tuple[int, ...]


def progressions(points: Sequence[Point], least: int) -> list[tuple[list[int], Point]]:
    """Sequences of at least so many points with equal steps, as numbers of the points, and their steps."""
    left = sorted(range(len(points)), key=points.__getitem__)
    found: list[tuple[list[int], Point]] = []
    while len(left) >= least:
        steps = Counter(
            tuple(b - a for a, b in zip(points[left[k]], points[left[k + lag]], strict=True))
            for lag in range(1, _LAGS + 1)
            for k in range(0, len(left) - lag, len(left) // _SAMPLES + 1)
        )
        best: tuple[list[list[int]], Point] = ([], ())
        covered = (0, 0)
        for step, _ in steps.most_common(_STEPS):
            chains = _chains(points, left, step, least)
            score = (sum(map(len, chains)), step.count(1))
            if score > covered:
                covered, best = score, (chains, step)
            if covered[0] == len(left):
                break
        chains, step = best
        if not chains:
            break
        found += [(chain, step) for chain in chains]
        done = {k for chain in chains for k in chain}
        left = [k for k in left if k not in done]
    return found


def _chains(points: Sequence[Point], left: Iterable[int], step: Point, least: int) -> list[list[int]]:
    at: dict[Point, list[int]] = {}
    for k in left:
        at.setdefault(points[k], []).append(k)
    if not any(step):
        return [same for same in at.values() if len(same) >= least]
    starts: list[Point] = []
    for point, same in at.items():
        before = tuple(a - b for a, b in zip(point, step, strict=True))
        starts += [point] * (len(same) - len(at.get(before, ())))
    for same in at.values():
        same.reverse()
    chains: list[list[int]] = []
    for start in starts:
        chain: list[int] = []
        point = start
        while at.get(point):
            chain.append(at[point].pop())
            point = tuple(a + b for a, b in zip(point, step, strict=True))
        if len(chain) >= least:
            chains.append(chain)
    return chains
