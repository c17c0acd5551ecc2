"""The flat bond graph: elements, junctions and bonds, with the signals that modulate and observe them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from propermodel.diagnostics import NO_SOURCE, Path, Source
from propermodel.expressions.core import Expr, SymbolKind, symbol
from propermodel.modelling.model import (
    Coordinate,
    DomainData,
    ElementKind,
    JunctionKind,
    Model,
    PowerSource,
    Removal,
    Resistive,
    Storage,
    TableSpec,
    TableValues,
    TwoPort,
    Variable,
)

ElementBehaviour = Resistive | Storage | PowerSource | TwoPort


@dataclass(frozen=True, slots=True)
class End:
    """One end of a bond: a junction (`port` is empty) or a port of an element."""

    owner: Path
    port: str = ""

    @property
    def path(self) -> Path:
        """The path of the port or junction."""
        return self.owner / self.port if self.port else self.owner


@dataclass(frozen=True, slots=True)
class Bond:
    """A power connection, named after the element port it ends on; the half arrow points from `tail` to `head`."""

    name: Path
    tail: End
    head: End
    domain: str

    def other(self, owner: Path) -> End:
        """The end that is not at `owner`."""
        return self.head if self.tail.owner == owner else self.tail


@dataclass(frozen=True, slots=True, kw_only=True)
class ActivatedBond:
    """A bond that carries one variable: it is felt at the bond of a source of nothing, and given by another source."""

    path: Path
    felt: Path  # the bond without power at its tail
    given: Path  # the bond of the source at its head
    carries: Variable
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """An energetic primitive; the expressions of its laws are in absolute symbols."""

    path: Path
    kind: ElementKind
    ports: tuple[str, ...]
    behaviour: ElementBehaviour
    row: Path
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Junction:
    """A 0- or 1-junction."""

    path: Path
    kind: JunctionKind
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True)
class Structure:
    """Elements and junctions joined by bonds."""

    elements: Mapping[Path, Element]
    junctions: Mapping[Path, Junction]
    bonds: Mapping[Path, Bond]

    def at(self) -> dict[Path, list[Bond]]:
        """The bonds at every element and junction, in order."""
        found: dict[Path, list[Bond]] = {path: [] for path in (*self.elements, *self.junctions)}
        for bond in self.bonds.values():
            found[bond.tail.owner].append(bond)
            found[bond.head.owner].append(bond)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledController:
    """A controller in absolute symbols: its discrete values, their starts and updates."""

    path: Path
    period: Expr
    starts: tuple[tuple[Expr, Expr], ...]
    updates: tuple[tuple[Expr, Expr], ...]
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlatEvent:
    """An event of an element or signal block in absolute symbols: symbol of a state or held value, value afterwards."""

    element: Path
    condition: Expr
    changes: tuple[tuple[Expr, Expr], ...]
    restitution: Expr | None = None
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalState:
    """A continuous state of a signal block."""

    symbol: Expr
    coordinate: Coordinate
    derivative: Expr
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlatTable:
    """A table with its path; `input_of` names the root input that it drives as a function of time."""

    path: Path
    symbol: Expr
    spec: TableSpec
    values: TableValues
    is_input: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class FlatParameter:
    """A parameter with its absolute path and its value as an expression of other parameters."""

    path: Path
    unit: str
    symbol: Expr
    value: Expr
    low: float = float("-inf")
    high: float = float("inf")
    origin: str = ""
    status: str = ""
    source: Source = NO_SOURCE


@dataclass(frozen=True, slots=True)
class NodePort:
    """A port of a composite: the junction it belongs to and the bonds on the component's side of it."""

    junction: Path
    inside: tuple[Path, ...]
    domain: str


@dataclass(frozen=True, slots=True)
class Absorbed:
    """An element that another one stands for: its own parameter, and the factor of the variable that they share."""

    merged: Path  # the element that stands for it
    kind: JunctionKind
    coefficient: Expr
    factor: Expr


