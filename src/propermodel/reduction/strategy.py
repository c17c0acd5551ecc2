"""The order in which sets of removals are tried: from the largest that is predicted to fit, then one row at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.prediction import Replacement
from propermodel.reduction.proposals import PASSING, Choice, Proposed
from propermodel.reduction.trials import Trials

TRIES_PER_SIZE = 3
TRIES_TO_REFINE = 8


class Strategy:
    """A search in progress: what has been tried, and with how many simulations."""

    def __init__(
        self, trials: Trials, most_simulations: int, progress: Callable[[Candidate, int], None] | None
    ) -> None:
        self._trials = trials
        self._most = most_simulations
        self._progress = progress
        self.tried: dict[frozenset[Replacement], Candidate] = {}
        self.simulations = 0

    def run(self) -> None:
        """Propose, verify from small to large, refine."""
        pools = self._trials.proposals.beam()
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
        proposals = self._trials.proposals
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
        return self._trials.try_out(node.choice, node.score)

    def _is_within(self, node: Proposed) -> bool:
        return self.tried[node.key].verdict is Verdict.WITHIN

    def _is_spent(self) -> bool:
        return self.simulations >= self._most
