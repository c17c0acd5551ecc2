"""Causal paths: which variable follows from which, through junctions and two-ports, element by element."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from propermodel.bondgraph.graph import Bond, Element
from propermodel.causality.causal import CausalGraph
from propermodel.causality.graph_algorithms import strong_components
from propermodel.diagnostics import Path
from propermodel.modelling.model import ElementKind, JunctionKind, PowerSource, Storage, TwoPort, Variable

Signal = tuple[Path, Variable]  # the effort or flow of a bond


@dataclass(frozen=True, slots=True)
class CausalPath:
    """The way of influence from one element to another: the variables it runs through, and what they meet between.

    `places` has one entry more than `signals`: it begins with the element that sets the first variable and ends with
    the one that receives the last.
    """

    signals: tuple[Signal, ...]
    places: tuple[Path, ...]

    @property
    def begin(self) -> Path:
        """The element whose law gives the first variable."""
        return self.places[0]

    @property
    def end(self) -> Path:
        """The element whose law takes the last variable."""
        return self.places[-1]


@dataclass(frozen=True, slots=True)
class DependentPath:
    """Storage whose content follows from others, and the paths along which they decide it."""

    storage: Path
    paths: tuple[CausalPath, ...]


@dataclass(frozen=True, slots=True)
class CausalLoop:
    """A closed causal path without a state on it: an algebraic loop.

    `elements` are those whose laws make up the loop gain: resistances, dependent storage and two-ports.
    """

    path: CausalPath
    elements: tuple[Path, ...]


class Signals:
    """What sets every effort and flow, and what it follows from."""

    def __init__(self, causal: CausalGraph) -> None:
        self.causal = causal
        self.structure = causal.graph.normal
        self.at = self.structure.at()
        self.activated = causal.graph.activated_sources
        self.probes = causal.graph.activated_probes

    def setter(self, signal: Signal) -> Path:
        """The element or junction that gives a variable."""
        name, variable = signal
        into = self.causal.strokes[name].effort_into
        return into if variable is Variable.FLOW else self.structure.bonds[name].other(into).owner

    def receiver(self, signal: Signal) -> Path:
        """The element or junction that takes a variable."""
        return self.structure.bonds[signal[0]].other(self.setter(signal)).owner

    def given_by(self, place: Path) -> list[Signal]:
        """The variables that an element gives."""
        return [self._output(bond, place) for bond in self.at[place]]

    def taken_by(self, place: Path) -> list[Signal]:
        """The variables that an element takes."""
        return [(name, variable.other) for name, variable in self.given_by(place)]

    def deciding(self, place: Path) -> list[Signal]:
        """The variables that decide a dependent storage: those that it takes and its law would give."""
        element = self.structure.elements[place]
        return [taken for taken in self.taken_by(place) if self.is_integral(element, taken)]

    def _output(self, bond: Bond, place: Path) -> Signal:
        receives = self.causal.strokes[bond.name].effort_into == place
        return bond.name, Variable.FLOW if receives else Variable.EFFORT

    def is_integral(self, element: Element, signal: Signal) -> bool:
        """Whether a storage gives this variable from what it has stored."""
        own = Variable.EFFORT if element.kind is ElementKind.COMPLIANCE else Variable.FLOW
        return signal[1] is own

    def is_memoryless(self, signal: Signal) -> bool:
        """Whether an element gives this variable at once from those it takes: a resistance or dependent storage."""
        element = self.structure.elements.get(self.setter(signal))
        if element is None or isinstance(element.behaviour, PowerSource | TwoPort):
            return False
        if isinstance(element.behaviour, Storage) and self.is_integral(element, signal):
            # A field that is a state at some ports only answers there at once to what the others take.
            return element.path in self.causal.derivative
        return True

    def follows_from(self, signal: Signal) -> list[Signal]:
        """What junctions, two-ports and activated bonds make a variable from; nothing where an element sets it."""
        place = self.setter(signal)
        junction = self.structure.junctions.get(place)
        if junction is not None:
            return self._at_junction(place, junction.kind, signal)
        element = self.structure.elements[place]
        if isinstance(element.behaviour, TwoPort):
            (other,) = (bond for bond in self.at[place] if bond.name != signal[0])
            gyrates = element.kind is ElementKind.GYRATOR
            return [(other.name, signal[1].other if gyrates else signal[1])]
        activated = self.activated.get(place)
        return [] if activated is None else [(activated.felt, activated.carries)]

    def follows_at_once(self, signal: Signal) -> list[Signal]:
        """The same, also through the laws of resistances and dependent storage."""
        if self.is_memoryless(signal):
            place = self.setter(signal)
            element = self.structure.elements[place]
            is_kept = isinstance(element.behaviour, Storage) and self.is_integral(element, signal)
            return self.deciding(place) if is_kept else self.taken_by(place)
        return self.follows_from(signal)

    def _at_junction(self, place: Path, kind: JunctionKind, signal: Signal) -> list[Signal]:
        name, variable = signal
        if variable is not kind.common:
            return [(bond.name, variable) for bond in self.at[place] if bond.name != name]
        strong = next(bond for bond in self.at[place] if self.setter((bond.name, kind.common)) != place)
        return [(strong.name, variable)]

    # -- paths ---------------------------------------------------------------------------------------------

    def influences(self, taken: Signal) -> Iterator[CausalPath]:
        """The shortest path from every element whose law reaches this variable through the junction structure."""
        towards: dict[Signal, Signal | None] = {taken: None}
        pending = deque([taken])
        while pending:
            signal = pending.popleft()
            before = self.follows_from(signal)
            if not before:
                yield self.path(signal, towards)
            for earlier in before:
                if earlier not in towards:
                    towards[earlier] = signal
                    pending.append(earlier)

    def path(self, first: Signal, towards: dict[Signal, Signal | None]) -> CausalPath:
        """The path that begins with a variable."""
        signals = [first]
        while (following := towards[signals[-1]]) is not None:
            signals.append(following)
        return CausalPath(tuple(signals), (*(self.setter(s) for s in signals), self.receiver(signals[-1])))

    def dependent_storage(self) -> list[DependentPath]:
        """Every storage in derivative causality with what decides it."""
        return [
            DependentPath(path, tuple(found for taken in self.deciding(path) for found in self.influences(taken)))
            for path in self.causal.derivative
        ]

    def zero_order_paths(self) -> list[CausalPath]:
        """Paths without a state between elements that answer at once, or from a source to one of them."""
        found: list[CausalPath] = []
        for element in self.structure.elements.values():
            answers = [signal for signal in self.given_by(element.path) if self.is_memoryless(signal)]
            for name, variable in answers:
                for path in self.influences((name, variable.other)):
                    begin = self.structure.elements[path.begin]
                    is_source = isinstance(begin.behaviour, PowerSource) and begin.path not in self.probes
                    if path.begin != element.path and (is_source or self.is_memoryless(path.signals[0])):
                        found.append(path)
        return found

    def loops(self) -> list[CausalLoop]:
        """The shortest causal loop through every element that stands in one; each loop once."""
        signals = [(name, variable) for name in self.structure.bonds for variable in Variable]
        number = {signal: index for index, signal in enumerate(signals)}
        edges = ((index, number[before]) for index, s in enumerate(signals) for before in self.follows_at_once(s))
        components = [c for c in strong_components(len(signals), edges) if len(c) > 1]
        together = {signals[k]: {signals[j] for j in component} for component in components for k in component}
        found: dict[frozenset[Signal], CausalLoop] = {}
        starts = [signal for signal in signals if signal in together]
        preferred = [s for s in starts if self.is_memoryless(s) or self.setter(s) in self.activated]
        for signal in preferred or starts[:1]:
            loop = self._loop(signal, together[signal])
            found.setdefault(frozenset(loop.path.signals), loop)
        return list(found.values())

    def _loop(self, signal: Signal, members: set[Signal]) -> CausalLoop:
        towards: dict[Signal, Signal | None] = {}
        pending = deque([signal])
        while signal not in towards:
            here = pending.popleft()
            for earlier in self.follows_at_once(here):
                if earlier in members and earlier not in towards:
                    towards[earlier] = here
                    pending.append(earlier)
        signals = [signal]
        while (following := towards[signals[-1]]) is not None and following != signal:
            signals.append(following)
        places = (*(self.setter(s) for s in signals), self.setter(signal))
        elements = tuple(dict.fromkeys(place for place in places if place in self.structure.elements))
        return CausalLoop(CausalPath(tuple(signals), places), elements)
