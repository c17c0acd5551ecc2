"""How much every output would change if elements were removed, predicted from one run of the full model.

A removed element no longer has the effort x (or flow) that it had in the run, or has a constant in its place. In the
linear model along the run, with g the answer of all variables to a violation of the element's law and v that of the
variable taken away, the others change by -g x / v: exactly, if the model is linear. Several removals together give as
many equations as there are of them. The efforts and flows are those that were recorded; only gains are linear.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from propermodel.analysis.ranking import ActivityRanking
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, ReductionError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import (
    ConstantEffort,
    ConstantFlow,
    ElementKind,
    Variable,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.responses import Move, Responses
from propermodel.reduction.spectra import Spectra, spectra
from propermodel.reduction.surrogate import Surrogate, fit
from propermodel.simulation.trajectory import Trajectory, observable_path
from propermodel.simulation.zeros import listed

Replacement = ZeroEffort | ZeroFlow | ConstantEffort | ConstantFlow

_WORDS = {
    ZeroEffort: "no effort",
    ZeroFlow: "no flow",
    ConstantEffort: "constant effort",
    ConstantFlow: "constant flow",
}
# What the linear model leaves unexplained of an equation beyond this share is told.
MISFIT = 0.3


@dataclass(frozen=True, slots=True)
class PredictedError:
    """What removals would do to outputs: root mean square of the change as a share of the output's range in the run."""

    removals: tuple[Replacement, ...]
    errors: Mapping[Path, float]

    @property
    def meaning(self) -> str:
        """What stands in the place of the elements."""
        return ", ".join(dict.fromkeys(_WORDS[type(removal)] for removal in self.removals))

    @property
    def worst(self) -> float:
        """The largest over the outputs."""
        return max(self.errors.values())


@dataclass(frozen=True, slots=True)
class PredictedRow:
    """One row of a ranking: every way to remove it that leaves a model, the one with the least error first."""

    row: Path
    kind: str
    ways: tuple[PredictedError, ...]

    @property
    def best(self) -> PredictedError | None:
        """The way with the least error; None if there is none."""
        return self.ways[0] if self.ways else None


