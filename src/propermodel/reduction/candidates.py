"""What a search for the smallest model gives: every model that was tried, and which of them to take."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from propermodel.analysis.comparison import Comparison
from propermodel.analysis.tolerances import Tolerance
from propermodel.diagnostics import Path
from propermodel.modelling.model import Model, Removal
from propermodel.presentation import notebook_html
from propermodel.reduction.claim import Condition
from propermodel.reduction.prediction import PredictedRow
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.zeros import listed

FRAGILE = 1.5  # times the error of all removals together: what one alone may cost, as predictions are not exact
MARGIN = 0.8  # of the tolerance: what a recommended model may use, as other scenarios cost more


def is_fragile(alone: float, together: float) -> bool:
    """Whether one removal alone is predicted to cost far more than all do: their errors cancel.

    Args:
        alone: The predicted error of the removal, in its best way, over the tolerance.
        together: The error of all removals over the tolerance.
    """
    return alone > FRAGILE * together


class Verdict(StrEnum):
    """What simulation says of a candidate."""

    WITHIN = "within the tolerances"
    OUTSIDE = "outside"
    REFUSED = "refused"  # no equations or no solution of them, or an output that no longer exists
    FAILED = "failed"  # a run did not reach its end


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A model that was tried: what went, what was predicted, and how far its outputs are from those of the full model.

    `score` is the largest error over its tolerance; it is infinite where there is no error to measure, and a lower
    bound where a run was ended early because it was outside (there is no comparison of that scenario then).
    """

    rows: tuple[Path, ...]
    removals: tuple[Removal, ...]
    predicted: float  # score
    score: float
    verdict: Verdict
    why: str
    states: int
    comparisons: Mapping[str, Comparison] = field(default_factory=dict[str, Comparison])  # by scenario
    cost: float = math.nan  # seconds of computing per simulated second
    fragile: tuple[Path, ...] = ()  # rows of which `is_fragile` is true

    def __str__(self) -> str:
        measured = f"{self.score:.2f}" if np.isfinite(self.score) else "-"
        return (
            f"without {len(self.rows)} rows, {self.states} states: predicted {self.predicted:.2f} of the tolerance, "
            f"measured {measured}: {self.verdict}{f' ({self.why})' if self.why else ''}"
        )


@dataclass(frozen=True, kw_only=True)
class ProperModelSearch:
    """All candidates of a search and what came of it."""

    model: Model
    tolerances: Mapping[Path, Tolerance]
    scenarios: tuple[str, ...]
    rows: int  # of the full model
    states: int
    candidates: tuple[Candidate, ...]  # in the order in which they were tried
    simulations: int
    notes: tuple[str, ...]
    alone: tuple[PredictedRow, ...]  # what every row alone would change, on the first scenario
    conditions: tuple[Condition, ...]  # under which all models were run
    stepping: Stepping

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def best(self) -> Candidate | None:
        """The smallest model within the tolerances, the one with fewer states or less error among equals."""
        within = [c for c in self.candidates if c.verdict is Verdict.WITHIN]
        return min(within, key=_place, default=None)

    @property
    def recommended(self) -> Candidate | None:
        """The smallest with a margin, for scenarios that were not tried; the best where none has one."""
        within = [c for c in self.candidates if c.verdict is Verdict.WITHIN and c.score <= MARGIN]
        return min(within, key=_place, default=self.best)

    @property
    def front(self) -> tuple[Candidate, ...]:
        """The measured candidates that no other beats in rows, states and error at once, the largest first.

        What they cost is told by each; it is measured, so it decides nothing.
        """
        measured: dict[_Place, Candidate] = {}
        for candidate in self.candidates:
            if candidate.comparisons and np.isfinite(candidate.score):
                measured.setdefault(_place(candidate), candidate)
        front = (place for place in measured if not any(_beats(other, place) for other in measured))
        return tuple(measured[place] for place in sorted(front, reverse=True))

    def reduced(self, candidate: Candidate | None = None) -> Model:
        """The model of a candidate, by default the recommended one; the full model if nothing can go."""
        chosen = candidate or self.recommended
        return self.model if chosen is None else self.model.without(chosen.removals)

    def __str__(self) -> str:
        head = (
            f"{self.model.name}: {self.rows} rows, {self.states} states; {len(self.candidates)} models tried with "
            f"{self.simulations} simulations on {', '.join(self.scenarios)}"
        )
        lines = [head, *(f"  {path}: {tolerance}" for path, tolerance in self.tolerances.items())]
        lines.append(f"{'rows':>6}{'states':>8}{'error / tolerance':>20}{'predicted':>11}")
        recommended, best = (None if c is None else _place(c) for c in (self.recommended, self.best))
        for candidate in self.front:
            place = _place(candidate)
            mark = " <- recommended" if place == recommended else " <- smallest" if place == best else ""
            lines.append(
                f"{self.rows - len(candidate.rows):>6}{candidate.states:>8}{candidate.score:>20.3f}"
                f"{candidate.predicted:>11.3f}{mark}"
            )
        if self.best is None:
            lines.append("nothing can go within these tolerances")
        elif self.best.fragile:
            names = listed(map(str, self.best.fragile))
            lines.append(f"fragile: the smallest holds because errors cancel; alone each of these costs more: {names}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


_Place = tuple[int, int, float]  # less the rows that go, states, error: less is better


def _place(candidate: Candidate) -> _Place:
    return -len(candidate.rows), candidate.states, candidate.score


def _beats(one: _Place, other: _Place) -> bool:
    """Whether one is at least as good as another in everything, and better in something."""
    return one != other and all(a <= b for a, b in zip(one, other, strict=True))
