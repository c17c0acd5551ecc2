"""Energy correlation: elements that take part in what the energies of a run do together (Ersal, Fathy, Stein 2009).

The energies that elements have taken in over time are decomposed into directions that are not correlated (Karhunen and
Loeve): eigenvectors of their covariance. An element counts by its part in the directions that make up the threshold,
weighted with how much happens there, so what only accompanies others in weak directions counts for little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.ranking import models_along
from propermodel.reduction.methods.workbench import Workbench


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Uncorrelated directions of some signals, the strongest first."""

    strengths: FloatArray  # eigenvalues of the covariance
    parts: FloatArray  # (signals, directions), columns of length one

    def importance(self, threshold: float) -> FloatArray:
        """The share of each signal in the directions that together make up a threshold of all strength."""
        total = float(np.sum(self.strengths))
        if total == 0.0:
            return np.zeros(len(self.parts))
        dominant = int(np.searchsorted(np.cumsum(self.strengths) / total, threshold - 1e-12)) + 1
        sizes = np.sqrt(self.parts[:, :dominant] ** 2 @ self.strengths[:dominant])
        return sizes / float(np.sum(sizes))


def directions_of(signals: FloatArray, weights: FloatArray) -> Directions:
    """The directions of signals.

    Args:
        signals: (signals, instants).
        weights: (instants): how much each instant counts; they sum to one.
    """
    centred = signals - (signals @ weights)[:, np.newaxis]
    strengths, parts = np.linalg.eigh((centred * weights) @ centred.T)
    return Directions(np.maximum(strengths[::-1], 0.0), parts[:, ::-1])


def by_energy_correlation(bench: Workbench) -> Curve:
    """Remove elements in the order of their part in correlated energies, by the rule of their junction."""
    time = bench.run.time
    steps = np.diff(time)
    weights = (np.append(steps, 0.0) + np.append(0.0, steps)) / (2.0 * float(np.sum(steps)))
    energies: list[FloatArray] = []
    for row in bench.rows:
        bonds = [bench.evidence.structure.bonds[name] for name in row.bonds]
        power = np.sum([bench.run[b.name / "effort"] * bench.run[b.name / "flow"] for b in bonds], axis=0)
        energies.append(np.append(0.0, np.cumsum(0.5 * (power[1:] + power[:-1]) * steps)))
    importance = directions_of(np.array(energies), weights).importance(bench.threshold)
    order = sorted(range(len(bench.rows)), key=lambda k: (importance[k], bench.rows[k].path))
    models = models_along(bench, [bench.by_position(bench.rows[k]) for k in order])
    kept = int(np.searchsorted(np.cumsum(importance[order[::-1]]), bench.threshold - 1e-12)) + 1
    removals = [removal for k in order[: max(len(order) - kept, 0)] for removal in bench.by_position(bench.rows[k])]
    return Curve(
        method="energy correlation",
        source="after Ersal, Fathy and Stein 2009",
        models=models,
        chosen=bench.measure(removals),
        rule=f"keep {bench.threshold:.4g} of all importance",
        simulations=bench.simulations,
        notes=("importances are computed from recorded rows, so these must be dense",),
    )
