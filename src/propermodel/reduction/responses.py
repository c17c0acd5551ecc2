"""The answers of a linear model to removals, made one after the other or together.

At every line of the spectrum, for every operating point: what the efforts and flows of all ports, and the outputs, do
per unit by which the law of a port is violated, and how far they are from where they were in the run. A removal sets
one effort or flow to nothing, or to a constant, by violating its law; afterwards the others answer as the smaller model
does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.codegen.machine import BoolArray, FloatArray
from propermodel.reduction.spectra import ComplexArray, IntArray

# A removal that answers less than this share of what it did in the full model has no solution: one constraint stated
# twice, a cut of what is cut already.
SINGULAR = 1e-9


@dataclass(frozen=True, slots=True)
class Move:
    """The effort or flow (`variable`, a row of `own`) at the port of a law that is replaced by a constant."""

    law: int
    variable: int
    value: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Responses:
    """A model with the removals that have been made; arrays begin with the terms of the spectrum.

    A term is the part that one operating point has in a line; what the terms of a line do to an output adds up. Every
    removal subtracts a product of a column and a row from what ports answer; these are kept as they are, because most
    of a model that is looked at once is never asked for.
    """

    own: ComplexArray  # (terms, efforts then flows of ports, laws) of the full model
    made: tuple[tuple[ComplexArray, ComplexArray], ...] = ()  # (terms, efforts then flows), (terms, laws): of removals
    to_own_law: ComplexArray  # (terms, efforts then flows): what each answers to the law of its port
    answers: ComplexArray  # (terms, outputs, laws)
    amplitudes: ComplexArray  # (terms, efforts then flows, and the constant 1) in the run
    deviations: ComplexArray  # (terms, efforts then flows) from the run
    changes: ComplexArray  # (terms, outputs) from the run
    line: IntArray  # (terms): rising
    ranges: FloatArray  # of the outputs
    full: FloatArray  # (terms, efforts then flows): the size of `to_own_law` in the full model

    @classmethod
    def of_full(
        cls, own: ComplexArray, answers: ComplexArray, amplitudes: ComplexArray, line: IntArray, ranges: FloatArray
    ) -> Responses:
        """The full model, which answers as the run did."""
        terms, variables, ports = own.shape
        to_own_law = own[:, np.arange(variables), np.tile(np.arange(ports), 2)]
        return cls(
            own=own,
            to_own_law=to_own_law,
            answers=answers,
            amplitudes=amplitudes,
            deviations=np.zeros((terms, variables), dtype=np.complex128),
            changes=np.zeros((terms, len(ranges)), dtype=np.complex128),
            line=line,
            ranges=ranges,
            full=np.abs(to_own_law),
        )

    @property
    def ports(self) -> int:
        """The number of ports."""
        return self.own.shape[2]

    @property
    def errors(self) -> FloatArray:
        """Root mean square of the change of each output, as a share of its range."""
        return self._sizes(self.changes) / self.ranges

    def errors_without(self, moves: Sequence[Move]) -> FloatArray | None:
        """The errors of the outputs after further removals together; None if they leave no solution."""
        inverse = self._violations(moves)
        if inverse is None:
            return None
        violations = -(inverse @ self._missing(moves)[:, :, np.newaxis])[:, :, 0]
        laws = [move.law for move in moves]
        changes = self.changes + np.einsum("lmk,lk->lm", self.answers[:, :, laws], violations)
        return self._sizes(changes) / self.ranges

    def without(self, moves: Sequence[Move]) -> Responses | None:
        """The model after further removals together; None if they leave no solution."""
        inverse = self._violations(moves)
        if inverse is None:
            return None
        laws, variables = [move.law for move in moves], [move.variable for move in moves]
        violations = -(inverse @ self._missing(moves)[:, :, np.newaxis])
        share = inverse @ self._rows(variables)
        by_law = self._columns(laws)
        own_laws = np.tile(np.arange(self.ports), 2)
        return replace(
            self,
            made=(*self.made, *((by_law[:, :, k], share[:, k]) for k in range(len(moves)))),
            to_own_law=self.to_own_law - np.einsum("tvk,tkv->tv", by_law, share[:, :, own_laws]),
            answers=self.answers - self.answers[:, :, laws] @ share,
            deviations=self.deviations + (by_law @ violations)[:, :, 0],
            changes=self.changes + (self.answers[:, :, laws] @ violations)[:, :, 0],
        )

    def single_errors(self, variables: FloatArray, values: FloatArray) -> FloatArray:
        """The errors (outputs, ports) after one further removal, of each port by its variable and value.

        Not a number where that leaves no solution.
        """
        chosen = variables.astype(int)
        answered = self.to_own_law[:, chosen]
        is_singular: BoolArray = np.any(np.abs(answered) <= SINGULAR * self.full[:, chosen], axis=0)
        here = self.amplitudes[:, chosen] + self.deviations[:, chosen] - self.amplitudes[:, -1:] * values
        violations = -here / np.where(is_singular, 1.0, answered)
        changes = self.changes[:, :, np.newaxis] + self.answers * violations[:, np.newaxis, :]
        found = self._sizes(changes) / self.ranges[:, np.newaxis]
        found[:, is_singular] = np.nan
        return found

    def pair_errors(self, moves: Sequence[Move]) -> FloatArray:
        """The errors (outputs, moves, moves) after two further removals together, of each pair.

        Not a number where that leaves no solution, and for two removals of one law.
        """
        laws, variables = [move.law for move in moves], [move.variable for move in moves]
        missing, full = self._missing(moves), self.full[:, variables]
        answered = self._rows(variables)[:, :, laws]  # of the variable of one, to the law of the other
        found = np.full((len(self.ranges), len(moves), len(moves)), np.nan)
        for i, law in enumerate(laws):
            others = np.flatnonzero(np.array(laws) > law)
            if others.size:
                pairs = _Pairs(
                    here=answered[:, i, i, np.newaxis],
                    there=answered[:, others, others],
                    across=answered[:, i, others],
                    back=answered[:, others, i],
                    missing=missing[:, i, np.newaxis],
                    missing_there=missing[:, others],
                    scale=full[:, i, np.newaxis] * full[:, others],
                )
                errors = self._errors_of(pairs, np.full(len(others), law), np.array(laws)[others])
                found[:, i, others] = found[:, others, i] = errors
        return found

    def errors_of_pairs(self, first: Sequence[Move], second: Sequence[Move]) -> FloatArray:
        """The errors (outputs, pairs) after two further removals, of different laws, together.

        Not a number where that leaves no solution.
        """
        laws, variables = np.array([move.law for move in first]), np.array([move.variable for move in first])
        other_laws, others = np.array([move.law for move in second]), np.array([move.variable for move in second])
        pairs = _Pairs(
            here=self.to_own_law[:, variables],
            there=self.to_own_law[:, others],
            across=self._entries(variables, other_laws),
            back=self._entries(others, laws),
            missing=self._missing(first),
            missing_there=self._missing(second),
            scale=self.full[:, variables] * self.full[:, others],
        )
        return self._errors_of(pairs, laws, other_laws)

    # -- what is left of the full model's answers ----------------------------------------------------------

    def _rows(self, variables: Sequence[int]) -> ComplexArray:
        """What some efforts and flows answer to all laws: (terms, variables, laws)."""
        found = self.own[:, variables]
        for by_law, share in self.made:
            found -= by_law[:, variables, np.newaxis] * share[:, np.newaxis]
        return found

    def _columns(self, laws: Sequence[int]) -> ComplexArray:
        """What all efforts and flows answer to some laws: (terms, variables, laws)."""
        found = self.own[:, :, laws]
        for by_law, share in self.made:
            found -= by_law[:, :, np.newaxis] * share[:, np.newaxis, laws]
        return found

    def _entries(self, variables: IntArray, laws: IntArray) -> ComplexArray:
        """What efforts and flows answer to one law each: (terms, variables)."""
        found = self.own[:, variables, laws]
        for by_law, share in self.made:
            found -= by_law[:, variables] * share[:, laws]
        return found

    def _missing(self, moves: Sequence[Move]) -> ComplexArray:
        variables = [move.variable for move in moves]
        values = np.array([move.value for move in moves])
        here = self.amplitudes[:, variables] + self.deviations[:, variables]
        return here - self.amplitudes[:, -1:] * values

    def _violations(self, moves: Sequence[Move]) -> ComplexArray | None:
        """How far laws are violated per unit of what replaces them: (terms, laws, variables); None if singular."""
        variables, laws = [move.variable for move in moves], [move.law for move in moves]
        one_by_one = self._entries(np.repeat(variables, len(laws)), np.tile(laws, len(variables)))
        answered = one_by_one.reshape(len(one_by_one), len(variables), len(laws))
        before = self.full[:, variables]
        if np.any(before == 0.0):
            return None
        try:
            inverse = np.linalg.inv(answered / before[:, :, np.newaxis]).astype(np.complex128, copy=False)
        except np.linalg.LinAlgError:
            return None
        # The least singular value is at least the inverse of this norm, and far sooner found.
        is_regular = np.linalg.norm(inverse, axis=(1, 2)) < 1.0 / SINGULAR
        return inverse / before[:, np.newaxis] if np.all(is_regular) else None

    # -- errors --------------------------------------------------------------------------------------------

    def _sizes(self, changes: ComplexArray) -> FloatArray:
        """Root mean squares of changes, whose first axis are terms."""
        starts = np.flatnonzero(np.diff(self.line, prepend=-1))
        if len(starts) < len(changes):
            changes = np.add.reduceat(changes, starts, axis=0)
        return np.linalg.norm(changes, axis=0)

    def _errors_of(self, pairs: _Pairs, laws: IntArray, other_laws: IntArray) -> FloatArray:
        """The errors (outputs, pairs) of pairs of removals of these laws."""
        # Cramer's rule for the two violations.
        determinant = pairs.here * pairs.there - pairs.across * pairs.back
        is_singular = np.any((np.abs(determinant) <= SINGULAR * pairs.scale) | (pairs.scale == 0.0), axis=0)
        determinant[:, is_singular] = 1.0
        first = (pairs.across * pairs.missing_there - pairs.there * pairs.missing) / determinant
        second = (pairs.back * pairs.missing - pairs.here * pairs.missing_there) / determinant
        changes = (
            self.changes[:, :, np.newaxis]
            + self.answers[:, :, laws] * first[:, np.newaxis]
            + self.answers[:, :, other_laws] * second[:, np.newaxis]
        )
        errors = self._sizes(changes) / self.ranges[:, np.newaxis]
        errors[:, is_singular] = np.nan
        return errors


@dataclass(frozen=True, eq=False, kw_only=True)
class _Pairs:
    """Two removals each: what their variables answer to their own laws and to the other's, and what they miss."""

    here: ComplexArray  # (terms, pairs)
    there: ComplexArray
    across: ComplexArray  # of the first variable, to the second law
    back: ComplexArray
    missing: ComplexArray
    missing_there: ComplexArray
    scale: FloatArray  # the product of what both answered in the full model
