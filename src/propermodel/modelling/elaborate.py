"""From a component to a model: the class bodies read once, names resolved, parameters checked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from propermodel.diagnostics import Diagnostic, Faults, Involved, ModelError, Path, one_of
from propermodel.expressions.core import Expr, as_expr, leaves, number
from propermodel.expressions.dimensions import DimensionMismatch, dimension_of
from propermodel.expressions.interpret import interpret
from propermodel.expressions.units import dimension_text, parse_unit
from propermodel.modelling.checks import faults_of
from propermodel.modelling.components import Component, Parameter, Repeated, Table, in_unit
from propermodel.modelling.connections import (
    Activated,
    Bonded,
    BondedVectors,
    Driven,
    Joined,
    JoinedVectors,
    Open,
    ScalarWiring,
    Wiring,
)
from propermodel.modelling.domains import DomainData
from propermodel.modelling.events import discretes_of, events_of
from propermodel.modelling.kinematics import Expansion, KinematicTransformer, expand
from propermodel.modelling.model import (
    Activation,
    Behaviour,
    Connection,
    Definition,
    Direction,
    Event,
    HalfArrow,
    Model,
    Node,
    OpenPort,
    ParameterData,
    Part,
    PortData,
    SignalData,
    SignalLink,
    TableSpec,
    TableValues,
)
from propermodel.modelling.places import place_of
from propermodel.modelling.ports import Port
from propermodel.modelling.signals import Input, Output
from propermodel.modelling.tracing import Tracer, trace
from propermodel.modelling.vector_bonds import faults_of_vector_ports, scalar_wiring


def elaborate(component: Component, *, name: str | None = None) -> Model:
    """The model that a component describes.

    Args:
        component: The root; its open ports are driven by a scenario, or are `free` on purpose.
        name: The name of the model; by default the class name in snake_case.

    Raises:
        ModelError: with every fault found in names, units, parameters and connections.
    """
    build = _Elaboration()
    root_name = name or _snake(type(component).__name__)
    root = build.part(root_name, component, build.values(component, root_name, None))
    build.faults.raise_if_any()
    model = Model(name=root_name, root=root, domains=tuple(build.domains.values()))
    build.faults.found.extend(faults_of(model))
    build.faults.raise_if_any()
    return model


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


class _Elaboration:
    def __init__(self) -> None:
        self.faults = Faults(ModelError)
        self.domains: dict[str, DomainData] = {}
        self.definitions: dict[type, Definition] = {}

    def part(self, name: str, component: Component, values: tuple[tuple[str, Expr], ...]) -> Part:
        """The part that a component instance describes."""
        tables = tuple((n, v) for n, v in component.values.items() if isinstance(v, TableValues))
        return Part(
            name=name,
            definition=self.definition(component),
            values=values,
            tables=tables,
            source=component.declared_at,
        )

    def definition(self, component: Component) -> Definition:
        """The definition of the component's class, or of the variant when parts were replaced."""
        cls = type(component)
        if component.replaced:
            return self.read(cls, component)
        if cls not in self.definitions:
            self.definitions[cls] = self.read(cls, component)
        return self.definitions[cls]

    def read(self, cls: type[Component], component: Component) -> Definition:
        """Read a class body."""
        tracing = object.__new__(cls)
        tracing._set(root=tracing, path=Path(), values={}, replaced={}, source=cls.defined_at)  # pyright: ignore[reportPrivateUsage]
        tracer = Tracer(cls, tracing)
        ports = tuple(self.port(cls, n, p) for n, p in cls.declarations.items() if isinstance(p, Port))
        parameters: list[ParameterData] = []
        for name, declared in cls.declarations.items():
            if isinstance(declared, Parameter):
                with self.faults.collecting():
                    parameters.append(_parameter(tracer, name, declared))
        inside = Expansion()
        behaviour: Behaviour = None
        events: tuple[Event, ...] = ()
        discretes: tuple[tuple[str, str, Expr], ...] = ()
        with self.faults.collecting():
            inside = expand(tracer, tuple(parameters)) if issubclass(cls, KinematicTransformer) else inside
        with self.faults.collecting():
            behaviour = trace(cls, tracing)
        with self.faults.collecting():
            discretes, events = discretes_of(tracer), events_of(tracer)
        before = len(self.faults.found)
        connections = self.connections(cls, tracer)
        if len(self.faults.found) == before:
            self.faults.found.extend(faults_of_vector_ports(cls, component, connections))
        return Definition(
            type_name=cls.__name__,
            doc=(cls.__doc__ or "").strip().split("\n")[0],
            ports=ports,
            parameters=tuple(parameters),
            tables=tuple(_table(n, t) for n, t in cls.declarations.items() if isinstance(t, Table)),
            signals=tuple(
                SignalData(
                    name=n,
                    unit=s.unit,
                    direction=Direction.INPUT if isinstance(s, Input) else Direction.OUTPUT,
                )
                for n, s in cls.declarations.items()
                if isinstance(s, (Input, Output))
            ),
            behaviour=behaviour,
            discretes=discretes,
            events=events,
            parts=(*inside.parts, *self.parts(cls, component, tracer)),
            connections=(*inside.connections, *connections),
            is_energy_group=cls.energy_group,
            source=cls.defined_at,
        )

    def port(self, cls: type[Component], name: str, port: Port[Any]) -> PortData:
        """A port as data; its domain is remembered by value."""
        data = port.domain.data()
        known = self.domains.setdefault(data.name, data)
        if known != data:
            self.faults.add(
                Diagnostic(
                    "model/two-domains",
                    f"two different domains are called '{data.name}'",
                    where=f"{cls.__name__}.{name}",
                    source=port.source,
                    help=f"give the domain class {port.domain.__name__} another name, or use the one that exists",
                )
            )
        between = None
        if port.between is not None:
            between = (cls.names[id(port.between[0])], cls.names[id(port.between[1])])
        return PortData(name=name, domain=data.name, between=between)

    def parts(self, cls: type[Component], component: Component, tracer: Tracer) -> tuple[Part, ...]:
        """The parts of a class body, with the values that it hands them."""
        result: list[Part] = []
        for name, declared in cls.declarations.items():
            if isinstance(declared, Component):
                part = component.replaced.get(name, declared)
                result.append(self.part(name, part, self.values(part, name, tracer)))
            elif isinstance(declared, Repeated):
                for index, member in enumerate(declared.parts):
                    label = f"{name}[{index}]"
                    result.append(self.part(label, member, self.values(member, label, tracer)))
        return tuple(result)

    def values(self, component: Component, name: str, tracer: Tracer | None) -> tuple[tuple[str, Expr], ...]:
        """The parameter values handed to a part, in the surrounding class's symbols, checked."""
        result: list[tuple[str, Expr]] = []
        cls = type(component)
        for key, declared in cls.declarations.items():
            if not isinstance(declared, Parameter):
                continue
            given = component.values.get(key)
            if given is None:
                if declared.default is None:
                    self.fault(
                        component,
                        name,
                        "model/missing-parameter",
                        f"needs a value for '{key}' ({declared.unit or '1'})",
                        f"give it one: {cls.__name__}({key}=...), in {declared.unit or '1'}",
                    )
                continue
            with self.faults.collecting():
                value = in_unit(given, declared.unit)
                resolved = tracer.resolve(value) if tracer else value
                if tracer is None and leaves(resolved):
                    self.fault(
                        component,
                        name,
                        "model/root-parameter",
                        f"'{key}' of the root must be a number",
                        "nothing surrounds the root, so there is nothing that an expression could refer to: "
                        "give a number",
                    )
                    continue
                self.check_value(component, name, key, declared, resolved)
                result.append((key, resolved))
        return tuple(result)

    def check_value(self, component: Component, name: str, key: str, declared: Parameter, value: Expr) -> None:
        """Report a value outside its declared range or of another dimension."""
        plain = number(value)
        if plain is not None and not math.isfinite(plain):
            self.fault(
                component,
                name,
                "model/parameter-range",
                f"'{key}' = {plain:g} is no finite number",
                "give a finite value; look at what it is computed from",
            )
            return
        if plain is not None:
            factor = parse_unit(declared.unit).factor if declared.low > -1e308 or declared.high < 1e308 else 1.0
            if not declared.low * factor <= plain <= declared.high * factor:
                self.fault(
                    component,
                    name,
                    "model/parameter-range",
                    f"'{key}' = {_in_words(plain / factor, declared.unit)} lies outside its range "
                    f"{declared.low:g} to {declared.high:g}",
                    "give a value inside the range, or widen the range where the parameter is declared",
                )
            return
        try:
            found = dimension_of(value)
        except DimensionMismatch as mismatch:
            self.fault(
                component, name, "model/dimension", f"'{key}' is not dimensionally consistent: {mismatch}", _UNITS_CURE
            )
            return
        if found is not None and found != parse_unit(declared.unit).dimension:
            self.fault(
                component,
                name,
                "model/dimension",
                f"'{key}' is handed {dimension_text(found)} where {declared.unit or '1'} is due",
                _UNITS_CURE,
            )

    def fault(self, component: Component, name: str, code: str, message: str, help: str) -> None:
        """Remember a fault of a part."""
        involved = (Involved(type(component).__name__, "is declared here", type(component).defined_at),)
        self.faults.add(
            Diagnostic(code, f"{name}: {message}", source=component.declared_at, involved=involved, help=help)
        )

    def connections(self, cls: type[Component], tracer: Tracer) -> tuple[Connection, ...]:
        """The wiring of a class body as data."""
        written: list[Wiring] = []
        for item in cls.connections:
            written.extend(item if isinstance(item, tuple) else (item,))
        flat: list[ScalarWiring] = []
        for item in written:
            if isinstance(item, (JoinedVectors, BondedVectors)):
                with self.faults.collecting():
                    flat.extend(scalar_wiring(cls, item, self.faults))
            else:
                flat.append(item)
        found: list[Connection] = []
        for item in flat:
            with self.faults.collecting():
                found.append(self.connection(cls, tracer, item))
        return tuple(found)

    def connection(self, cls: type[Component], tracer: Tracer, item: ScalarWiring) -> Connection:
        """One connection as data."""
        match item:
            case Joined():
                domains = {port.domain.name for port in item.ports}
                if len(domains) > 1:
                    self.faults.add(
                        Diagnostic(
                            "model/domain",
                            f"a connection joins ports of different domains ({', '.join(sorted(domains))})",
                            source=item.source,
                            involved=tuple(
                                Involved(str(place_of(cls, port, item.source)), f"is {port.domain.name}", port.source)
                                for port in item.ports
                            ),
                            help="put a transducer (transformer or gyrator) between the domains",
                        )
                    )
                return Node(ports=tuple(place_of(cls, port, item.source) for port in item.ports), source=item.source)
            case Bonded():
                tail, head = (place_of(cls, end, item.source) for end in item.ends)
                return HalfArrow(tail=tail, head=head, source=item.source)
            case Activated():
                tail, head = (place_of(cls, end, item.source) for end in item.ends)
                return Activation(tail=tail, head=head, carries=item.carries, source=item.source)
            case Open():
                return OpenPort(
                    port=place_of(cls, item.ports[0], item.source), opening=item.opening, source=item.source
                )
            case Driven():
                targets = tuple(tracer.local(target).data.path for target in item.targets)
                value = tracer.resolve(item.value)
                self.check_units(tracer, item, value, targets)
                return SignalLink(value=value, targets=targets, source=item.source)

    def check_units(self, tracer: Tracer, item: Driven, value: Expr, targets: tuple[Path, ...]) -> None:
        """Report a signal connected to an input of another dimension."""
        for target, path in zip(item.targets, targets, strict=True):
            unit = tracer.local(target).data.unit
            try:
                found = dimension_of(value)
                problem = "" if found in (None, parse_unit(unit).dimension) else f"{dimension_text(found or ())}"
            except DimensionMismatch as mismatch:
                problem = str(mismatch)
            if problem:
                self.faults.add(
                    Diagnostic(
                        "model/dimension",
                        f"'{path}' takes {unit or '1'} and is driven by {problem}",
                        source=item.source,
                        help=_UNITS_CURE,
                    )
                )


