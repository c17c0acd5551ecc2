"""Sequential causality assignment (Karnopp, Margolis and Rosenberg, System Dynamics, ch. 5)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from propermodel.bondgraph.graph import Bond, BondGraph, Element
from propermodel.causality.causal import CausalGraph, Stroke, Why
from propermodel.causality.closures import closures
from propermodel.causality.conflicts import Conflict, contradiction, explain, no_inverse, undetermined
from propermodel.causality.fields import field_causalities
from propermodel.causality.implicit import Given, implicit_causalities
from propermodel.causality.vanishing import ports_that_receive_effort, vanishing_two_ports
from propermodel.diagnostics import Path, StructureError
from propermodel.expressions.core import SymbolKind, leaves
from propermodel.modelling.model import (
    ElementKind,
    JunctionKind,
    PowerSource,
    Preference,
    Resistive,
    Storage,
    TwoPort,
    Variable,
)


def assign_causality(
    graph: BondGraph, order: Sequence[Path] | None = None, constraints: Sequence[Path] | None = None
) -> CausalGraph:
    """Assign every causal stroke.

    Sources first, then laws with one causality, then storage (integral if possible; what its author would rather have
    dependent comes last), then free resistances: those with a preference first, then those that a signal changes.

    Args:
        graph: The bond graph in normal form.
        order: In which order storage is offered integral causality; by default that of the model.
        constraints: Flow sources whose effort is found from the rate of their flow; by default all that close a
            kinematic loop, or none where that leaves a velocity open.

    Raises:
        StructureError: strokes contradict each other; the elements that forced them are named.
    """
    if constraints is None:
        return _assign_with_closures(graph, order)
    work = Assignment(graph)
    elements = graph.normal.elements.values()
    for element in elements:
        if isinstance(element.behaviour, PowerSource):
            if element.path in constraints:
                work.fix(element, {bond.name: False for bond in work.at[element.path]}, Why.CONSTRAINT)
            else:
                work.fix(element, work.source_pattern(element), work.why_source(element))
    for element in elements:
        if isinstance(element.behaviour, Resistive) and len(patterns := work.law_patterns(element)) == 1:
            work.fix(element, patterns[0], Why.LAW)
    storages = [e for e in elements if isinstance(e.behaviour, Storage)]
    if order is not None:
        place = {path: number for number, path in enumerate(order)}
        storages.sort(key=lambda element: place[element.path])
    storages.sort(key=_turn)
    integral, derivative = work.assign_storage(storages)
    for element in vanishing_two_ports(graph):
        work.attempt(element, work.multiplying_pattern(element), Why.MODULUS)
    resistances = [(e, e.behaviour) for e in elements if isinstance(e.behaviour, Resistive)]
    for element, behaviour in sorted(resistances, key=lambda pair: _turn_of_resistance(pair[1])):
        work.choose(element, behaviour)
    work.complete()
    return CausalGraph(graph, work.strokes, tuple(integral), tuple(derivative), tuple(constraints))


def _assign_with_closures(graph: BondGraph, order: Sequence[Path] | None) -> CausalGraph:
    """Causality with every closure of a kinematic loop as a constraint; with some, one or none where that fails."""
    closing = closures(graph.normal)
    try:
        return assign_causality(graph, order, closing)
    except StructureError:
        for attempt in (*(tuple(c for c in closing if c != left) for left in closing), ()):
            try:
                return assign_causality(graph, order, attempt)
            except StructureError:
                continue
        raise


def _turn(element: Element) -> int:
    """When a storage is offered integral causality: first, in its place or last, as its author prefers."""
    assert isinstance(element.behaviour, Storage)
    match element.behaviour.preference:
        case Preference.INTEGRAL:
            return 0
        case Preference.DERIVATIVE:
            return 2
        case _:
            return 1


def _turn_of_resistance(behaviour: Resistive) -> int:
    """When a resistance may choose: one that a signal changes sooner: its inverse might divide by zero."""
    if behaviour.preference is not None:
        return 0
    is_changed = any(
        leaf.data.kind not in (SymbolKind.PARAMETER, SymbolKind.EFFORT, SymbolKind.FLOW)
        for law in behaviour.laws
        for result in law.results
        for leaf in leaves(result.value)
    )
    return 1 if is_changed else 2


Pattern = dict[Path, bool]  # bond: whether the element receives its effort


class Assignment:
    """Strokes while they are being assigned; a trail allows a trial to be taken back."""

    def __init__(self, graph: BondGraph) -> None:
        self.graph = graph
        self.structure = graph.normal
        self.activated = graph.activated_sources
        self.probes = graph.activated_probes
        self.at = graph.normal.at()
        self.strokes: dict[Path, Stroke] = {}
        self.trail: list[Path] = []
        self.offered: dict[Path, list[Pattern]] = {}

    # -- patterns ----------------------------------------------------------------------------------

    def bond_of(self, element: Element, port: str) -> Bond | None:
        """The bond at a port of an element."""
        for bond in self.at[element.path]:
            end = bond.tail if bond.tail.owner == element.path and bond.tail.port == port else bond.head
            if end.owner == element.path and end.port == port:
                return bond
        return None

    def source_pattern(self, element: Element) -> Pattern:
        """The strokes of a source."""
        return {bond.name: element.kind is ElementKind.FLOW_SOURCE for bond in self.at[element.path]}

    def why_source(self, element: Element) -> Why:
        """Whether a source is one, or the end of an activated bond."""
        return Why.ACTIVATED if element.path in self.activated or element.path in self.probes else Why.SOURCE

    def law_patterns(self, element: Element) -> list[Pattern]:
        """The strokes that each law of a resistance needs; those that its implicit law allows come last."""
        known = self.offered.get(element.path)
        if known is None:
            assert isinstance(element.behaviour, Resistive)
            explicit = (tuple((r.port, r.variable) for r in law.results) for law in element.behaviour.laws)
            known = [self.pattern_of(element, given) for given in (*explicit, *implicit_causalities(element))]
            self.offered[element.path] = known
        return known

    def pattern_of(self, element: Element, given: Given) -> Pattern:
        """The strokes of an element that gives these variables at its ports."""
        pattern: Pattern = {}
        for port, variable in given:
            bond = self.bond_of(element, port)
            if bond is not None:
                pattern[bond.name] = variable is Variable.FLOW
        return pattern

    def storage_pattern(self, element: Element, integral: bool) -> Pattern:
        """The strokes of a storage in integral or derivative causality."""
        receives = (element.kind is ElementKind.INERTIA) is integral
        return {bond.name: receives for bond in self.at[element.path]}

    def multiplying_pattern(self, element: Element) -> Pattern:
        """The strokes of a two-port that multiplies with its modulus."""
        receives = ports_that_receive_effort(element)
        found = ((self.bond_of(element, port), into) for port, into in receives.items())
        return {bond.name: into for bond, into in found if bond is not None}

    # -- assignment --------------------------------------------------------------------------------

    def fix(self, element: Element, pattern: Pattern, why: Why) -> None:
        """Assign strokes that admit no alternative; a contradiction is an error."""
        try:
            self.assign(element, pattern, why)
        except Conflict as conflict:
            raise StructureError([explain(self, contradiction(self, element, conflict))]) from None

    def assign_storage(self, storages: list[Element]) -> tuple[list[Path], list[Path]]:
        """Integral causality where possible, in the order of the model; gives both lists."""
        integral: list[Path] = []
        derivative: list[Path] = []
        for element in storages:
            if self.attempt(element, self.storage_pattern(element, integral=True), Why.INTEGRAL):
                integral.append(element.path)
                continue
            derivative.append(element.path)
            if len(element.ports) > 1 and self.assign_field(element):
                continue
            self.fix(element, self.storage_pattern(element, integral=False), Why.DERIVATIVE)
            assert isinstance(element.behaviour, Storage)
            if element.behaviour.inverse is None:
                raise StructureError([no_inverse(self, element)])
        return integral, derivative

    def assign_field(self, element: Element) -> bool:
        """Derivative causality at as few ports of a field as possible, integral at the others."""
        whole = self.storage_pattern(element, integral=True)
        for ports in field_causalities(element):
            derivative = {name: not into for name, into in whole.items() if name.name in ports}
            integral = {name: into for name, into in whole.items() if name.name not in ports}
            mark = len(self.trail)
            if self.attempt(element, integral, Why.INTEGRAL) and self.attempt(element, derivative, Why.DERIVATIVE):
                return True
            self.undo(mark)
        return False

    def choose(self, element: Element, behaviour: Resistive) -> None:
        """Give a resistance the causality that its author prefers, otherwise the first law that fits."""
        patterns = self.law_patterns(element)
        open_ports = any(bond.name not in self.strokes for bond in self.at[element.path])
        why = Why.CHOICE if open_ports else Why.JUNCTION
        if behaviour.preference is not None and open_ports:
            gives_flow = behaviour.preference is Preference.FLOW
            preferred = (pattern for pattern in patterns if set(pattern.values()) == {gives_flow})
            if any(self.attempt(element, pattern, Why.PREFERENCE) for pattern in preferred):
                return
        if any(self.attempt(element, pattern, why) for pattern in patterns):
            return
        self.fix(element, patterns[0], Why.LAW)

    def complete(self) -> None:
        """Strokes inside the junction structure that nothing decides."""
        for bond in self.structure.bonds.values():
            if bond.name in self.strokes:
                continue
            mark = len(self.trail)
            for end in (bond.head, bond.tail):
                try:
                    self.set(bond, end.owner, Why.CHOICE, end.owner)
                    self.propagate([bond.tail.owner, bond.head.owner], end.owner)
                    break
                except Conflict as conflict:
                    self.undo(mark)
                    last = conflict
            else:
                raise StructureError([undetermined(self, bond, last)])
        for path, junction in self.structure.junctions.items():
            if self.strong_bond(path, junction.kind) is None:
                raise StructureError([undetermined(self, self.at[path][0], Conflict(path, self.at[path]))])

    def strong_bond(self, path: Path, kind: JunctionKind) -> Bond | None:
        """The bond that gives a junction its common variable, or may still do so."""
        wants = kind is JunctionKind.ZERO
        for bond in self.at[path]:
            if bond.name not in self.strokes or (self.strokes[bond.name].effort_into == path) is wants:
                return bond
        return None

    def attempt(self, element: Element, pattern: Pattern, why: Why) -> bool:
        """Assign strokes if nothing contradicts them; otherwise leave everything as it was."""
        mark = len(self.trail)
        try:
            self.assign(element, pattern, why)
        except Conflict:
            self.undo(mark)
            return False
        return True

    def assign(self, element: Element, pattern: Pattern, why: Why) -> None:
        """Assign strokes of an element and what follows from them."""
        touched: list[Path] = [element.path]
        for bond in self.at[element.path]:
            if bond.name not in pattern:
                continue
            receiver = element.path if pattern[bond.name] else bond.other(element.path).owner
            if self.set(bond, receiver, why, element.path):
                touched.append(bond.other(element.path).owner)
        self.propagate(touched, element.path)

    def set(self, bond: Bond, receiver: Path, why: Why, cause: Path) -> bool:
        """Put one stroke; False when it was there already."""
        known = self.strokes.get(bond.name)
        if known is not None:
            if known.effort_into != receiver:
                raise Conflict(receiver, [bond])
            return False
        self.strokes[bond.name] = Stroke(receiver, why, cause)
        self.trail.append(bond.name)
        return True

    def undo(self, mark: int) -> None:
        """Take strokes back to a mark of the trail."""
        while len(self.trail) > mark:
            del self.strokes[self.trail.pop()]

    def propagate(self, places: Iterable[Path], cause: Path) -> None:
        """Follow the consequences of new strokes."""
        pending = list(places)
        while pending:
            place = pending.pop()
            for bond, receiver, why in self.implied(place):
                if self.set(bond, receiver, why, cause):
                    pending.append(bond.other(place).owner)
                    pending.append(place)

    def implied(self, place: Path) -> list[tuple[Bond, Path, Why]]:
        """The strokes that follow at one junction or element from those it has."""
        bonds = self.at[place]
        junction = self.structure.junctions.get(place)
        if junction is not None:
            return self.implied_at_junction(place, junction.kind, bonds)
        element = self.structure.elements[place]
        if isinstance(element.behaviour, TwoPort):
            return self.implied_at_two_port(element, bonds)
        if isinstance(element.behaviour, Resistive):
            return self.implied_at_resistance(element, bonds)
        return []

    def implied_at_junction(self, place: Path, kind: JunctionKind, bonds: list[Bond]) -> list[tuple[Bond, Path, Why]]:
        wants = kind is JunctionKind.ZERO
        strong = [b for b in bonds if b.name in self.strokes and (self.strokes[b.name].effort_into == place) is wants]
        if len(strong) > 1:
            raise Conflict(place, strong)
        free = [b for b in bonds if b.name not in self.strokes]
        if strong:
            return [(b, b.other(place).owner if wants else place, Why.JUNCTION) for b in free]
        if not free:
            raise Conflict(place, bonds)
        if len(free) == 1:
            return [(free[0], place if wants else free[0].other(place).owner, Why.JUNCTION)]
        return []

    def implied_at_two_port(self, element: Element, bonds: list[Bond]) -> list[tuple[Bond, Path, Why]]:
        if len(bonds) != 2:
            raise Conflict(element.path, bonds)
        known = [b for b in bonds if b.name in self.strokes]
        same = element.kind is ElementKind.GYRATOR
        receives = [self.strokes[b.name].effort_into == element.path for b in known]
        if len(known) == 2 and (receives[0] is receives[1]) is not same:
            raise Conflict(element.path, bonds)
        if len(known) != 1:
            return []
        other = bonds[1] if bonds[0] is known[0] else bonds[0]
        into_element = receives[0] is same
        return [(other, element.path if into_element else other.other(element.path).owner, Why.TWO_PORT)]

    def implied_at_resistance(self, element: Element, bonds: list[Bond]) -> list[tuple[Bond, Path, Why]]:
        possible = [
            pattern
            for pattern in self.law_patterns(element)
            if all(
                (self.strokes[b.name].effort_into == element.path) is pattern[b.name]
                for b in bonds
                if b.name in self.strokes
            )
        ]
        if not possible:
            raise Conflict(element.path, bonds)
        if len(possible) > 1 or not any(b.name in self.strokes for b in bonds):
            return []
        return [
            (b, element.path if possible[0][b.name] else b.other(element.path).owner, Why.REMAINING)
            for b in bonds
            if b.name not in self.strokes
        ]