@dataclass(frozen=True, kw_only=True)
class BondGraph:
    """A flattened model in normal form, with the structure it had before simplification.

    `normal` is what gets causality and equations; `original` is the graph as drawn, from which the variables of bonds
    that simplification took away are recovered.
    """

    model: Model
    normal: Structure
    original: Structure
    domains: Mapping[str, DomainData]
    signals: Mapping[Expr, Expr]  # every signal symbol and its definition
    signal_states: tuple[SignalState, ...]
    controllers: tuple[SampledController, ...]
    parameters: Mapping[Path, FlatParameter]
    tables: Mapping[Path, FlatTable]
    node_ports: Mapping[Path, NodePort]
    removals: tuple[Removal, ...]
    known_zero: Mapping[Path, Variable]  # original bonds without effort or without flow
    idle: tuple[Path, ...]  # elements that removals left without anything to act on
    discretes: tuple[tuple[Expr, Expr], ...] = ()  # held values that events change, and their starts
    events: tuple[FlatEvent, ...] = ()
    activated: tuple[ActivatedBond, ...] = ()
    merged: Mapping[Path, Absorbed] = field(default_factory=dict[Path, Absorbed])  # bonds that another stands for

    @property
    def activated_sources(self) -> Mapping[Path, ActivatedBond]:
        """The activated bond that each source at the head of one stands for."""
        return {bond.given.parent: bond for bond in self.activated}

    @property
    def activated_probes(self) -> Mapping[Path, ActivatedBond]:
        """The activated bond that each source of nothing at the tail of one stands for."""
        return {bond.felt.parent: bond for bond in self.activated}

    @property
    def held(self) -> tuple[tuple[Expr, Expr], ...]:
        """Every held value with its start: those of controllers, then those that events change."""
        return (*(start for controller in self.controllers for start in controller.starts), *self.discretes)

    def word(self, bond: Bond, variable: Variable) -> str:
        """What an effort or flow is called in the domain of a bond."""
        domain = self.domains.get(bond.domain)
        if domain is None:
            return variable.value
        return domain.effort if variable is Variable.EFFORT else domain.flow

    def activation_text(self, bond: ActivatedBond) -> str:
        """An activated bond with a full arrow and what it carries."""
        felt, given = self.original.bonds[bond.felt], self.original.bonds[bond.given]
        return f"{felt.tail.path} => {given.head.path}  (activated: {self.word(felt, bond.carries)} only)"

    @cached_property
    def variables(self) -> Variables:
        """The symbols of efforts and flows."""
        return Variables(self)

    def __str__(self) -> str:
        lines = [f"bond graph of {self.model.name}: {len(self.normal.elements)} elements, "]
        lines[0] += f"{len(self.normal.junctions)} junctions, {len(self.normal.bonds)} bonds"
        lines.extend(f"  {element.kind:<3} {element.path}" for element in self.normal.elements.values())
        ends = {end for bond in self.activated for end in (bond.felt, bond.given)}
        lines.extend(f"  {b.tail.path} -> {b.head.path}" for b in self.normal.bonds.values() if b.name not in ends)
        lines.extend(f"  {self.activation_text(bond)}" for bond in self.activated)
        return "\n".join(lines)


class Variables:
    """The symbols of efforts and flows of bonds, each made once."""

    def __init__(self, graph: BondGraph) -> None:
        self.graph = graph
        self._known: dict[tuple[Path, Variable], Expr] = {}

    def of(self, bond: Bond, variable: Variable) -> Expr:
        """The symbol of a bond's effort or flow."""
        key = (bond.name, variable)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._symbol(bond, variable)
        return found

    def _symbol(self, bond: Bond, variable: Variable) -> Expr:
        domain = self.graph.domains.get(bond.domain)
        is_effort = variable is Variable.EFFORT
        kind = SymbolKind.EFFORT if is_effort else SymbolKind.FLOW
        unit = "" if domain is None else domain.effort_unit if is_effort else domain.flow_unit
        return symbol(kind, bond.name / variable.value, unit)
