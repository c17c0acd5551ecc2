"""Random passive trees over electricity, rotation and translation, written down in many equivalent ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hypothesis import strategies as st

from propermodel.library.mechanics.rotation import (
    RollingWheel,
    RotatingInertia,
    RotationalDamper,
    TorsionSpring,
    ViscousFriction,
)
from propermodel.library.mechanics.translation import Damper, Mass, Spring
from propermodel.modelling import Component, connect
from tests.parts import Capacitor, Coil, Gear, Ground, Lever, Motor, Resistor
from tests.physics.systems import Drag, SinePush, UnitLever, VoiceCoil, system

# Between two nodes of one domain; a part here is (class, parameter, may be turned round).
BETWEEN: Mapping[str, dict[str, Callable[[float], Component]]] = {
    "T": {
        "spring": lambda size: Spring(stiffness=size),
        "damper": lambda size: Damper(damping=size),
    },
    "R": {
        "spring": lambda size: TorsionSpring(stiffness=size),
        "damper": lambda size: RotationalDamper(damping=size),
    },
    "E": {"coil": lambda size: Coil(inductance=size), "resistor": lambda size: Resistor(resistance=size)},
}
TWO_PORT = {"T": lambda size: Lever(ratio=size), "R": lambda size: Gear(ratio=size)}


@dataclass(frozen=True)
class Link:
    """What joins a node to its parent: parallel parts, or one two-port."""

    parts: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class TreeNode:
    domain: str
    parent: int
    link: Link
    own: tuple[float, float]  # inertia or capacity; friction or leak, zero when absent


@dataclass(frozen=True)
class Tree:
    nodes: tuple[TreeNode, ...]
    amplitude: float
    frequency: float


@dataclass(frozen=True)
class Writing:
    """One of the ways to write a tree down."""

    turned: frozenset[int] = field(default_factory=frozenset)  # links whose terminals are swapped
    reverse: bool = False  # order of parts and connections
    prefix: str = ""  # of every name
    inserted: frozenset[int] = field(default_factory=frozenset)  # nodes of translation behind a unit lever

    def name(self, name: str) -> str:
        return self.prefix + name


@st.composite
def trees(draw: st.DrawFn) -> Tree:
    """Root in translation with a pushed mass; children by passive links, motors and gears."""
    sizes = st.floats(0.3, 3.0)
    nodes: list[TreeNode] = []
    for number in range(draw(st.integers(1, 6))):
        parent = -1 if number == 0 else draw(st.integers(0, number - 1))
        domain = "T" if number == 0 else draw(st.sampled_from("TTRE" if nodes[parent].domain != "E" else "EER"))
        # A node may have nothing of its own: then its variable is algebraic, or storage around it is dependent.
        store = draw(sizes) if number == 0 or draw(st.integers(0, 3)) else 0.0
        own = (store, draw(st.sampled_from([0.0, draw(sizes)])))
        here = nodes[parent].domain if number else "T"
        if number == 0:
            parts: tuple[tuple[str, float], ...] = ()
        elif here == domain:
            kinds = [*BETWEEN[domain], *(["two-port"] if domain in TWO_PORT else [])]
            kind = draw(st.sampled_from(kinds))
            count = 1 if kind == "two-port" else draw(st.integers(1, 3))
            parts = tuple(
                (kind if n == 0 else draw(st.sampled_from(list(BETWEEN[domain]))), draw(sizes)) for n in range(count)
            )
        else:
            parts = (("convert", draw(sizes)),)
        nodes.append(TreeNode(domain, parent, Link(parts), own))
    return Tree(tuple(nodes), draw(st.floats(0.5, 2.0)), draw(st.floats(0.1, 1.0)))


def _convert(here: str, domain: str, size: float) -> tuple[Component, str, str]:
    """The part between two domains, with its port at the parent and at the child."""
    if {here, domain} == {"T", "R"}:
        part: Any = RollingWheel(radius=size)
        return part, *(("a", "b") if here == "R" else ("b", "a"))
    if {here, domain} == {"E", "R"}:
        return Motor(constant=size), *(("a", "b") if here == "E" else ("b", "a"))
    return VoiceCoil(constant=size), *(("a", "b") if here == "E" else ("b", "a"))


def write(tree: Tree, writing: Writing = Writing()) -> Component:
    """The tree as a component."""
    parts: dict[str, Any] = {"push": SinePush(force=tree.amplitude, frequency=tree.frequency)}
    at: dict[int, list[Any]] = {number: [] for number in range(len(tree.nodes))}
    at[0].append(parts["push"].flange)
    extra: list[Any] = []
    grounded: list[Any] = []
    for number, node in enumerate(tree.nodes):
        _own(parts, at, grounded, number, node)
        mass = parts.get(f"mass{number}")
        if mass is not None and number in writing.inserted:
            lever = parts[f"unit{number}"] = UnitLever()
            at[number].append(lever.a)
            extra.append(connect(lever.b, mass.flange))
        elif mass is not None:
            at[number].append(mass.flange)
        here = tree.nodes[node.parent].domain if number else "T"
        for index, (kind, size) in enumerate(node.link.parts):
            name = f"link{number}_{index}"
            if kind == "convert":
                part, out, into = _convert(here, node.domain, size)
            elif kind == "two-port":
                part, out, into = TWO_PORT[node.domain](size), "a", "b"
            else:
                part, out, into = BETWEEN[node.domain][kind](size), "a", "b"
                if number in writing.turned:
                    out, into = into, out
            parts[name] = part
            at[node.parent].append(getattr(part, out))
            at[number].append(getattr(part, into))
    if grounded:
        parts["ground"] = Ground()
        extra.append(connect(parts["ground"].pin, *grounded))
    joints = [*(connect(*ports) for ports in at.values()), *extra]
    names = list(parts)
    if writing.reverse:
        names, joints = names[::-1], joints[::-1]
    return system(*joints, **{writing.name(name): parts[name] for name in names})


def _own(parts: dict[str, Any], at: dict[int, list[Any]], grounded: list[Any], number: int, node: TreeNode) -> None:
    """What a node stores and loses."""
    store, loss = node.own
    match node.domain:
        case "T":
            if store:
                parts[f"mass{number}"] = Mass(mass=store)
            if loss:
                drag = parts[f"loss{number}"] = Drag(damping=loss)
                at[number].append(drag.flange)
        case "R":
            if store:
                wheel = parts[f"wheel{number}"] = RotatingInertia(inertia=store)
                at[number].append(wheel.shaft)
            if loss:
                bearing = parts[f"loss{number}"] = ViscousFriction(damping=loss)
                at[number].append(bearing.shaft)
        case _:
            if store:
                capacitor = parts[f"capacitor{number}"] = Capacitor(capacitance=store)
                at[number].append(capacitor.a)
                grounded.append(capacitor.b)
            if loss:
                leak = parts[f"loss{number}"] = Resistor(resistance=loss)
                at[number].append(leak.a)
                grounded.append(leak.b)
