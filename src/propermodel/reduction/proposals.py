"""Sets of removals worth trying: a beam search over predicted errors, with several scenarios at once.

What costs nothing once something else is gone (the rest of a branch that leads nowhere, what no output can feel) goes
with it, so that groups need no search of their own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path
from propermodel.reduction.prediction import Prediction, Replacement
from propermodel.reduction.responses import Responses

WIDTH = 6  # sets of one size that are carried on
WIDTH_OF_LARGE = 3  # in models of more than `LARGE` rows
LARGE = 20
PASSING = 3.0  # times the tolerance: what a set may be predicted to cost on the way to one that cancels it
ALIKE = 1e-3  # scores that differ by less than this share belong to models that answer alike
_FREE = 1e-6  # an increase of the error by less than this share of the tolerance costs nothing

T = TypeVar("T")
Choice = Mapping[Path, tuple[Replacement, ...]]  # of each row that goes: what replaces it


@dataclass(frozen=True, eq=False)
class Proposed:
    """A set of removals, and its predicted score: the largest error over its tolerance."""

    choice: Choice
    score: float

    @property
    def key(self) -> frozenset[Replacement]:
        """The removals."""
        return removals_of(self.choice)


@dataclass(frozen=True, slots=True)
class Extension:
    """One more row that may go, and the predicted score afterwards."""

    row: Path
    way: tuple[Replacement, ...]
    score: float


@dataclass(frozen=True, eq=False)
class Node(Proposed):
    """The same with the models that are left, one for each scenario."""

    left: tuple[Responses, ...]
    offers: tuple[Extension, ...]  # every row that could go next, each way, the least score first

    def alone(self) -> Proposed:
        """Without the models, which are large."""
        return Proposed(self.choice, self.score)


def removals_of(choice: Choice) -> frozenset[Replacement]:
    """All removals of a choice."""
    return frozenset(removal for way in choice.values() for removal in way)


def sorted_by_score(nodes: Iterable[Proposed]) -> list[Proposed]:
    """The least predicted score first; what is alike in it comes after all that differ."""
    return _distinct_first(sorted(nodes, key=lambda node: node.score), lambda node: node.score)


def _distinct_first(items: Sequence[T], score: Callable[[T], float]) -> list[T]:
    """Items in rising order of their scores, those after the others whose score nearly equals that of the one before.

    Sets with one score mostly differ in something that no output feels: to try another says nothing more.
    """
    distinct: list[T] = []
    alike: list[T] = []
    last = -math.inf
    for item in items:
        is_alike = score(item) - last <= ALIKE * score(item)
        (alike if is_alike else distinct).append(item)
        last = score(item)
    return distinct + alike


def _in_order(choice: Choice) -> list[Replacement]:
    return [removal for way in choice.values() for removal in way]


class Proposals:
    """Predicts, for several scenarios, what removals cost against tolerances."""

    def __init__(self, predictions: Sequence[Prediction], tolerances: FloatArray) -> None:
        """Prepare the ways to remove each row.

        Args:
            predictions: One for each scenario, of the same outputs.
            tolerances: Of the outputs, as shares of their ranges.
        """
        self._predictions = tuple(predictions)
        self._tolerances = tolerances
        first = self._predictions[0]
        self._rows = {row.path: row.bonds for row in first.compiled.system.rows}
        # A constant has one value for all scenarios, that of the first.
        self._ways = {path: first.ways(bonds) for path, bonds in self._rows.items()}
        self._refused: list[frozenset[Replacement]] = []

    def root(self) -> Node:
        """The full model."""
        left = tuple(prediction.responses for prediction in self._predictions)
        return Node({}, 0.0, left, self._offers({}, left))

    @cached_property
    def alone(self) -> Mapping[Path, float]:
        """The least predicted score of every row that goes alone."""
        return {offer.row: offer.score for offer in reversed(self.root().offers)}

    def node(self, choice: Choice) -> Node | None:
        """The models that a choice leaves; None if it leaves no solution."""
        if not choice:
            return self.root()
        left: list[Responses] = []
        for prediction in self._predictions:
            found = prediction.responses.without([prediction.move(removal) for removal in _in_order(choice)])
            if found is None:
                return None
            left.append(found)
        score = max(self._score(responses.errors) for responses in left)
        return Node(choice, score, tuple(left), self._offers(choice, left))

    def proposed(self, choice: Choice) -> Proposed | None:
        """A choice with its predicted score; None if it leaves no solution."""
        scores: list[float] = []
        for prediction in self._predictions:
            errors = prediction.responses.errors_without([prediction.move(removal) for removal in _in_order(choice)])
            if errors is None:
                return None
            scores.append(self._score(errors))
        return Proposed(choice, max(scores))

    def extended(self, node: Node, extension: Extension) -> Node | None:
        """The node with one more row gone, and all rows that this makes free."""
        found = self._with(node, extension.row, extension.way)
        return None if found is None else self.closed(found)

    def closed(self, node: Node) -> Node:
        """The node without all rows that cost nothing any more."""
        while True:
            cheapest = next(iter(node.offers), None)
            if cheapest is None or cheapest.score > node.score + _FREE:
                return node
            further = self._with(node, cheapest.row, cheapest.way)
            if further is None:
                return node
            node = further

    def refuse(self, removals: frozenset[Replacement]) -> None:
        """Propose no set any more that contains these removals, which together leave no model."""
        self._refused.append(removals)

    def is_refused(self, removals: frozenset[Replacement]) -> bool:
        """Whether a set contains removals that together leave no model."""
        return self.refused_part(removals) is not None

    def refused_part(self, removals: frozenset[Replacement]) -> frozenset[Replacement] | None:
        """The part of a set of which it is known that it leaves no model; None if there is none."""
        return next((refused for refused in self._refused if refused <= removals), None)

    def pairs(self, node: Node, limit: float) -> list[Proposed]:
        """Two more rows that may go together, although perhaps neither may alone; the least score first.

        Args:
            node: The models that are left.
            limit: The largest predicted score.
        """
        singles = [
            (row, way) for row in self._rows if row not in node.choice for way in self._ways[row] if len(way) == 1
        ]
        if len(singles) < 2:
            return []
        scores = np.zeros((len(singles), len(singles)))
        for responses, prediction in zip(node.left, self._predictions, strict=True):
            errors = responses.pair_errors([prediction.move(way[0]) for _, way in singles])
            scores = np.maximum(scores, np.max(errors / self._tolerances[:, np.newaxis, np.newaxis], axis=0))
        first, second = np.nonzero(np.triu(scores <= limit, 1))
        found: list[Proposed] = []
        for i, j in zip(first, second, strict=True):
            (row, way), (other, other_way) = singles[i], singles[j]
            choice = {**node.choice, row: way, other: other_way}
            if row != other and not self.is_refused(removals_of(choice)):
                found.append(Proposed(choice, float(scores[i, j])))
        return sorted(found, key=lambda proposed: proposed.score)

    def restored(self, choice: Choice) -> list[Proposed]:
        """The choices with one row back in its place, that which helps most first."""
        without = ({row: way for row, way in choice.items() if row != back} for back in choice)
        found = (self.proposed(fewer) if fewer else Proposed({}, 0.0) for fewer in without)
        return sorted_by_score(proposed for proposed in found if proposed is not None)

    @property
    def is_large(self) -> bool:
        """Whether the model has many rows."""
        return len(self._rows) > LARGE

    def beam(self) -> dict[int, list[Proposed]]:
        """The best sets by the number of rows that go, as far as any is within `PASSING` times the tolerance."""
        width = WIDTH_OF_LARGE if self.is_large else WIDTH
        pools: dict[int, list[Proposed]] = {}
        here = [self.root()]
        seen: set[frozenset[Replacement]] = set()
        while here:
            offers = sorted(
                (
                    (extension.score, number, extension)
                    for number, node in enumerate(here)
                    for extension in node.offers
                    if extension.score <= PASSING
                ),
                key=lambda offer: (offer[0], offer[1], offer[2].row),
            )
            following: list[Node] = []
            for _, number, extension in _distinct_first(offers, lambda offer: offer[0]):
                if len(following) == width:
                    break
                way = frozenset(extension.way)
                if here[number].key | way in seen:
                    continue
                seen.add(here[number].key | way)
                node = self.extended(here[number], extension)
                if node is None or (node.key in seen and node.key != here[number].key | way):
                    continue
                seen.add(node.key)
                following.append(node)
                pools.setdefault(len(node.choice), []).append(node.alone())
            here = following
        return {size: sorted_by_score(nodes) for size, nodes in pools.items()}

    # -- one row -----------------------------------------------------------------------------------------

    def _score(self, errors: FloatArray) -> float:
        return float(np.max(errors / self._tolerances))

    def _scores(self, scenario: int, left: Responses, ways: Sequence[tuple[Replacement, ...]]) -> list[float | None]:
        """The score after each of some ways alone, one scenario's; None where it leaves no solution."""
        moves = [[self._predictions[scenario].move(removal) for removal in way] for way in ways]
        found: list[float | None] = [None] * len(ways)
        # Those of one and of two ports are most of them, and computed together.
        groups: dict[object, list[int]] = {}
        for number, way in enumerate(ways):
            kind = type(way[0]) if len(way) == 1 else len(way)
            groups.setdefault(kind, []).append(number)
        for kind, numbers in groups.items():
            if kind == 2:
                errors = left.errors_of_pairs([moves[k][0] for k in numbers], [moves[k][1] for k in numbers])
            elif isinstance(kind, type):
                laws = [moves[k][0].law for k in numbers]
                variables, values = np.zeros(left.ports), np.zeros(left.ports)
                variables[laws], values[laws] = zip(
                    *((moves[k][0].variable, moves[k][0].value) for k in numbers), strict=True
                )
                errors = left.single_errors(variables, values)[:, laws]
            else:
                several = [left.errors_without(moves[k]) for k in numbers]
                nothing = np.full(len(self._tolerances), np.nan)
                errors = np.array([nothing if item is None else item for item in several]).T
            for number, column in zip(numbers, errors.T, strict=True):
                found[number] = None if np.any(np.isnan(column)) else self._score(column)
        return found

    def _with(self, node: Node, row: Path, way: tuple[Replacement, ...]) -> Node | None:
        left: list[Responses] = []
        for responses, prediction in zip(node.left, self._predictions, strict=True):
            found = responses.without([prediction.move(removal) for removal in way])
            if found is None:
                return None
            left.append(found)
        score = max(self._score(responses.errors) for responses in left)
        choice = {**node.choice, row: way}
        return Node(choice, score, tuple(left), self._offers(choice, left))

    def _offers(self, choice: Choice, left: Sequence[Responses]) -> tuple[Extension, ...]:
        gone = removals_of(choice)
        open_ways = [
            (row, way)
            for row in self._rows
            if row not in choice
            for way in self._ways[row]
            if not (self._refused and self.is_refused(gone | frozenset(way)))
        ]
        every = [self._scores(k, responses, [way for _, way in open_ways]) for k, responses in enumerate(left)]
        found: list[Extension] = []
        for (row, way), scores in zip(open_ways, zip(*every, strict=True), strict=True):
            known = [score for score in scores if score is not None]
            if len(known) == len(scores):
                found.append(Extension(row, way, max(known)))
        return tuple(sorted(found, key=lambda extension: (extension.score, extension.row)))