class Prediction:
    """The predicted errors of removals, for some outputs of a run."""

    def __init__(self, trajectory: Trajectory, outputs: Sequence[Path]) -> None:
        self.trajectory = trajectory
        self.outputs = tuple(outputs)
        self.compiled: CompiledModel = trajectory.compiled
        self._evidence = RunEvidence.of(trajectory.compiled, trajectory)
        self._surrogate: Surrogate = fit(trajectory, outputs)
        self._bonds = tuple(self._surrogate.laws)
        self._number = {bond: index for index, bond in enumerate(self._bonds)}
        tableau = self._surrogate.tableau
        bonds = [self.compiled.graph.normal.bonds[name] for name in self._bonds]
        recorded = [
            trajectory[name / variable.value] for variable in (Variable.EFFORT, Variable.FLOW) for name in self._bonds
        ]
        points = self._surrogate.point_of(trajectory.time)
        self._spectra: Spectra = spectra(trajectory.time, recorded, points)
        own = [tableau.column_of(bond, v) for v in (Variable.EFFORT, Variable.FLOW) for bond in bonds]
        looked_at = [tableau.column(path) for path in outputs]
        wanted = [*own, *(column for column in looked_at if column is not None)]
        count = len(self._bonds)
        gains = np.empty((len(self._spectra.s), len(wanted), count), dtype=np.complex128)
        for point in np.unique(self._spectra.point):
            there = self._spectra.point == point
            places, which = np.unique(self._spectra.s[there], return_inverse=True)
            gains[there] = self._surrogate.gains(int(point), places, self._bonds, wanted)[which]
        answers = np.zeros((len(gains), len(outputs), count), dtype=np.complex128)
        answers[:, [k for k, column in enumerate(looked_at) if column is not None]] = gains[:, 2 * count :]
        self._ranges = {path: float(np.ptp(trajectory[path])) for path in outputs}
        for path, spread in self._ranges.items():
            if spread == 0.0:
                raise ReductionError.of(
                    "reduction/constant-output",
                    f"the output '{path}' never changes in this run, so a share of its range says nothing",
                    help="choose an output that moves, or a scenario in which it does",
                )
        self.responses = Responses.of_full(
            gains[:, : 2 * count],
            answers,
            self._spectra.amplitudes,
            self._spectra.line,
            np.array([self._ranges[path] for path in outputs]),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Where the model is far from linear along this run, so that predictions may be wrong."""
        found: list[str] = []
        misfits = {path: share for path, share in self._surrogate.misfits.items() if share > MISFIT}
        if misfits:
            worst = sorted(misfits, key=lambda path: -misfits[path])
            names = listed(f"{path} ({misfits[path]:.0%})" for path in worst)
            found.append(f"far from one slope along this run, so judge what acts through them by simulation: {names}")
        controllers = [str(controller.path) for controller in self.compiled.graph.controllers]
        if controllers:
            found.append(f"taken as they were in the run: the decisions of {listed(controllers)}")
        return tuple(found)

    def of(self, removals: Iterable[Replacement]) -> PredictedError | None:
        """What removals together would do; None if they leave no solution.

        Raises:
            ReductionError: a removal names no port of an energy element.
        """
        chosen = tuple(removals)
        if not chosen:
            return PredictedError((), dict.fromkeys(self.outputs, 0.0))
        errors = self.responses.errors_without([self.move(removal) for removal in chosen])
        if errors is None:
            return None
        return PredictedError(chosen, dict(zip(self.outputs, map(float, errors), strict=True)))

    def move(self, removal: Replacement) -> Move:
        """A removal in terms of `responses`.

        Raises:
            ReductionError: it names no port of an energy element.
        """
        if removal.bond not in self._number:
            raise ReductionError.of(
                "reduction/unknown-removal",
                f"a removal names '{removal.bond}', which is no port of an energy element",
                help=one_of(str(removal.bond), map(str, self._number)),
            )
        law = self._number[removal.bond]
        is_effort = isinstance(removal, ZeroEffort | ConstantEffort)
        value = removal.value if isinstance(removal, ConstantEffort | ConstantFlow) else 0.0
        return Move(law, law if is_effort else len(self._bonds) + law, value)

    def rows(self) -> tuple[PredictedRow, ...]:
        """Every row with all ways to remove it, the row that changes outputs least first."""
        found = [self._row(row.path, row.kind, row.bonds) for row in self.compiled.system.rows]
        return tuple(sorted(found, key=lambda row: (row.best is None, row.best.worst if row.best else 0.0, row.row)))

    def ways(self, bonds: Sequence[Path]) -> list[tuple[Replacement, ...]]:
        """Every way to remove an element with these bonds."""
        return list(itertools.product(*(self._replacements(bond) for bond in bonds)))

    def _row(self, path: Path, kind: str, bonds: Sequence[Path]) -> PredictedRow:
        ways = map(self.of, self.ways(bonds))
        return PredictedRow(path, kind, tuple(sorted(filter(None, ways), key=lambda way: way.worst)))

    def _replacements(self, name: Path) -> list[Replacement]:
        """What may take the place of an element at one bond: nothing, and for storage what it gives at its mean."""
        bond = self.compiled.graph.normal.bonds[name]
        found: list[Replacement] = [ZeroEffort(name), ZeroFlow(name)]
        end = bond.head if bond.head.port else bond.tail
        match self.compiled.graph.normal.elements[end.owner].kind:
            case ElementKind.COMPLIANCE:
                found.append(ConstantEffort(name, self._evidence.mean(bond, Variable.EFFORT)))
            case ElementKind.INERTIA:
                found.append(ConstantFlow(name, self._evidence.mean(bond, Variable.FLOW)))
            case _:
                pass
        return found

    def __str__(self) -> str:
        return self.text()

    def text(self, ranking: ActivityRanking | None = None) -> str:
        """A table of all rows, with their activity indices beside where a ranking is given."""
        indices = {} if ranking is None else {row.path: row.index for row in ranking.rows}
        rows = self.rows()
        width = max((len(str(row.row)) for row in rows), default=7)
        heads = [_shortened(path) for path in self.outputs]
        index_head = f"{'activity':>10}" if indices else ""
        lines = [f"{'':>3}  {'element':<{width}}  {'replaced by':<16}{index_head}  " + "  ".join(heads)]
        for number, row in enumerate(rows, 1):
            index = f"{indices[row.row]:>10.3%}" if row.row in indices else f"{'':>10}" if indices else ""
            if row.best is None:
                lines.append(f"{number:>3}  {row.row!s:<{width}}  {'nothing can':<16}{index}")
                continue
            errors = "  ".join(
                f"{row.best.errors[path]:>{len(head)}.3%}" for path, head in zip(self.outputs, heads, strict=True)
            )
            lines.append(f"{number:>3}  {row.row!s:<{width}}  {row.best.meaning:<16}{index}  {errors}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


def predict_errors(trajectory: Trajectory, outputs: Iterable[Expr | Path | str]) -> Prediction:
    """Predict from one run how much outputs would change if elements were removed.

    Args:
        trajectory: A complete run of the full model with all observables recorded, often enough to show what moves.
        outputs: The observables that matter.

    Returns:
        Predictions of single removals (`rows()`) and of any set of them (`of(...)`), as root mean square over the
        output's range. They hold as far as the model is near the linear one along this run: what controllers do is
        taken as it was, and laws have one slope for the whole run.

    Raises:
        ReductionError: the run is not complete, an output does not exist or never moves, or there is no linear model.
    """
    if not trajectory.ending.is_complete:
        raise ReductionError.of(
            "activity/incomplete",
            f"the run did not reach its end: {trajectory.ending.message}",
            where=str(trajectory.ending.path),
            help="predict from a run that is complete",
        )
    paths = [observable_path(output) for output in outputs]
    known = trajectory.compiled.lowered.observables
    for path in paths:
        if path not in known:
            raise ReductionError.of(
                "reduction/unknown-output",
                f"the output '{path}' does not exist",
                help=one_of(str(path), map(str, known)),
            )
    if not paths:
        raise ReductionError.of(
            "reduction/unknown-output", "no outputs were given", help="name the observables that matter"
        )
    return Prediction(trajectory, paths)


def _shortened(path: Path) -> str:
    text = str(path)
    return f"{text if len(text) <= 24 else '...' + text[-21:]:>9}"
