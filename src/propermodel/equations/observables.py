"""Observables: bonds that simplification took away, quantities of storage that is gone, ports and powers."""

from __future__ import annotations

from propermodel.bondgraph.graph import Bond, BondGraph, Element, Structure, Variables
from propermodel.bondgraph.merging import linear_one_port, share_of
from propermodel.diagnostics import Path
from propermodel.equations.at_places import bond_at, held_when_locked, sign_at, sum_of_others
from propermodel.expressions.core import ZERO, Expr, SymbolKind, divide, leaves, symbol
from propermodel.modelling.model import (
    ElementKind,
    Freeze,
    JunctionKind,
    PowerSource,
    Resistive,
    Storage,
    TwoPort,
    Variable,
)


def define_observables(values: dict[Expr, Expr], graph: BondGraph) -> None:
    """Add the variables of bonds that simplification took away, and those of composite ports, to definitions."""
    _recover(values, graph, graph.variables)
    _observe(values, graph, graph.variables)


def _recover(values: dict[Expr, Expr], graph: BondGraph, variables: Variables) -> None:
    """Define the efforts and flows of original bonds that are not in the normal form, as far as they follow."""
    original = graph.original
    recovery = _Recovery(values, graph, variables)
    _recover_merged(recovery, graph)
    for name, variable in graph.known_zero.items():
        if name not in graph.merged:
            recovery.learn(original.bonds[name], variable, ZERO)
    for name in original.bonds:
        if name in graph.normal.bonds:
            for variable in Variable:
                recovery.known.add((name, variable))
                recovery.touch(name)
    for element in original.elements.values():
        if isinstance(element.behaviour, PowerSource) and element.path not in graph.normal.elements:
            recovery.pending[element.path] = None
    recovery.run(original)
    _recover_storage(values, graph)


def _recover_merged(recovery: _Recovery, graph: BondGraph) -> None:
    """Give every merged element its share of what adds up, and the common variable in its own terms."""
    for name, absorbed in graph.merged.items():
        stands = linear_one_port(graph.normal, absorbed.merged)
        if stands is None:
            continue
        bond, common = graph.original.bonds[name], absorbed.kind.common
        whole = graph.normal.bonds[stands.element.path / stands.element.ports[0]]
        recovery.learn(bond, common, absorbed.factor * recovery.variables.of(whole, common))
        share = share_of(absorbed, stands.coefficient)
        recovery.learn(bond, common.other, share * recovery.variables.of(whole, common.other))


class _Recovery:
    def __init__(self, values: dict[Expr, Expr], graph: BondGraph, variables: Variables) -> None:
        self.values = values
        self.graph = graph
        self.variables = variables
        self.known: set[tuple[Path, Variable]] = set()
        self.pending: dict[Path, None] = {}
        self.removed = {r.bond for r in graph.removals if not isinstance(r, Freeze)}

    def touch(self, name: Path) -> None:
        """Look again at what a bond meets."""
        bond = self.graph.original.bonds[name]
        self.pending[bond.tail.owner] = None
        self.pending[bond.head.owner] = None

    def learn(self, bond: Bond, variable: Variable, value: Expr) -> None:
        """Define a variable that is not known yet."""
        if (bond.name, variable) in self.known:
            return
        self.known.add((bond.name, variable))
        self.values[self.variables.of(bond, variable)] = value
        self.touch(bond.name)

    def run(self, original: Structure) -> None:
        """Follow junctions and two-ports until nothing more follows."""
        at = original.at()
        while self.pending:
            place = next(iter(self.pending))
            del self.pending[place]
            junction = original.junctions.get(place)
            if junction is not None:
                self.at_junction(place, junction.kind, at[place])
            else:
                self.at_element(original.elements[place], at[place])

    def at_junction(self, place: Path, kind: JunctionKind, bonds: list[Bond]) -> None:
        common, summed = kind.common, kind.common.other
        known = next((b for b in bonds if (b.name, common) in self.known), None)
        if known is not None:
            for bond in bonds:
                self.learn(bond, common, self.variables.of(known, common))
        unknown = [b for b in bonds if (b.name, summed) not in self.known]
        if len(unknown) == 1:
            terms = [(self.variables.of(b, summed), sign_at(b, place)) for b in bonds if b is not unknown[0]]
            self.learn(unknown[0], summed, sum_of_others(terms, sign_at(unknown[0], place)))

    def at_element(self, element: Element, bonds: list[Bond]) -> None:
        behaviour = element.behaviour
        if isinstance(behaviour, TwoPort):
            a, b = bond_at(bonds, element, "a"), bond_at(bonds, element, "b")
            if a is None or b is None:
                return
            m = behaviour.modulus
            transforms = behaviour.kind is ElementKind.TRANSFORMER
            for variable in Variable:
                across = variable if transforms else variable.other
                upward = variable is Variable.EFFORT
                from_b = self.variables.of(b, across)
                from_a = self.variables.of(a, variable)
                if (b.name, across) in self.known:
                    self.learn(a, variable, m * from_b if upward else divide(from_b, m))
                if (a.name, variable) in self.known:
                    self.learn(b, across, divide(from_a, m) if upward else m * from_a)
        elif isinstance(behaviour, PowerSource):
            self.at_idle_source(behaviour, bonds)
        elif isinstance(behaviour, Resistive) and len(bonds) == 1 and bonds[0].name not in self.removed:
            self.at_idle_resistance(element, behaviour, bonds[0])
        elif isinstance(behaviour, Storage) and len(bonds) == 1 and bonds[0].name not in self.removed:
            self.at_idle_storage(behaviour, bonds[0])

    def at_idle_source(self, behaviour: PowerSource, bonds: list[Bond]) -> None:
        """A source without anything to act on still has the value that it prescribes."""
        variable = Variable.EFFORT if behaviour.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
        for bond in bonds:
            if bond.name not in self.removed:
                self.learn(bond, variable, behaviour.value)

    def at_idle_resistance(self, element: Element, behaviour: Resistive, bond: Bond) -> None:
        if bond.name in self.graph.normal.bonds:
            return
        for law in behaviour.laws:
            result = law.results[0]
            if (bond.name, result.variable.other) in self.known:
                self.learn(bond, result.variable, held_when_locked(behaviour, result))

    def at_idle_storage(self, behaviour: Storage, bond: Bond) -> None:
        """A mass that is held needs no effort, a compliance without effort takes no flow."""
        held = Variable.FLOW if behaviour.kind is ElementKind.INERTIA else Variable.EFFORT
        if self.graph.known_zero.get(bond.name) is held:
            self.learn(bond, held.other, ZERO)


