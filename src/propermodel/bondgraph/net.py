"""A bond graph while it is being simplified: the one mutable structure of this room."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from propermodel.bondgraph.graph import Absorbed, Bond, Element, End, Junction, Structure
from propermodel.diagnostics import Path
from propermodel.modelling.model import Variable


class Net:
    """Elements, junctions and bonds that can be rewired."""

    def __init__(self, structure: Structure) -> None:
        self.elements: dict[Path, Element] = dict(structure.elements)
        self.junctions: dict[Path, Junction] = dict(structure.junctions)
        self.bonds: dict[Path, Bond] = {}
        self.incident: dict[Path, dict[Path, None]] = {p: {} for p in (*self.elements, *self.junctions)}
        self.known_zero: dict[Path, Variable] = {}
        self.merged: dict[Path, Absorbed] = {}  # bonds of elements that another stands for
        self.probes: set[Path] = set()  # sources of nothing that keep a junction whose variable is read
        for bond in structure.bonds.values():
            self.add(bond)

    def freeze(self) -> Structure:
        """The structure as it stands."""
        return Structure(dict(self.elements), dict(self.junctions), dict(self.bonds))

    def add(self, bond: Bond) -> None:
        """Add a bond."""
        self.bonds[bond.name] = bond
        self.incident[bond.tail.owner][bond.name] = None
        self.incident[bond.head.owner][bond.name] = None

    def drop(self, name: Path) -> Bond:
        """Take a bond away."""
        bond = self.bonds.pop(name)
        self.incident[bond.tail.owner].pop(name, None)
        self.incident[bond.head.owner].pop(name, None)
        return bond

    def add_junction(self, junction: Junction) -> None:
        """Add a junction without bonds."""
        self.junctions[junction.path] = junction
        self.incident[junction.path] = {}

    def drop_node(self, path: Path) -> None:
        """Take an element or junction away, with the bonds it still has."""
        for name in list(self.incident[path]):
            self.drop(name)
        del self.incident[path]
        self.elements.pop(path, None)
        self.junctions.pop(path, None)

    def bonds_at(self, path: Path) -> list[Bond]:
        """The bonds at an element or junction."""
        return [self.bonds[name] for name in self.incident[path]]

    def is_junction(self, end: End) -> bool:
        """Whether a bond ends on a junction."""
        return not end.port

    def move(self, name: Path, old: Path, new: Path) -> None:
        """Let a bond that ends on one junction end on another."""
        bond = self.drop(name)
        self.add(replace(bond, tail=End(new)) if bond.tail.owner == old else replace(bond, head=End(new)))

    def fresh(self, base: Path, mark: str) -> Path:
        """A path for a junction that simplification introduces."""
        number = 1
        while (path := base.parent / f"{base.name}{mark}{number}") in self.incident:
            number += 1
        return path

    def names(self) -> Iterable[Path]:
        """Every bond, as a copy that survives changes."""
        return list(self.bonds)
