"""What one run says about every bond: activities, means, and shares at junctions."""

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


@dataclass(frozen=True)
class RunEvidence:
    """A run seen from its bonds."""

    compiled: CompiledModel
    trajectory: Trajectory
    structure: Structure
    at: Mapping[Path, list[Bond]]
    activities: Mapping[Path, float]

    @classmethod
    def of(cls, compiled: CompiledModel, trajectory: Trajectory) -> RunEvidence:
        """The evidence of a run of this model."""
        structure = compiled.graph.normal
        return cls(compiled, trajectory, structure, structure.at(), bond_activities(trajectory))

    def share(self, bond: Bond, junction: Path) -> float:
        """The activity of a bond against the greatest at a junction (relative activity).

        A field counts at the junction with its most active port: what one port does is small when another does more.
        """
        greatest = max(self._weight(peer, junction) for peer in self.at[junction])
        return self.activities[bond.name] / greatest if greatest > 0.0 else 0.0

    def strength(self, bond: Bond, junction: Path) -> float:
        """The share of a bond at a junction, where a field counts with its most active port."""
        greatest = max(self._weight(peer, junction) for peer in self.at[junction])
        return self._weight(bond, junction) / greatest if greatest > 0.0 else 0.0

    def _weight(self, bond: Bond, junction: Path) -> float:
        owner = bond.other(junction).owner
        ports = self.at[owner] if self.is_field(owner) else [bond]
        return max(self.activities[b.name] for b in ports)

    def is_field(self, path: Path) -> bool:
        """Whether a path is a storage or resistance of several ports."""
        element = self.structure.elements.get(path)
        return element is not None and element.kind.is_energetic and len(element.ports) > 1

    def meets_field(self, junction: Path) -> bool:
        """Whether a junction only joins something to one port of a field."""
        bonds = self.at[junction]
        return len(bonds) == 2 and any(self.is_field(b.other(junction).owner) for b in bonds)

    def column(self, bond: Bond, variable: Variable) -> FloatArray:
        """The recorded effort or flow of a bond."""
        return self.trajectory[bond.name / variable.value]

    def mean(self, bond: Bond, variable: Variable) -> float:
        """The mean of an effort or flow, weighted with the size of its partner: the constant that does least harm."""
        values = self.column(bond, variable)
        weights = np.abs(self.column(bond, variable.other))
        total = float(np.sum(weights))
        return float(np.sum(values * weights) / total) if total > 0.0 else float(np.mean(values))

    def constant_share(self, bond: Bond, junction: Path, variable: Variable) -> float:
        """What a constant in place of a variable leaves unexplained, as a share of the junction's greatest activity.

        From the recorded columns, so meant for variables that change slowly against the recording.
        """
        values, partner = self.column(bond, variable), np.abs(self.column(bond, variable.other))
        rest = float(np.sum(np.abs(values - self.mean(bond, variable)) * partner))
        whole = float(np.sum(np.abs(values) * partner))
        return self.share(bond, junction) * rest / whole if whole > 0.0 else 0.0

    def size_share(self, bond: Bond, junction: Path) -> float:
        """The mean size of a bond's summed variable against the greatest at its junction.

        An effort can be large while the flow, and with it the activity, is small: a preload. It must not be dropped.
        """
        if self.meets_field(junction):
            return 0.0
        variable = self.structure.junctions[junction].kind.common.other
        sizes = {b.name: float(np.mean(np.abs(self.column(b, variable)))) for b in self.at[junction]}
        greatest = max(sizes.values())
        return sizes[bond.name] / greatest if greatest > 0.0 else 0.0
