"""The causal graph: which end of every bond receives the effort, and who decided it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from propermodel.bondgraph.graph import Bond, BondGraph, Element
from propermodel.diagnostics import Path


class Why(StrEnum):
    """What decides a causal stroke."""

    SOURCE = "a source prescribes it"
    ACTIVATED = "an activated bond carries only this variable"
    CONSTRAINT = "closes a kinematic loop: its effort keeps its flow"
    LAW = "only this causality has a law"
    PREFERENCE = "its author prefers this causality"
    INTEGRAL = "integral causality preferred"
    DERIVATIVE = "integral causality is impossible"
    MODULUS = "its modulus may be zero, so it multiplies instead of dividing"
    CHOICE = "chosen: both causalities are possible"
    REMAINING = "only one law fits the other strokes of its element"
    JUNCTION = "follows at a junction"
    TWO_PORT = "follows through a two-port"


@dataclass(frozen=True, slots=True)
class Stroke:
    """The causal stroke of a bond: `effort_into` is the element or junction that receives the effort.

    `cause` is the element whose assignment led to it.
    """

    effort_into: Path
    why: Why
    cause: Path


@dataclass(frozen=True)
class CausalGraph:
    """A bond graph with a causal stroke on every bond."""

    graph: BondGraph
    strokes: Mapping[Path, Stroke]
    integral: tuple[Path, ...]  # storage that is a state
    derivative: tuple[Path, ...]  # dependent storage
    constraints: tuple[Path, ...] = ()  # flow sources whose effort is found from the rate of their flow

    def receives_effort(self, bond: Bond, element: Element) -> bool:
        """Whether the element receives the effort of this bond (and answers with the flow)."""
        return self.strokes[bond.name].effort_into == element.path

    def __str__(self) -> str:
        lines = [f"causality of {self.graph.model.name}"]
        width = max((len(str(name)) for name in self.strokes), default=0)
        for name, stroke in self.strokes.items():
            lines.append(f"  {name!s:<{width}}  effort into {stroke.effort_into}: {stroke.why} ({stroke.cause})")
        if self.derivative:
            lines.append("dependent storage: " + ", ".join(str(path) for path in self.derivative))
        return "\n".join(lines)
