"""From a hierarchical model to its flat bond graph in normal form, removals included."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace

from propermodel.bondgraph.activated import Ends, activated, faults, sources_of, with_domains
from propermodel.bondgraph.circles import parameter_circles
from propermodel.bondgraph.domains import complete_domains, mixed_domains
from propermodel.bondgraph.graph import (
    ActivatedBond,
    Bond,
    BondGraph,
    Element,
    End,
    FlatEvent,
    FlatParameter,
    FlatTable,
    Junction,
    NodePort,
    SampledController,
    SignalState,
    Structure,
)
from propermodel.bondgraph.net import Net
from propermodel.bondgraph.nodes import Nodes
from propermodel.bondgraph.parameters import faults_of_range, parameter_values
from propermodel.bondgraph.removals import make_removals
from propermodel.bondgraph.scope import Scope
from propermodel.bondgraph.simplify import normalise
from propermodel.diagnostics import Diagnostic, Faults, Involved, ModelError, Path, Source, one_of
from propermodel.expressions.core import TIME, Expr, SymbolKind, constant, lookup, symbol
from propermodel.expressions.units import parse_unit
from propermodel.modelling.domains import Shared
from propermodel.modelling.model import (
    Activation,
    Block,
    Definition,
    Direction,
    ElementKind,
    Freeze,
    HalfArrow,
    JunctionKind,
    Model,
    Node,
    Opening,
    OpenPort,
    Part,
    PowerSource,
    Resistive,
    Sampled,
    SignalLink,
    Storage,
    TableSpec,
    TableValues,
    TwoPort,
)


def flatten(model: Model) -> BondGraph:
    """The bond graph of a model: hierarchy resolved, removals made, in normal form.

    Raises:
        ModelError: a port is unconnected, an input undriven, parameters are defined in a circle, a removal names
            nothing.
    """
    walk = _Flattening(model)
    walk.visit(model.root)
    walk.drive_signals()
    walk.check_frozen_signals()
    original = walk.structure()
    walk.define_inputs()
    circles = parameter_circles(walk.parameters.values())
    walk.faults.found.extend(circles or _out_of_range(walk.parameters))
    walk.faults.raise_if_any()
    net = Net(original)
    net.probes.update(bond.felt.parent for bond in walk.activated)
    normalise(net, [])
    make_removals(net, walk.domains, model.removals, walk.input_table)
    normal = net.freeze()
    return BondGraph(
        model=model,
        normal=normal,
        original=original,
        domains={domain.name: domain for domain in model.domains},
        signals=walk.signals,
        signal_states=tuple(walk.signal_states),
        controllers=tuple(walk.controllers),
        parameters=walk.parameters,
        tables=walk.tables,
        node_ports=walk.node_ports,
        removals=model.removals,
        known_zero={name: v for name, v in net.known_zero.items() if name in original.bonds},
        idle=tuple(path for path in original.elements if path not in normal.elements),
        discretes=tuple(walk.discretes),
        activated=tuple(bond for bond in walk.activated if bond.given in normal.bonds),
        events=tuple(event for event in walk.events if _still_happens(event, original, normal)),
        merged=dict(net.merged),
    )


def _out_of_range(parameters: Mapping[Path, FlatParameter]) -> Iterator[Diagnostic]:
    """Values that leave the range of a parameter: defaults, and what one component hands to another."""
    help = "give a value inside the range, or widen the range where the parameter is declared"
    return faults_of_range("model/parameter-range", parameters.values(), parameter_values(parameters), help)


def _in_si(limit: float, unit: str) -> float:
    return limit * parse_unit(unit).factor if math.isfinite(limit) else limit


def _still_happens(event: FlatEvent, original: Structure, normal: Structure) -> bool:
    """Whether removals have left what an event belongs to: a block, or an element that is what it was."""
    before, after = original.elements.get(event.element), normal.elements.get(event.element)
    return before is None or (after is not None and after.kind is before.kind)


class _Flattening:
    def __init__(self, model: Model) -> None:
        self.model = model
        self.domains = {domain.name: domain for domain in model.domains}
        self.faults = Faults(ModelError)
        self.elements: dict[Path, Element] = {}
        self.written: dict[Path, Junction] = {}
        self.port_domain: dict[Path, str] = {}
        self.nodes = Nodes()
        self.node_source: dict[Path, Source] = {}
        self.links: list[tuple[Path, Expr, Source]] = []
        self.arrows: list[tuple[Path, Path, Source]] = []
        self.activations: list[Ends] = []
        self.activated: list[ActivatedBond] = []
        self.element_ports: list[tuple[Path, Path, str]] = []  # port path, element path, port name
        self.openings: dict[Path, Opening] = {}
        self.scenario_ports: set[Path] = set()
        self.composites: list[Path] = []
        self.signals: dict[Expr, Expr] = {}
        self.declared_signals: dict[Expr, tuple[Direction, Source]] = {}
        self.signal_states: list[SignalState] = []
        self.controllers: list[SampledController] = []
        self.discretes: list[tuple[Expr, Expr]] = []
        self.events: list[FlatEvent] = []
        self.parameters: dict[Path, FlatParameter] = {}
        self.tables: dict[Path, FlatTable] = {}
        self.node_ports: dict[Path, NodePort] = {}
        self.frozen = {r.signal: r.value for r in model.removals if isinstance(r, Freeze)}

    # -- hierarchy ---------------------------------------------------------------------------------

    def visit(self, root: Part) -> None:
        """Add the root and all parts below it."""
        stack: list[tuple[Part, Path, Scope, Path | None]] = [(root, Path(), Scope(Path()), None)]
        while stack:
            part, path, parent_scope, group = stack.pop()
            definition = part.definition
            scope = self.declare(part, path, parent_scope)
            if group is None and definition.is_energy_group:
                group = path
            self.behave(definition, path, scope, group, part.source)
            for connection in definition.connections:
                self.connect(connection, path, scope)
            self.check_ports(definition, path)
            for inner in reversed(definition.parts):
                # What a mechanism stands for is declared where the mechanism is.
                placed = inner if inner.source.line else replace(inner, source=part.source)
                stack.append((placed, path / inner.name, scope, group))

    def declare(self, part: Part, path: Path, parent_scope: Scope) -> Scope:
        """Declare parameters, tables, signals and ports of a part; gives the scope of its expressions."""
        definition = part.definition
        scope = Scope(path)
        values = dict(part.values)
        for data in definition.parameters:
            flat = symbol(SymbolKind.PARAMETER, path / data.name, data.unit)
            value = parent_scope(values[data.name]) if data.name in values else None
            if value is None and data.default is not None:
                value = scope(data.default)
            if value is None:
                self.faults.add(
                    Diagnostic(
                        "model/missing-parameter",
                        f"the parameter '{path / data.name}' has no value",
                        source=part.source,
                        help=f"give it a value in {data.unit or '1'}",
                    )
                )
                value = constant(0.0)
            self.parameters[path / data.name] = FlatParameter(
                path=path / data.name,
                unit=data.unit,
                symbol=flat,
                value=value,
                low=_in_si(data.low, data.unit),
                high=_in_si(data.high, data.unit),
                origin=data.source,
                status=data.status,
                source=part.source,
            )
        tables = dict(part.tables)
        for spec in definition.tables:
            self.tables[path / spec.name] = FlatTable(
                path=path / spec.name,
                symbol=symbol(SymbolKind.TABLE, path / spec.name, spec.unit),
                spec=spec,
                values=tables.get(spec.name, spec.values),
            )
        for signal in definition.signals:
            leaf = symbol(SymbolKind.SIGNAL, path / signal.name, signal.unit)
            self.declared_signals[leaf] = (signal.direction, part.source)
        for port in definition.ports:
            self.port_domain[path / port.name] = port.domain
            self.nodes.add(path / port.name)
        return scope

    def behave(self, definition: Definition, path: Path, scope: Scope, group: Path | None, source: Source) -> None:
        """Add the element, junction, block or controller that a part is."""
        behaviour = definition.behaviour
        match behaviour:
            case None:
                self.composites.append(path)
            case JunctionKind():
                self.written[path] = Junction(path=path, kind=behaviour, source=source)
            case Block():
                for name, value in behaviour.outputs:
                    self.define(scope.own(SymbolKind.SIGNAL, name, definition), scope(value))
                rates = dict(behaviour.derivatives)
                for coordinate in behaviour.states:
                    self.signal_states.append(
                        SignalState(
                            symbol=symbol(SymbolKind.STATE, path / coordinate.name, coordinate.unit),
                            coordinate=scope.coordinate(coordinate),
                            derivative=scope(rates[coordinate.name]) if coordinate.name in rates else constant(0.0),
                            source=source,
                        )
                    )
            case Sampled():
                self.controllers.append(scope.controller(behaviour, source))
                for name, _, _ in behaviour.starts:
                    leaf = scope.own(SymbolKind.SIGNAL, name, definition)
                    if leaf is not None:
                        self.define(leaf, symbol(SymbolKind.DISCRETE, path / name, leaf.data.unit))
            case Resistive() | Storage() | PowerSource() | TwoPort():
                self.add_element(definition, path, scope, group, source)
        self.discretes.extend(
            (symbol(SymbolKind.DISCRETE, path / name, unit), scope(start)) for name, unit, start in definition.discretes
        )
        self.events.extend(scope.event(event) for event in definition.events)

    def add_element(self, definition: Definition, path: Path, scope: Scope, group: Path | None, source: Source) -> None:
        """Add an element with its ports, and the junction of an element between two ports."""
        differences = [port for port in definition.ports if port.between]
        outer = {name for port in differences for name in port.between or ()}
        ports = tuple(port.name for port in definition.ports if port.name not in outer)
        behaviour = scope.behaviour(definition.behaviour)
        kind = ElementKind.RESISTANCE if isinstance(behaviour, Resistive) else behaviour.kind
        self.elements[path] = Element(
            path=path, kind=kind, ports=ports, behaviour=behaviour, row=group or path, source=source
        )
        for port in differences:
            if port.between:
                shared = self.domains[port.domain].shared
                kind = JunctionKind.ZERO if shared is Shared.FLOW else JunctionKind.ONE
                middle = path / ("difference" if len(differences) == 1 else f"{port.name}_difference")
                self.written[middle] = Junction(path=middle, kind=kind, source=source)
                self.arrows.append((path / port.between[0], middle, source))
                self.arrows.append((middle, path / port.between[1], source))
                self.arrows.append((middle, path / port.name, source))
        self.element_ports.extend((path / name, path, name) for name in ports)

    # -- wiring ------------------------------------------------------------------------------------

    def connect(self, connection: object, path: Path, scope: Scope) -> None:
        """Add one connection of a composite."""
        match connection:
            case Node():
                ports = [path + port for port in connection.ports]
                for port in ports:
                    self.nodes.add(port)
                for port in ports[1:]:
                    self.nodes.join(ports[0], port)
                self.node_source.setdefault(self.nodes.find(ports[0]), connection.source)
            case HalfArrow():
                self.arrows.append((path + connection.tail, path + connection.head, connection.source))
            case Activation(tail=tail, head=head, carries=carries, source=source):
                self.activations.append(Ends(place=path, tail=tail, head=head, carries=carries, source=source))
            case SignalLink():
                value = scope(connection.value)
                self.links.extend((path + target, value, connection.source) for target in connection.targets)
            case OpenPort():
                if not path:
                    self.openings[connection.port] = connection.opening
            case _:
                raise TypeError(f"unknown connection {connection!r}")

    def drive_signals(self) -> None:
        """Let every signal link drive its targets, now that all signals are declared."""
        by_path = {leaf.data.path: leaf for leaf in self.declared_signals}
        for target, value, source in self.links:
            if target in by_path:
                self.define(by_path[target], value, source)
            else:
                self.faults.add(
                    Diagnostic(
                        "model/unknown-signal",
                        f"'{target}' is not an input or output",
                        source=source,
                        help=one_of(str(target), map(str, by_path), "this model has no inputs or outputs"),
                    )
                )

    def define(self, leaf: Expr | None, value: Expr, source: Source | None = None) -> None:
        """Give a signal its value; a signal has one."""
        if leaf is None:
            return
        if leaf.data.path in self.frozen:
            value = constant(self.frozen[leaf.data.path])
        elif leaf in self.signals:
            self.faults.add(
                Diagnostic(
                    "model/signal-driven-twice",
                    f"'{leaf.data.path}' is driven twice",
                    source=source or Source("", 0),
                    help="an input takes one signal; add them in a block if both are meant",
                )
            )
        self.signals[leaf] = value

    def check_ports(self, definition: Definition, path: Path) -> None:
        """Every port of a part is named by a connection of the component that has the part."""
        if definition.behaviour is not None:
            return
        named: set[Path] = set()
        for connection in definition.connections:
            if isinstance(connection, Node):
                named.update(connection.ports)
            elif isinstance(connection, HalfArrow | Activation):
                named.update((connection.tail, connection.head))
            elif isinstance(connection, OpenPort):
                named.add(connection.port)
        for part in definition.parts:
            between = {p.name: p for p in part.definition.ports if p.between}
            for port in part.definition.ports:
                if port.name not in between and Path((part.name, port.name)) not in named:
                    self.faults.add(
                        Diagnostic(
                            "model/unconnected-port",
                            f"the {port.domain} port '{path / part.name / port.name}' is not connected",
                            source=part.source,
                            involved=(
                                Involved(str(path / part.name), f"is a {part.definition.type_name}", part.source),
                            ),
                            help="connect it, or end it with a source (a fixed flange, a ground, an ambient)",
                        )
                    )

    def open_ports(self) -> None:
        """Give open ports of the root their source."""
        for port in self.model.root.definition.ports:
            path = Path((port.name,))
            opening = self.openings.get(path)
            if opening is None:
                self.faults.add(
                    Diagnostic(
                        "model/open-port",
                        f"the port '{port.name}' of the root {self.model.name} is open",
                        source=self.model.root.definition.source,
                        help=f"say how: free({port.name}), prescribed_flow({port.name}) or "
                        f"prescribed_effort({port.name}) in its connections, or connect it in a larger model",
                    )
                )
            elif opening is not Opening.FREE:
                self.add_port_source(path, opening)

    def add_port_source(self, path: Path, opening: Opening) -> None:
        domain = self.domains[self.port_domain[path]]
        is_flow = opening is Opening.FLOW
        unit = domain.flow_unit if is_flow else domain.effort_unit
        table = self.input_table(path / opening.value, unit)
        kind = ElementKind.FLOW_SOURCE if is_flow else ElementKind.EFFORT_SOURCE
        element = path / "source"
        self.elements[element] = Element(
            path=element,
            kind=kind,
            ports=("port",),
            behaviour=PowerSource(kind=kind, value=table),
            row=element,
            source=self.model.root.definition.source,
        )
        port = element / "port"
        self.scenario_ports.add(port)
        self.port_domain[port] = domain.name
        self.nodes.add(port)
        self.nodes.join(path, port)
        self.element_ports.append((port, element, "port"))

    def input_table(self, path: Path, unit: str) -> Expr:
        """A root input as a look-up over time."""
        leaf = symbol(SymbolKind.TABLE, path, unit)
        values = TableValues(((0.0, 1.0),), (0.0, 0.0))
        spec = TableSpec(name=path.name, unit=unit, coordinate_units=("s",), extrapolation="hold", values=values)
        self.tables[path] = FlatTable(path=path, symbol=leaf, spec=spec, values=values, is_input=True)
        return lookup(leaf, TIME)

    # -- result ------------------------------------------------------------------------------------

    def structure(self) -> Structure:
        """The graph as drawn: a junction for every node."""
        self.open_ports()
        junctions = dict(self.written)
        bonds: dict[Path, Bond] = {}
        terminals = {port: (element, name) for port, element, name in self.element_ports}

        def place(path: Path) -> End:
            if path in self.written:
                return End(path)
            node = self.nodes.find(path)
            if node not in junctions:
                shared = self.domains[self.port_domain[path]].shared
                kind = JunctionKind.ONE if shared is Shared.FLOW else JunctionKind.ZERO
                junctions[node] = Junction(path=node, kind=kind, source=self.node_source.get(node, Source("", 0)))
            return End(node)

        def domain_of(*paths: Path) -> str:
            return next((self.port_domain[p] for p in paths if p in self.port_domain), "")

        reached = Counter(port for tail, head, _ in self.arrows for port in (tail, head))
        for tail, head, _ in self.arrows:
            # A port of an element that only this arrow reaches needs no node of its own, if the arrow has the element's
            # sense; otherwise it starts or ends at a node, and the element hangs there with its own sense.
            ends = [
                End(*terminals[p])
                if p in terminals
                and reached[p] == 1
                and not self.nodes.is_shared(p)
                and self.has_sense(*terminals[p], into)
                else place(p)
                for p, into in ((tail, False), (head, True))
            ]
            if ends[0].port and ends[1].port:
                # Each element has its laws in the variables of its own port: two bonds with a junction between them.
                node = place(tail)
                bonds[tail] = Bond(tail, ends[0], node, domain_of(tail))
                bonds[head] = Bond(head, node, ends[1], domain_of(head))
                continue
            name = next((p for p in (head, tail) if p in terminals and ends[(tail, head).index(p)].port), None)
            if name is None:
                name = tail / f"to_{'_'.join(head)}"
            while name in bonds:
                name = name.parent / f"{name.name}_"
            bonds[name] = Bond(name, ends[0], ends[1], domain_of(tail, head))
        for port, element, label in self.element_ports:
            if port in bonds:
                continue
            node, end = place(port), End(element, label)
            out = label == "b" and isinstance(self.elements[element].behaviour, TwoPort)
            # What the scenario prescribes at a port acts on the component: power enters there.
            out = out or port in self.scenario_ports
            tail, head = (end, node) if out else (node, end)
            bonds[port] = Bond(port, tail, head, self.port_domain[port])
        for ends in self.activations:
            bond, both = activated(ends, place(ends.place + ends.tail), place(ends.place + ends.head))
            self.activated.append(bond)
            bonds.update({one.name: one for one in both})
        complete_domains(bonds)
        self.activate(bonds, junctions)
        structure = Structure(self.elements, junctions, bonds)
        self.faults.found.extend(mixed_domains(structure, self.port_domain))
        self.find_node_ports(structure)
        return structure

    def activate(self, bonds: dict[Path, Bond], junctions: dict[Path, Junction]) -> None:
        """Put the sources at both ends of activated bonds, whose domains are known by now."""
        with_domains(bonds, self.activated)
        for bond in self.activated:
            found = faults(bond, bonds, junctions, self.domains)
            self.faults.found.extend(found)
            sources = sources_of(bond, self.domains.get(bonds[bond.felt].domain))
            self.elements.update({source.path: source for source in sources})

    def has_sense(self, element: Path, port: str, into: bool) -> bool:
        """Whether the law of an element holds for a half arrow that points into it (or away from it)."""
        behaviour = self.elements[element].behaviour
        if isinstance(behaviour, PowerSource):
            return True
        return into is not (isinstance(behaviour, TwoPort) and port == "b")

    def find_node_ports(self, structure: Structure) -> None:
        """Remember, for every port of a composite, the bonds on its inner side."""
        at = structure.at()
        ports: dict[Path, list[tuple[Path, str]]] = {}
        for port, domain in self.port_domain.items():
            ports.setdefault(port.parent, []).append((port, domain))
        for path in self.composites:
            depth = len(path)
            for port, domain in ports.get(path, []):
                node = self.nodes.find(port)
                if node not in structure.junctions:
                    continue
                inside = tuple(
                    bond.name
                    for bond in at[node]
                    if bond.other(node).owner[:depth] == tuple(path)
                    and len(bond.other(node).owner) > depth
                    and bond.name not in self.scenario_ports
                )
                self.node_ports[port] = NodePort(node, inside, domain)

    def define_inputs(self) -> None:
        """Root inputs become look-ups over time; any other undriven input is a fault."""
        for leaf, (direction, source) in self.declared_signals.items():
            if leaf in self.signals:
                continue
            path: Path = leaf.data.path
            if direction is Direction.INPUT and len(path) == 1:
                self.define(leaf, self.input_table(path, leaf.data.unit))
                continue
            what = "input" if direction is Direction.INPUT else "output"
            self.faults.add(
                Diagnostic(
                    "model/undriven-signal",
                    f"the {what} '{path}' has no value",
                    source=source,
                    help="connect a signal to it: connect(part.port.flow, other.input)",
                )
            )

    def check_frozen_signals(self) -> None:
        """Every frozen signal exists."""
        known = {leaf.data.path for leaf in self.declared_signals}
        for path in self.frozen:
            if path not in known:
                self.faults.add(
                    Diagnostic(
                        "reduction/unknown-removal",
                        f"a removal freezes '{path}', which is no signal of this model",
                        help=one_of(str(path), map(str, known), "this model has no signals"),
                    )
                )
