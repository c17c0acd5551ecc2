"""The order in which sets of removals are tried: first the largest that is predicted to fit, then a few more rows."""

from __future__ import annotations

import math
import os
import statistics
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

from propermodel.diagnostics import Path
from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.prediction import Replacement
from propermodel.reduction.proposals import PASSING, Choice, Node, Proposed, removals_of, sorted_by_score
from propermodel.reduction.trials import Prepared, Trials

TRIES_PER_SIZE = 3
TRIES_PER_SIZE_OF_LARGE = 8
NEAR_MISS = 2.0  # times the tolerance
TRIES_BEFORE_NET = 40  # simulations without a success after which a beam is given up in a large model
TRIES_TO_REFINE = 8
TRIES_OF_PAIRS = 12
PAIRS = 2.0  # times the tolerance: what a pair of removals may be predicted to cost
EXCHANGES = 1.5  # the same for a row that comes back while others go
EXCHANGED = 6  # rows that come back in turn, those that help most
REMEMBERED = 10  # latest trials by which predictions are corrected
LARGEST_CORRECTION = 3.0
TRUSTED = 2.0  # a correction beyond which the beam may have gone astray
FIRST_BLOCK = 8  # rows that the net takes away at once


class Strategy:
    """A search in progress: what has been tried, and with how many simulations."""

    def __init__(
        self, trials: Trials, most_simulations: int, progress: Callable[[Candidate, int], None] | None
    ) -> None:
        self._trials = trials
        self._most = most_simulations
        self._progress = progress
        self._same: dict[str, Candidate] = {}  # by the model that is left
        self._ratios: deque[float] = deque(maxlen=REMEMBERED)
        self.tried: dict[frozenset[Replacement], Candidate] = {}
        self.simulations = 0

    def run(self) -> None:
        """Propose, verify from large sets to small ones, cast the net in large models, refine."""
        proposals = self._trials.proposals
        best = self._largest_within(proposals.beam())
        if proposals.is_large and not (best and self._is_trusted()):
            net = self._net()
            if len(net) > len(best):
                best = net
        self._refine(best)

    # -- from predictions ----------------------------------------------------------------------------------

    def _largest_within(self, pools: dict[int, list[Proposed]]) -> Choice:
        """The largest set that simulation confirms, among those of a beam and of what is near them."""
        best: Choice = {}
        failed = math.inf  # sizes from here on
        tries = TRIES_PER_SIZE_OF_LARGE if self._trials.proposals.is_large else TRIES_PER_SIZE
        while not self._is_spent() and not (not best and self._is_astray()):
            pools = self._without_refused(pools)
            open_pools = {
                size: [node for node in nodes[:tries] if node.key not in self.tried]
                for size, nodes in pools.items()
                if len(best) < size < failed
            }
            sizes = [size for size, nodes in open_pools.items() if nodes]
            if not sizes:
                break
            likely = [size for size in sizes if pools[size][0].score * self._correction() <= 1.0]
            size = max(likely, default=min(sizes))
            before = len(self.tried)
            found = self._first_within(open_pools[size])
            if found is not None:
                best = found.choice
                continue
            if len(self.tried) == before or any(self._is_judged(node) for node in pools[size][:tries]):
                failed = size
            if self._trials.proposals.is_large:
                self._add_near_misses(pools, open_pools[size])
        return best

    def _add_near_misses(self, pools: dict[int, list[Proposed]], nodes: Iterable[Proposed]) -> None:
        """Beside a set that was almost within the tolerances: the same with one of its rows back.

        Decisions that come a little sooner or later make true errors jump from one set to the next, where predicted
        ones do not; so what is near a miss is worth as much as what a beam has found.
        """
        for node in nodes:
            candidate = self.tried.get(node.key)
            if candidate is not None and candidate.comparisons and 1.0 < candidate.score <= NEAR_MISS:
                pool = pools.setdefault(len(node.choice) - 1, [])
                known = {other.key for other in pool}
                pool += [fewer for fewer in self._trials.proposals.restored(node.choice) if fewer.key not in known]

    def _is_judged(self, node: Proposed) -> bool:
        return node.key in self.tried and self.tried[node.key].verdict is not Verdict.REFUSED

    def _without_refused(self, pools: dict[int, list[Proposed]]) -> dict[int, list[Proposed]]:
        """The pools with sets mended that hold what is known to leave no model: one of these rows comes back."""
        proposals = self._trials.proposals
        found: dict[frozenset[Replacement], Proposed] = {}
        pending = [node for nodes in pools.values() for node in nodes]
        while pending:
            node = pending.pop()
            part = proposals.refused_part(node.key)
            if part is None:
                found[node.key] = node
                continue
            for row, way in node.choice.items():
                if part & frozenset(way):
                    fewer = proposals.proposed({other: kept for other, kept in node.choice.items() if other != row})
                    if fewer is not None and fewer.choice and fewer.key not in found:
                        pending.append(fewer)
        sizes: dict[int, list[Proposed]] = {}
        for node in found.values():
            sizes.setdefault(len(node.choice), []).append(node)
        return {size: sorted_by_score(nodes) for size, nodes in sizes.items()}

    # -- the net ---------------------------------------------------------------------------------------------

    def _net(self) -> Choice:
        """Rows in the order of what they cost, as many at once as pass, each by its best replacement.

        A surrogate that is far off leads a beam into corners that this order does not know.
        """
        proposals = self._trials.proposals
        node: Node | None = proposals.root()
        blocked: set[Path] = set()
        block = FIRST_BLOCK
        while node is not None and not self._is_spent():
            grown = self._grown(node, blocked, block)
            if grown is None:
                break
            further, added = grown
            if self._first_within([further.alone()]) is not None:
                node, block = further, 2 * block
            elif added == 1:
                blocked |= set(further.choice) - set(node.choice)
                node = proposals.node(node.choice)  # offers change with what has been refused
            else:
                block = max(added // 3, 1)
        return {} if node is None else node.choice

    def _grown(self, node: Node, blocked: set[Path], block: int) -> tuple[Node, int] | None:
        """A node with some more rows gone, and how many of them were chosen; None if nothing may go."""
        added = 0
        while added < block:
            offers = (offer for offer in node.offers if offer.row not in blocked and offer.score <= PASSING)
            offer = next(offers, None)
            further = None if offer is None else self._trials.proposals.extended(node, offer)
            if further is None:
                break
            node, added = further, added + 1
        return (node, added) if added else None

    # -- refinement ------------------------------------------------------------------------------------------

    def _refine(self, choice: Choice) -> None:
        """Take further rows away, alone, in pairs or in exchange for one that comes back, while any passes."""
        proposals = self._trials.proposals
        while not self._is_spent() and (node := proposals.node(choice)) is not None:
            following = self._one_more(node) or self._pair_or_exchange(node)
            if following is None:
                return
            closed = proposals.node(following.choice)
            choice = following.choice
            if closed is not None and len((free := proposals.closed(closed)).choice) > len(choice):
                passed = self._first_within([free.alone()])
                choice = choice if passed is None else passed.choice

    def _one_more(self, node: Node) -> Proposed | None:
        offers = [offer for offer in node.offers if offer.score * self._lenience() <= PASSING][:TRIES_TO_REFINE]
        found = (self._trials.proposals.extended(node, offer) for offer in offers)
        return self._first_within([further.alone() for further in found if further is not None])

    def _pair_or_exchange(self, node: Node) -> Proposed | None:
        proposals = self._trials.proposals
        pool = proposals.pairs(node, PAIRS / self._lenience())
        for fewer in proposals.restored(node.choice)[:EXCHANGED]:
            base = proposals.node(fewer.choice)
            if base is not None:
                pool += [
                    pair
                    for pair in proposals.pairs(base, EXCHANGES / self._lenience())
                    if not set(node.choice.items()) <= set(pair.choice.items())
                ]
        different = {pair.key: pair for pair in pool}.values()
        return self._first_within(sorted(different, key=lambda pair: pair.score)[:TRIES_OF_PAIRS])

    # -- trials ----------------------------------------------------------------------------------------------

    def _first_within(self, nodes: Sequence[Proposed]) -> Proposed | None:
        """The first of some sets that simulation confirms, as many at a time as there are processors."""
        waiting = [node for node in nodes if node.key not in self.tried]
        workers = min(os.cpu_count() or 1, TRIES_PER_SIZE)
        while waiting and not self._is_spent():
            ready: list[Prepared] = []
            twins: list[Prepared] = []  # that leave the same model as one that is ready
            while waiting and len(ready) < workers:
                node = waiting.pop(0)
                if not self._trials.proposals.is_refused(node.key):
                    for prepared in self._prepared(node):
                        is_twin = any(prepared.fingerprint == other.fingerprint for other in ready)
                        (twins if is_twin else ready).append(prepared)
            with ThreadPoolExecutor(workers) as pool:
                answers = list(pool.map(self._trials.judge, ready))
            for prepared, (candidate, runs) in zip(ready, answers, strict=True):
                self.simulations += runs
                self._same[prepared.fingerprint] = candidate
                if candidate.score < math.inf and prepared.node.score > 0.0:
                    self._ratios.append(candidate.score / prepared.node.score)
                self._keep(prepared.node, candidate)
            for twin in twins:
                self._keep(twin.node, self._trials.renamed(self._same[twin.fingerprint], twin))
            if any(candidate.verdict is Verdict.WITHIN for candidate, _ in answers):
                break
        within = [node for node in nodes if node.key in self.tried and self._is_within(node)]
        return min(within, key=lambda node: self.tried[node.key].score, default=None)

    def _prepared(self, node: Proposed) -> list[Prepared]:
        """The compiled candidate, where it has to be simulated; what is refused is learnt."""
        prepared = self._trials.prepare(node)
        if isinstance(prepared, Candidate):
            self._keep(node, prepared)
            part = self._trials.fewest_refused(node.choice)
            if part is not None:
                self._trials.proposals.refuse(removals_of(part))
            return []
        known = self._same.get(prepared.fingerprint)
        if known is not None:
            self._keep(node, self._trials.renamed(known, prepared))
            return []
        return [prepared]

    def _keep(self, node: Proposed, candidate: Candidate) -> None:
        self.tried[node.key] = candidate
        if self._progress is not None:
            self._progress(candidate, self.simulations)

    def _correction(self) -> float:
        """By how much the latest errors were larger than predicted."""
        found = statistics.median(self._ratios) if self._ratios else 1.0
        return min(max(found, 1.0 / LARGEST_CORRECTION), LARGEST_CORRECTION)

    def _is_trusted(self) -> bool:
        """Whether the latest errors were much as predicted."""
        return 1.0 / TRUSTED <= self._correction() <= TRUSTED

    def _is_astray(self) -> bool:
        """Whether nothing has passed for so long that the beam of a large model will not lead anywhere."""
        return self._trials.proposals.is_large and self.simulations >= TRIES_BEFORE_NET

    def _lenience(self) -> float:
        """The correction of limits that are generous already: they only widen."""
        return min(self._correction(), 1.0)

    def _is_within(self, node: Proposed) -> bool:
        return self.tried[node.key].verdict is Verdict.WITHIN

    def _is_spent(self) -> bool:
        return self.simulations >= self._most