def _recover_storage(values: dict[Expr, Expr], graph: BondGraph) -> None:
    """Stored quantities of elements that are gone: from their effort or flow where it is known, else their start."""
    for element in graph.original.elements.values():
        behaviour = element.behaviour
        if element.path in graph.normal.elements or not isinstance(behaviour, Storage):
            continue
        is_c = behaviour.kind is ElementKind.COMPLIANCE
        kind = SymbolKind.DISPLACEMENT if is_c else SymbolKind.MOMENTUM
        domains = {b.name: graph.domains[b.domain] for b in graph.original.bonds.values() if b.domain}
        for port, expr in behaviour.stored:
            domain = domains[element.path / port]
            unit = domain.displacement_unit if is_c else domain.momentum_unit
            values[symbol(kind, element.path / port / kind.value, unit)] = expr
        for coordinate in behaviour.coordinates:
            state = symbol(SymbolKind.STATE, element.path / coordinate.name, coordinate.unit)
            output = Variable.EFFORT if is_c else Variable.FLOW
            given = None
            if behaviour.inverse is not None:
                driver = next((leaf for leaf in leaves(behaviour.inverse) if leaf.data.path.name == output.value), None)
                given = behaviour.inverse if driver is not None and driver in values else None
            values[state] = coordinate.start if given is None else given


def _observe(values: dict[Expr, Expr], graph: BondGraph, variables: Variables) -> None:
    """Define the observables of ports: powers, and efforts and flows of composite ports."""
    for bond in graph.original.bonds.values():
        if bond.head.port or bond.tail.port:
            domain = graph.domains.get(bond.domain)
            unit = "W" if domain is None or domain.is_true else ""
            power = variables.of(bond, Variable.EFFORT) * variables.of(bond, Variable.FLOW)
            values[symbol(SymbolKind.POWER, bond.name / "power", unit)] = power
    at = graph.original.at()
    for port, node in graph.node_ports.items():
        junction = graph.original.junctions[node.junction]
        domain = graph.domains[node.domain]
        common, summed = junction.kind.common, junction.kind.common.other
        bonds = at[node.junction]
        if not bonds:
            continue
        inside = set(node.inside)
        total = ZERO
        for bond in bonds:
            if bond.name in inside:
                value = variables.of(bond, summed)
                total = total - value if sign_at(bond, node.junction) else total + value
        by_variable = {common: variables.of(bonds[0], common), summed: total}
        effort = symbol(SymbolKind.EFFORT, port / "effort", domain.effort_unit)
        flow = symbol(SymbolKind.FLOW, port / "flow", domain.flow_unit)
        values[effort] = by_variable[Variable.EFFORT]
        values[flow] = by_variable[Variable.FLOW]
        unit = "W" if domain.is_true else ""
        values[symbol(SymbolKind.POWER, port / "power", unit)] = effort * flow
