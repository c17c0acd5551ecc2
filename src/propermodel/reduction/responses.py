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

    A term is the part that one operating point has in a line; what the terms of a line do to an output adds up.
    """

    own: ComplexArray  # (terms, efforts then flows of ports, laws)
    answers: ComplexArray  # (terms, outputs, laws)
    amplitudes: ComplexArray  # (terms, efforts then flows, and the constant 1) in the run
    deviations: ComplexArray  # (terms, efforts then flows) from the run
    changes: ComplexArray  # (terms, outputs) from the run
    line: IntArray  # (terms): rising
    ranges: FloatArray  # of the outputs
    full: FloatArray  # (terms, efforts then flows): what each answered to its own law in the full model

    @property
    def ports(self) -> int:
        """The number of ports."""
        return self.own.shape[2]

    @property
    def errors(self) -> FloatArray:
        """Root mean square of the change of each output, as a share of its range."""
        return self._sizes(self.changes) / self.ranges

    def _sizes(self, changes: ComplexArray) -> FloatArray:
        """Root mean squares of changes, whose first axis are terms."""
        starts = np.flatnonzero(np.diff(self.line, prepend=-1))
        if len(starts) < len(changes):
            changes = np.add.reduceat(changes, starts, axis=0)
        return np.linalg.norm(changes, axis=0)

    def _missing(self, moves: Sequence[Move]) -> ComplexArray:
        variables = [move.variable for move in moves]
        values = np.array([move.value for move in moves])
        here = self.amplitudes[:, variables] + self.deviations[:, variables]
        return here - self.amplitudes[:, -1:] * values

    def _violated(self, moves: Sequence[Move]) -> ComplexArray | None:
        """What the laws taken away do to what replaces them; None if they leave no solution."""
        variables, laws = [move.variable for move in moves], [move.law for move in moves]
        found = self.own[:, variables][:, :, laws]
        before = self.full[:, variables]
        if np.any(before == 0.0) or np.any(
            np.linalg.svd(found / before[:, :, np.newaxis], compute_uv=False)[:, -1] <= SINGULAR
        ):
            return None
        return found

    def errors_without(self, moves: Sequence[Move]) -> FloatArray | None:
        """The errors of the outputs after further removals together; None if they leave no solution."""
        violated = self._violated(moves)
        if violated is None:
            return None
        violations = -np.linalg.solve(violated, self._missing(moves)[:, :, np.newaxis])[:, :, 0]
        laws = [move.law for move in moves]
        changes = self.changes + np.einsum("lmk,lk->lm", self.answers[:, :, laws], violations)
        return self._sizes(changes) / self.ranges

    def without(self, moves: Sequence[Move]) -> Responses | None:
        """The model after further removals together; None if they leave no solution."""
        violated = self._violated(moves)
        if violated is None:
            return None
        laws, variables = [move.law for move in moves], [move.variable for move in moves]
        violations = -np.linalg.solve(violated, self._missing(moves)[:, :, np.newaxis])
        share = np.linalg.solve(violated, self.own[:, variables])
        by_law, by_output = self.own[:, :, laws], self.answers[:, :, laws]
        return replace(
            self,
            own=self.own - by_law @ share,
            answers=self.answers - by_output @ share,
            deviations=self.deviations + (by_law @ violations)[:, :, 0],
            changes=self.changes + (by_output @ violations)[:, :, 0],
        )

    def single_errors(self, variables: FloatArray, values: FloatArray) -> FloatArray:
        """The errors (outputs, ports) after one further removal, of each port by its variable and value.

        Not a number where that leaves no solution.
        """
        chosen = variables.astype(int)
        ports = np.arange(self.ports)
        answered = self.own[:, chosen, ports]
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
        laws, variables = np.array([move.law for move in moves]), np.array([move.variable for move in moves])
        answered = self.own[:, variables][:, :, laws]  # of the variable of one, to the law of the other
        missing = self._missing(moves)
        full = self.full[:, variables]
        own = np.einsum("tii->ti", answered)
        found = np.full((len(self.ranges), len(moves), len(moves)), np.nan)
        for i, move in enumerate(moves):
            others = np.flatnonzero((laws > move.law) & ~np.any(full == 0.0, axis=0))
            if not others.size or np.any(full[:, i] == 0.0):
                continue
            # Cramer's rule for the two violations.
            across, back = answered[:, i, others], answered[:, others, i]
            here, there = own[:, i, np.newaxis], own[:, others]
            determinant = here * there - across * back
            scale = full[:, i, np.newaxis] * full[:, others]
            is_singular = np.any(np.abs(determinant) <= SINGULAR * scale, axis=0)
            determinant[:, is_singular] = 1.0
            first = (across * missing[:, others] - there * missing[:, i, np.newaxis]) / determinant
            second = (back * missing[:, i, np.newaxis] - here * missing[:, others]) / determinant
            changes = (
                self.changes[:, :, np.newaxis]
                + self.answers[:, :, laws[i], np.newaxis] * first[:, np.newaxis]
                + self.answers[:, :, laws[others]] * second[:, np.newaxis]
            )
            errors = self._sizes(changes) / self.ranges[:, np.newaxis]
            errors[:, is_singular] = np.nan
            found[:, i, others] = found[:, others, i] = errors
        return found
