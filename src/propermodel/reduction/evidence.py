"""What runs say about every bond: activities, means, and shares at junctions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propermodel.analysis.activity import bond_activities
from propermodel.bondgraph.graph import Bond, Structure
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.modelling.model import Variable
from propermodel.simulation.trajectory import Trajectory

NOTHING = 1e-12  # of the most active bond of a run: less is rounding


@dataclass(frozen=True)
class OneRun:
    """A run seen from its bonds."""

    trajectory: Trajectory
    structure: Structure
    at: Mapping[Path, list[Bond]]
    activities: Mapping[Path, float]

    def share(self, bond: Bond, junction: Path) -> float:
        """The activity of a bond against the greatest at a junction."""
        return self._of_greatest(self.activities[bond.name], junction)

    def strength(self, bond: Bond, junction: Path) -> float:
        """The share of a bond at a junction, where a field counts with its most active port."""
        return self._of_greatest(self._weight(bond, junction), junction)

    def _of_greatest(self, activity: float, junction: Path) -> float:
        greatest = max(self._weight(peer, junction) for peer in self.at[junction])
        return activity / greatest if greatest > 0.0 else 0.0

    def _weight(self, bond: Bond, junction: Path) -> float:
        owner = bond.other(junction).owner
        ports = self.at[owner] if is_field(self.structure, owner) else [bond]
        return max(self.activities[b.name] for b in ports)

    def moves(self, junction: Path) -> bool:
        """Whether more than rounding happens at a junction."""
        greatest = max(self.activities.values(), default=0.0)
        return any(self._weight(bond, junction) > NOTHING * greatest for bond in self.at[junction])

    def column(self, bond: Bond, variable: Variable) -> FloatArray:
        """The recorded effort or flow of a bond."""
        return self.trajectory[bond.name / variable.value]

    def constant_share(self, bond: Bond, junction: Path, variable: Variable, value: float) -> float:
        """What a constant in place of a variable leaves unexplained, as a share of the junction's greatest activity.

        From the recorded columns, so meant for variables that change slowly against the recording.
        """
        values, partner = self.column(bond, variable), np.abs(self.column(bond, variable.other))
        rest = float(np.sum(np.abs(values - value) * partner))
        whole = float(np.sum(np.abs(values) * partner))
        return self.share(bond, junction) * rest / whole if whole > 0.0 else 0.0

    def size_share(self, bond: Bond, junction: Path) -> float:
        """The mean size of a bond's summed variable against the greatest at its junction."""
        variable = self.structure.junctions[junction].kind.common.other
        sizes = {b.name: float(np.mean(np.abs(self.column(b, variable)))) for b in self.at[junction]}
        greatest = max(sizes.values())
        return sizes[bond.name] / greatest if greatest > 0.0 else 0.0


def is_field(structure: Structure, path: Path) -> bool:
    """Whether a path is a storage or resistance of several ports."""
    element = structure.elements.get(path)
    return element is not None and element.kind.is_energetic and len(element.ports) > 1


@dataclass(frozen=True)
class RunEvidence:
    """Runs of a model seen from its bonds: what is small is small in each, so shares are those of the worst run."""

    compiled: CompiledModel
    structure: Structure
    at: Mapping[Path, list[Bond]]
    activities: Mapping[Path, float]  # of all runs together, J
    runs: tuple[OneRun, ...]

    @classmethod
    def of(cls, compiled: CompiledModel, *trajectories: Trajectory) -> RunEvidence:
        """The evidence of runs of this model."""
        structure = compiled.graph.normal
        at = structure.at()
        runs = tuple(OneRun(run, structure, at, bond_activities(run)) for run in trajectories)
        activities = {bond: sum(run.activities[bond] for run in runs) for bond in structure.bonds}
        return cls(compiled, structure, at, activities, runs)

    def share(self, bond: Bond, junction: Path) -> float:
        """The activity of a bond against the greatest at a junction (relative activity).

        A field counts at the junction with its most active port: what one port does is small when another does more.
        """
        return max((run.share(bond, junction) for run in self._moving(junction)), default=0.0)

    def _moving(self, junction: Path) -> tuple[OneRun, ...]:
        """The runs that say anything of a junction; a single one always does."""
        return self.runs if len(self.runs) == 1 else tuple(run for run in self.runs if run.moves(junction))

    def is_field(self, path: Path) -> bool:
        """Whether a path is a storage or resistance of several ports."""
        return is_field(self.structure, path)

    def meets_field(self, junction: Path) -> bool:
        """Whether a junction only joins something to one port of a field."""
        bonds = self.at[junction]
        return len(bonds) == 2 and any(self.is_field(b.other(junction).owner) for b in bonds)

    def mean(self, bond: Bond, variable: Variable) -> float:
        """The mean of an effort or flow, weighted with the size of its partner: the constant that does least harm."""
        values = [run.column(bond, variable) for run in self.runs]
        weights = [np.abs(run.column(bond, variable.other)) * _period(run.trajectory) for run in self.runs]
        total = float(sum(np.sum(weight) for weight in weights))
        if total > 0.0:
            return float(sum(np.sum(v * w) for v, w in zip(values, weights, strict=True))) / total
        return float(np.mean(np.concatenate(values)))

    def constant_share(self, bond: Bond, junction: Path, variable: Variable) -> float:
        """What the mean in place of a variable leaves unexplained, as a share of the junction's greatest activity."""
        value = self.mean(bond, variable)
        found = (run.constant_share(bond, junction, variable, value) for run in self._moving(junction))
        return max(found, default=0.0)

    def size_share(self, bond: Bond, junction: Path) -> float:
        """The mean size of a bond's summed variable against the greatest at its junction.

        An effort can be large while the flow, and with it the activity, is small: a preload. It must not be dropped.
        """
        return 0.0 if self.meets_field(junction) else max(run.size_share(bond, junction) for run in self.runs)

    def is_recorded(self, signal: Path) -> bool:
        """Whether every run has recorded a signal."""
        return all(signal in run.trajectory for run in self.runs)

    def mean_signal(self, signal: Path) -> float:
        """The mean of a recorded signal over all runs."""
        columns = [(run.trajectory[signal], _period(run.trajectory)) for run in self.runs]
        return float(sum(np.sum(c) * p for c, p in columns)) / sum(len(c) * p for c, p in columns)

    def swing(self, signal: Path, value: float) -> float:
        """The largest distance of a recorded signal from a value in any run."""
        return max(float(np.max(np.abs(run.trajectory[signal] - value))) for run in self.runs)


def _period(run: Trajectory) -> float:
    """The time that a recorded row stands for, s."""
    return (run.ending.time - run.scenario.start) / len(run.time)
