"""The published method as a person would follow it: a threshold, and the position rule, with nothing checked."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from propermodel.analysis.activity import rank_activity
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import ProperModelError
from propermodel.modelling.model import JunctionKind, Removal, ZeroEffort, ZeroFlow
from propermodel.simulation.trajectory import Trajectory
from tests.physics.systems import compiled, run


def plain_mora(trajectory: Trajectory, threshold: float = 0.99) -> tuple[Removal, ...]:
    """What plain MORA removes: the term of each row below the threshold goes from the sum of its junction."""
    ranking = rank_activity(trajectory)
    keep = {row.path for row in ranking.kept_by(threshold)}
    structure = trajectory.compiled.graph.normal
    removals: list[Removal] = []
    for row in ranking.rows:
        if row.path in keep:
            continue
        for name, _ in row.ports:
            bond = structure.bonds[name]
            end = bond.tail if bond.head.port else bond.head
            kind = structure.junctions[end.owner].kind
            removals.append(ZeroEffort(name) if kind is JunctionKind.ONE else ZeroFlow(name))
    return tuple(removals)


def rows_of(removals: Iterable[Removal]) -> set[str]:
    """The elements that bond removals name."""
    return {str(removal.bond.parent) for removal in removals}  # pyright: ignore[reportAttributeAccessIssue]


def error_without(reference: Trajectory, removals: Iterable[Removal], output: str, step: float | None = None) -> float:
    """The rms error of an output over its range without some elements; infinite where nothing is left to run."""
    try:
        model: CompiledModel = compiled(reference.compiled.model.without(removals))
        other = run(
            model,
            reference.scenario.stop,
            step=step or reference.step,
            every=float(reference.time[1] - reference.time[0]),
            initial={str(path): value for path, value in reference.scenario.initial.items()},
            parameters={str(path): value for path, value in reference.scenario.parameters.items()},
        )
    except (ProperModelError, AssertionError):  # no equations, or a run that fails
        return math.inf
    expected = reference[output]
    found = np.interp(reference.time, other.time, other[output])
    return float(np.sqrt(np.mean((found - expected) ** 2)) / np.ptp(expected))
