"""What the names of a model mean: of each definition, which ports, parts and values it declares."""

from __future__ import annotations

from functools import cached_property

from propermodel.diagnostics import Path
from propermodel.expressions.core import SymbolKind
from propermodel.modelling.domains import DomainData
from propermodel.modelling.model import Block, Definition, Part, PortData, Sampled, Storage


class DeclaredNames:
    """What a definition declares, by name."""

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.ports: dict[str, PortData] = {port.name: port for port in definition.ports}
        self.parts: dict[str, Part] = {}
        for part in definition.parts:
            self.parts.setdefault(part.name, part)

    @cached_property
    def units(self) -> dict[SymbolKind, dict[str, str]]:
        """The units of what symbols of each kind name, without the variables of ports."""
        d = self.definition
        behaviour = d.behaviour
        coordinates = behaviour.coordinates if isinstance(behaviour, Storage) else ()
        states = behaviour.states if isinstance(behaviour, Block) else coordinates
        starts = behaviour.starts if isinstance(behaviour, Sampled) else ()
        return {
            SymbolKind.PARAMETER: {p.name: p.unit for p in d.parameters},
            SymbolKind.TABLE: {t.name: t.unit for t in d.tables},
            SymbolKind.SIGNAL: {s.name: s.unit for s in d.signals},
            SymbolKind.STATE: {c.name: c.unit for c in states},
            SymbolKind.DISCRETE: {name: unit for name, unit, _ in (*starts, *d.discretes)},
        }

    @cached_property
    def axes(self) -> dict[str, int]:
        """The number of coordinates of each table."""
        return {spec.name: len(spec.values.grids) for spec in self.definition.tables}


class NamesOfModel:
    """The declared names of all definitions of a model, each looked at once."""

    def __init__(self, domains: dict[str, DomainData]) -> None:
        self.domains = domains
        self._known: dict[int, DeclaredNames] = {}  # each holds its definition, which keeps the key unique

    def of(self, definition: Definition) -> DeclaredNames:
        """The names that a definition declares."""
        found = self._known.get(id(definition))
        if found is None:
            found = self._known[id(definition)] = DeclaredNames(definition)
        return found

    def owner(self, definition: Definition, path: Path) -> DeclaredNames | None:
        """What declares the last name of a path that begins in a definition."""
        names = self.of(definition)
        for name in path.parent:
            part = names.parts.get(name)
            if part is None:
                return None
            names = self.of(part.definition)
        return names

    def unit(self, definition: Definition, kind: SymbolKind, path: Path) -> str | None:
        """The unit of what a symbol in a definition names; None when there is no such thing."""
        if kind in _PORT_VARIABLES:
            return self._port_unit(definition, kind, path)
        owner = self.owner(definition, path)
        return owner.units.get(kind, {}).get(path.name) if owner else None

    def _port_unit(self, definition: Definition, kind: SymbolKind, path: Path) -> str | None:
        owner = self.owner(definition, path.parent)
        port = owner.ports.get(path.parent.name) if owner else None
        domain = self.domains.get(port.domain) if port else None
        if domain is None or path.name != kind.value:
            return None
        return {
            SymbolKind.EFFORT: domain.effort_unit,
            SymbolKind.FLOW: domain.flow_unit,
            SymbolKind.POWER: "W" if domain.is_true else "",
            SymbolKind.DISPLACEMENT: domain.displacement_unit,
            SymbolKind.MOMENTUM: domain.momentum_unit,
        }[kind]


_PORT_VARIABLES = frozenset(
    {SymbolKind.EFFORT, SymbolKind.FLOW, SymbolKind.POWER, SymbolKind.DISPLACEMENT, SymbolKind.MOMENTUM}
)
