"""Strokes for graphs where laws alone do not give a causality: elements then answer with what their law takes.

A resistance that only offers its effort may have to answer with its flow, and storage without an inverse law may
depend on others; formulation solves such a law for the variable that is due, if it has one for every value. What the
junction structure asks for stays: one bond sets the common variable of each junction, and two-ports pass causality
on. Where no strokes satisfy that, the equations of the graph are structurally singular.
"""

from __future__ import annotations

from propermodel.bondgraph.graph import Bond, BondGraph, Element
from propermodel.causality.assign import Assignment, Pattern
from propermodel.causality.causal import CausalGraph, Stroke, Why
from propermodel.causality.conflicts import Conflict
from propermodel.causality.invertible import Inversion
from propermodel.causality.vanishing import vanishing_two_ports
from propermodel.diagnostics import Path
from propermodel.modelling.model import PowerSource, Resistive, Storage

# Contradictions met in one search before it is given up.
MOST_CONTRADICTIONS = 2000


def assign_beyond_laws(graph: BondGraph) -> CausalGraph | None:
    """Strokes with as much integral causality as there can be, then laws as offered; None where there are none."""
    work = Completion(graph)
    elements = graph.normal.elements.values()
    for element in elements:
        if isinstance(element.behaviour, PowerSource) and not work.attempt(
            element, work.source_pattern(element), work.why_source(element)
        ):
            return None
    for element in elements:
        if (
            isinstance(element.behaviour, Storage)
            and not work.inversion.is_possible(element)
            and not work.attempt(element, work.storage_pattern(element, integral=True), Why.INTEGRAL)
        ):
            return None
    if not work.can_be_completed():
        return None
    for element in elements:
        if isinstance(element.behaviour, Storage):
            work.prefer_integral(element)
    for element in vanishing_two_ports(graph):
        work.keeps_completion(element, work.multiplying_pattern(element), Why.MODULUS)
    for element in elements:
        if isinstance(element.behaviour, Resistive):
            work.prefer_laws(element)
    work.complete_as_found()
    integral, derivative = work.causalities()
    return CausalGraph(graph, work.strokes, tuple(integral), tuple(derivative))


class Completion(Assignment):
    """Strokes that may leave the laws of resistances and storage, with a complete assignment as a witness."""

    def __init__(self, graph: BondGraph) -> None:
        super().__init__(graph)
        self.inversion = Inversion(graph)
        self.witness: dict[Path, Path] = {}  # bond: the end that receives its effort

    def implied_at_resistance(self, element: Element, bonds: list[Bond]) -> list[tuple[Bond, Path, Why]]:
        """No strokes, where the law can be solved for any of its variables."""
        return [] if self.inversion.is_possible(element) else super().implied_at_resistance(element, bonds)

    def prefer_integral(self, element: Element) -> None:
        """Integral causality on all ports if possible, or on as many as possible one by one."""
        assert isinstance(element.behaviour, Storage)
        pattern = self.storage_pattern(element, integral=True)
        if self.keeps_completion(element, pattern, Why.INTEGRAL):
            return
        for name, receives in pattern.items():
            if len(pattern) == 1 or not self.keeps_completion(element, {name: receives}, Why.INTEGRAL):
                assert self.keeps_completion(element, {name: not receives}, Why.DERIVATIVE)

    def prefer_laws(self, element: Element) -> None:
        """The first law that fits the strokes, if one does."""
        any(self.keeps_completion(element, pattern, Why.CHOICE) for pattern in self.law_patterns(element))

    def keeps_completion(self, element: Element, pattern: Pattern, why: Why) -> bool:
        """Assign strokes of an element if all others can still be assigned; otherwise leave everything as it was."""
        mark = len(self.trail)
        try:
            for bond in self.at[element.path]:
                if bond.name in pattern:
                    receiver = element.path if pattern[bond.name] else bond.other(element.path).owner
                    self.set(bond, receiver, why, element.path)
                    self.propagate([bond.tail.owner, bond.head.owner], element.path)
        except Conflict:
            self.undo(mark)
            return False
        agrees = all(self.strokes[name].effort_into == self.witness[name] for name in self.trail[mark:])
        if agrees or self.can_be_completed():
            return True
        self.undo(mark)
        return False

    def can_be_completed(self) -> bool:
        """Whether the remaining bonds can be given strokes; the strokes found become the witness."""
        mark = len(self.trail)
        found = self._search()
        if found:
            self.witness = {name: stroke.effort_into for name, stroke in self.strokes.items()}
        self.undo(mark)
        return found

    def complete_as_found(self) -> None:
        """Give the remaining bonds the strokes of the witness."""
        for name, bond in self.structure.bonds.items():
            receiver = self.witness[name]
            self.strokes.setdefault(name, Stroke(receiver, Why.CHOICE, bond.other(receiver).owner))

    def _search(self) -> bool:
        """Depth first over the bonds, as the witness has them first; contradictions turn back to the last choice."""
        bonds = list(self.structure.bonds.values())
        choices: list[tuple[int, int, list[Path]]] = []  # trail, bond, ends still to try
        contradictions = position = 0
        while True:
            while position < len(bonds) and bonds[position].name in self.strokes:
                position += 1
            if position == len(bonds):
                return True
            ends = [bonds[position].tail.owner, bonds[position].head.owner]
            if self.witness.get(bonds[position].name) == ends[0]:
                ends.reverse()
            choices.append((len(self.trail), position, ends))
            while choices:
                mark, position, ends = choices[-1]
                self.undo(mark)
                if not ends:
                    choices.pop()
                    continue
                bond, receiver = bonds[position], ends.pop()
                try:
                    self.set(bond, receiver, Why.CHOICE, receiver)
                    self.propagate([bond.tail.owner, bond.head.owner], receiver)
                    break
                except Conflict:
                    contradictions += 1
                    if contradictions > MOST_CONTRADICTIONS:
                        return False
            else:
                return False

    def causalities(self) -> tuple[list[Path], list[Path]]:
        """Storage with a state, and storage that depends on others; a field may be both."""
        integral: list[Path] = []
        derivative: list[Path] = []
        for element in self.structure.elements.values():
            if not isinstance(element.behaviour, Storage):
                continue
            pattern = self.storage_pattern(element, integral=True)
            fits = [(self.strokes[name].effort_into == element.path) is receives for name, receives in pattern.items()]
            if any(fits) or not fits:
                integral.append(element.path)
            if not all(fits):
                derivative.append(element.path)
        return integral, derivative
