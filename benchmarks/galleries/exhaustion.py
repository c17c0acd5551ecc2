"""The errors of all smaller models of a linear network: every subset of its elements, with every replacement.

Elements are taken out one after the other, for many models at once, each by one violation of its law (rank one). A set
without a solution is not followed further: a passive network is singular on a line with Re s > 0 only if what has been
taken out states something twice, whatever is left, and this stays true whatever else goes. No other set is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from benchmarks.galleries.judge import ComplexArray, Lines, Response, respond
from benchmarks.galleries.network import FloatArray, Half, Kind, Network

IntArray = NDArray[np.int8]

SINGULAR = 1e-9  # an answer below this share of what it was in the full network, at all lines, is none
MOST_WITH_CONSTANTS = 60_000  # sets, beyond which constants are offered only to what carries a bias
AT_ONCE = 24e6  # numbers in one array


class Meaning(IntEnum):
    """What becomes of an element."""

    KEEP = 0
    NO_EFFORT = 1
    NO_FLOW = 2
    CONSTANT = 3  # effort of a compliance, flow of an inertia


@dataclass(frozen=True, slots=True)
class Choice:
    """What may become of an element: it stays, or one of its two quantities becomes a value."""

    meaning: Meaning
    half: Half
    value: float = 0.0


Choices = Sequence[Sequence[Choice]]  # of each element


@dataclass(frozen=True, slots=True)
class Exhaustion:
    """All smaller networks that have a solution."""

    meanings: IntArray  # (networks, elements)
    errors: FloatArray  # (networks, outputs): root mean square of the change, as a share of the output's range
    choices: Choices
    tried: int  # sets, those without a solution included

    @property
    def removed(self) -> IntArray:
        """How many elements are gone from each network."""
        return np.count_nonzero(self.meanings, axis=1).astype(np.int8)

    @property
    def worst(self) -> FloatArray:
        """The largest error of each network."""
        return self.errors.max(axis=1)

    def most_removed(self, tolerance: float) -> int:
        """How many elements can go at most within a tolerance of all outputs."""
        return int(np.max(self.removed, where=self.worst <= tolerance, initial=0))

    def at(self, meanings: Sequence[Meaning]) -> FloatArray | None:
        """The errors of one network; None if it has no solution."""
        found = np.flatnonzero(np.all(self.meanings == np.array(meanings, dtype=np.int8), axis=1))
        return self.errors[found[0]] if len(found) else None


def exhaust(network: Network) -> Exhaustion:
    """Judge every smaller network."""
    response, lines = respond(network), Lines(network.stop)
    seen = lines.instants(response.moved) + response.equilibrium[:, np.newaxis]
    choices = choices_of(network, seen, response.equilibrium)
    ranges = np.ptp(lines.instants(response.outputs), axis=1)
    meanings: list[IntArray] = []
    errors: list[FloatArray] = []
    for some, changes in _leaves(_root(response, lines), choices):
        wrong = lines.instants(changes) / ranges[:, np.newaxis]
        errors.append(np.sqrt(np.mean(wrong * wrong, axis=-1)))
        meanings.append(some)
    tried = int(np.prod([len(some) for some in choices]))
    return Exhaustion(np.concatenate(meanings), np.concatenate(errors), choices, tried)


def choices_of(network: Network, seen: FloatArray, equilibrium: FloatArray, most: int = MOST_WITH_CONSTANTS) -> Choices:
    """Every element may stay, or lose its effort or flow; storage may give a constant, where that is affordable.

    The constant is the mean over the window, weighted with the size of the partner. Beyond `most` sets it is offered
    only to storage that carries a bias.

    Args:
        network: The full network.
        seen: (efforts then flows, instants) in its run.
        equilibrium: (efforts then flows) at its start.
        most: Sets that are affordable.
    """
    count = len(network.elements)
    stores = [element.kind is not Kind.RESISTANCE for element in network]
    is_affordable = 3 ** (count - sum(stores)) * 4 ** sum(stores) <= most
    found: list[tuple[Choice, ...]] = []
    for number, element in enumerate(network):
        zero = (
            Choice(Meaning.KEEP, Half.EFFORT),
            Choice(Meaning.NO_EFFORT, Half.EFFORT),
            Choice(Meaning.NO_FLOW, Half.FLOW),
        )
        half = Half.EFFORT if element.kind is Kind.COMPLIANCE else Half.FLOW
        own, other = (number, count + number) if half is Half.EFFORT else (count + number, number)
        is_biased = abs(equilibrium[own]) > 1e-9 * float(np.max(np.abs(seen[own])))
        if not stores[number] or not (is_affordable or is_biased):
            found.append(zero)
            continue
        weights = np.abs(seen[other])
        total = float(np.sum(weights))
        mean = float(seen[own] @ weights) / total if total > 0.0 else float(np.mean(seen[own]))
        found.append((*zero, Choice(Meaning.CONSTANT, half, mean)))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class _Batch:
    """Networks in which the same elements, the first ones, have been decided; arrays begin with the networks."""

    meanings: IntArray  # of the elements that have been decided
    own: ComplexArray  # (efforts and flows, open elements, laws of open elements, lines)
    now: ComplexArray  # (efforts and flows, open elements, lines)
    answers: ComplexArray  # (outputs, laws of open elements, lines)
    changes: ComplexArray  # (outputs, lines)

    def part(self, which: slice | NDArray[np.intp]) -> _Batch:
        """Some of the networks."""
        return _Batch(self.meanings[which], self.own[which], self.now[which], self.answers[which], self.changes[which])

    def pieces(self) -> Iterator[_Batch]:
        """The same in parts whose arrays are not too large."""
        each = self.own[0].size + self.now[0].size + self.answers[0].size + self.changes[0].size
        step = max(1, int(AT_ONCE / each))
        for begin in range(0, len(self.meanings), step):
            yield self.part(slice(begin, begin + step))

    def decided(self, choice: Choice, before: FloatArray, constant: ComplexArray) -> _Batch:
        """The networks that have a solution after a decision on their first open element.

        Args:
            choice: The decision.
            before: What the quantity answered to the element's own violation in the full network, by lines.
            constant: The lines of the constant 1.
        """
        added = np.full((len(self.meanings), 1), choice.meaning, dtype=np.int8)
        meanings = np.concatenate([self.meanings, added], axis=1)
        if choice.meaning is Meaning.KEEP:
            return _Batch(meanings, self.own[:, :, 1:, 1:], self.now[:, :, 1:], self.answers[:, :, 1:], self.changes)
        k = 0 if choice.half is Half.EFFORT else 1
        is_sound = np.any(np.abs(self.own[:, k, 0, 0]) > SINGULAR * before, axis=1)
        left = self if np.all(is_sound) else self.part(np.flatnonzero(is_sound))
        pivot = left.own[:, k, 0, 0]
        violation = (choice.value * constant - left.now[:, k, 0]) / pivot
        share = left.own[:, k, 0, 1:] / pivot[:, np.newaxis]
        column, out = left.own[:, :, 1:, 0], left.answers[:, :, 0]
        return _Batch(
            meanings[is_sound],
            left.own[:, :, 1:, 1:] - column[:, :, :, np.newaxis] * share[:, np.newaxis, np.newaxis],
            left.now[:, :, 1:] + column * violation[:, np.newaxis, np.newaxis],
            left.answers[:, :, 1:] - out[:, :, np.newaxis] * share[:, np.newaxis],
            left.changes + out * violation[:, np.newaxis],
        )


@dataclass(frozen=True, slots=True)
class _Root:
    """The full network, and what removals are measured by."""

    batch: _Batch
    before: FloatArray  # (efforts and flows, elements, lines)
    constant: ComplexArray


def _root(response: Response, lines: Lines) -> _Root:
    _, count, size = response.own.shape
    own = response.own.reshape(2, count, count, size)
    now = response.moved + response.equilibrium[:, np.newaxis] * lines.constant
    batch = _Batch(
        meanings=np.zeros((1, 0), dtype=np.int8),
        own=own[np.newaxis],
        now=now.reshape(1, 2, count, size),
        answers=response.answers[np.newaxis],
        changes=np.zeros((1, len(response.answers), size), dtype=np.complex128),
    )
    return _Root(batch, np.abs(np.einsum("hiil->hil", own)), lines.constant)


def _leaves(root: _Root, choices: Choices) -> Iterator[tuple[IntArray, ComplexArray]]:
    """All networks, some at a time: their meanings, and the changes of their outputs."""
    pending = [root.batch]
    while pending:
        batch = pending.pop()
        number = batch.meanings.shape[1]
        if number == len(choices):
            yield batch.meanings, batch.changes
            continue
        for choice in choices[number]:
            k = 0 if choice.half is Half.EFFORT else 1
            found = batch.decided(choice, root.before[k, number], root.constant)
            if len(found.meanings):
                pending.extend(found.pieces())
