"""Random mechanical rigs: masses on a line joined by springs, dampers and levers; with an independent answer.

The answer comes from the mass matrix, the forces and the constraints of the levers (Lagrange multipliers), which
know nothing of bonds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from propermodel.modelling import Component, connect
from tests.parts import Damper, Fixed, Force, Lever, Mass, Spring

WALL = -1


@dataclass(frozen=True)
class Edge:
    """A spring, damper or lever from node i to node j; `size` is stiffness, damping or ratio."""

    kind: str
    i: int
    j: int
    size: float


@dataclass(frozen=True)
class Rig:
    """Masses by node, edges, and the force on the first node."""

    masses: tuple[float, ...]
    edges: tuple[Edge, ...]
    force: float

    def component(self) -> Component:
        """The rig as a component with one node per mass and a wall."""
        parts: dict[str, Any] = {f"m{i}": Mass(mass=m) for i, m in enumerate(self.masses)}
        parts["push"] = Force(force=self.force)
        ports: dict[int, list[Any]] = {i: [parts[f"m{i}"].flange] for i in range(len(self.masses))}
        ports[0].append(parts["push"].flange)
        if any(WALL in (e.i, e.j) for e in self.edges):
            parts["wall"] = Fixed()
            ports[WALL] = [parts["wall"].flange]
        for number, edge in enumerate(self.edges):
            part: Any = {
                "spring": lambda size: Spring(stiffness=size),
                "damper": lambda size: Damper(damping=size),
                "lever": lambda size: Lever(ratio=size),
            }[edge.kind](edge.size)
            parts[f"e{number}"] = part
            ports[edge.i].append(part.a)
            ports[edge.j].append(part.b)
        connections = tuple(connect(*members) for members in ports.values())
        return type("Rig", (Component,), {**parts, "connections": connections})()

    def with_sizes(self, sizes: Mapping[int, float]) -> Rig:
        """The rig with other sizes of some edges."""
        edges = tuple(replace(e, size=sizes.get(n, e.size)) for n, e in enumerate(self.edges))
        return replace(self, edges=edges)

    def accelerations(self, velocities: Mapping[int, float], stretch: Mapping[int, float]) -> np.ndarray:
        """The acceleration of every node, from Newton's law with the levers as constraints."""
        n = len(self.masses)
        force = np.zeros(n)
        force[0] -= self.force  # power counts into the source
        levers = [e for e in self.edges if e.kind == "lever"]
        for number, edge in enumerate(self.edges):
            if edge.kind == "lever":
                continue
            slip = velocities.get(edge.i, 0.0) - velocities.get(edge.j, 0.0)
            pull = edge.size * (stretch[number] if edge.kind == "spring" else slip)
            for node, sign in ((edge.i, -1.0), (edge.j, 1.0)):
                if node != WALL:
                    force[node] += sign * pull
        rows = np.zeros((len(levers), n))
        for row, edge in enumerate(levers):
            for node, factor in ((edge.i, edge.size), (edge.j, -1.0)):  # v_j = ratio v_i
                if node != WALL:
                    rows[row, node] = factor
        zero = np.zeros((len(levers), len(levers)))
        matrix = np.block([[np.diag(self.masses), rows.T], [rows, zero]])
        return np.linalg.solve(matrix, np.concatenate([force, np.zeros(len(levers))]))[:n]


sizes = st.floats(0.2, 5.0)


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """A rig whose levers make no closed chain."""
    n = draw(st.integers(1, 5))
    masses = tuple(draw(sizes) for _ in range(n))
    edges: list[Edge] = []
    for j in range(1, n):
        if draw(st.booleans()):
            i = draw(st.integers(0, j - 1))
            ends = (i, j) if draw(st.booleans()) else (j, i)
            edges.append(Edge("lever", *ends, draw(sizes)))
    for _ in range(draw(st.integers(0, 8))):
        i, j = draw(st.integers(WALL, n - 1)), draw(st.integers(WALL, n - 1))
        if i != j:
            edges.append(Edge(draw(st.sampled_from(["spring", "damper"])), i, j, draw(sizes)))
    return Rig(masses, tuple(draw(st.permutations(edges))), draw(st.floats(-5.0, 5.0)))