_UNITS_CURE = "check the units; write a number with its unit: quantity(1e-6, 'm3/s')"


def _in_words(value: float, unit: str) -> str:
    return f"{value:g}" if unit in ("", "1") else f"{value:g} {unit}"


def _parameter(tracer: Tracer, name: str, declared: Parameter) -> ParameterData:
    default = None if declared.default is None else tracer.resolve(declared.default)
    return ParameterData(
        name=name,
        unit=declared.unit,
        default=default,
        low=declared.low,
        high=declared.high,
        source=declared.origin,
        status=declared.status,
        doc=declared.doc,
    )


def _table(name: str, table: Table) -> TableSpec:
    return TableSpec(
        name=name,
        unit=table.unit,
        coordinate_units=table.coordinate_units,
        extrapolation=table.extrapolation,
        values=table.values,
        source=table.origin,
    )


def evaluate(law: Any, *arguments: float) -> float:
    """The value of a law with plain numbers: `evaluate(orifice.effort, 0.1)`; for tests and sanity checks."""
    component: Component = law.__self__
    values: dict[Expr, float] = {}
    expr: Expr = law(*(as_expr(value) for value in arguments))
    for leaf in leaves(expr):
        key = leaf.data.path.name
        given = component.values.get(key)
        if given is None:
            given = component.declarations[key].default
        values[leaf] = interpret(in_unit(given, leaf.data.unit))
    return interpret(expr, values)


def known_names(definition: Definition) -> list[str]:
    """Every name that a definition declares, for suggestions."""
    groups: tuple[tuple[Any, ...], ...] = (
        definition.ports,
        definition.parameters,
        definition.signals,
        definition.tables,
        definition.parts,
    )
    return [item.name for group in groups for item in group]


def find_part(model: Model, path: Path) -> Part:
    """The part at a path.

    Raises:
        ModelError: there is none; the nearest name is offered.
    """
    part = model.root
    for name in path:
        found: Mapping[str, Part] = {p.name: p for p in part.definition.parts}
        if name not in found:
            raise ModelError.of(
                "model/unknown-path",
                f"{model.name} has no part '{path}': '{name}' is not in {part.name}",
                help=one_of(name, known_names(part.definition), f"{part.name} has no parts"),
                source=part.source,
            )
        part = found[name]
    return part
