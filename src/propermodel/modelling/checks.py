"""Whether the names inside a model fit together: a class body guarantees it, plain data has to prove it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from types import NoneType

from propermodel.diagnostics import Diagnostic, Path, Source, nearest
from propermodel.expressions.core import Expr, Op, SymbolKind
from propermodel.modelling.declared_names import NamesOfModel
from propermodel.modelling.limits import Limits, exceeded
from propermodel.modelling.model import (
    Activation,
    Behaviour,
    Block,
    Connection,
    Definition,
    Direction,
    HalfArrow,
    JunctionKind,
    Model,
    Node,
    OpenPort,
    Part,
    PowerSource,
    Resistive,
    Sampled,
    SignalLink,
    Storage,
    TwoPort,
)

CODE = "model/inconsistent"
MOST_TOLD = 2000  # letters of a fault


def faults_of(model: Model, limits: Limits | None = None, *, most: int | None = None) -> list[Diagnostic]:
    """The names in the model that do not fit, definition by definition; all, or the first `most` of them.

    Raises:
        DocumentError: the definitions use more nodes of expressions than `limits` allow.
    """
    names = NamesOfModel({domain.name: domain for domain in model.domains})
    notes = _Notes(most, limits)
    if len(names.domains) < len(model.domains):
        notes.add(Diagnostic(CODE, "two domains have one name", "domains", help="rename one of them"))
    try:
        for definition in definitions_of(model.root):
            _Check(definition, names, notes).run()
        root = model.root
        _Check(Definition(type_name="the model", doc="", parts=(root,)), names, notes).values(root)
    except _EnoughError:
        pass
    return notes.found


class _EnoughError(Exception):
    """As many faults have been found as will be told."""


class _Notes:
    """The faults found so far, and the nodes of expressions that were looked at."""

    def __init__(self, most: int | None, limits: Limits | None) -> None:
        self.found: list[Diagnostic] = []
        self.uses = 0
        self._most = most
        self._most_uses = limits.expression_uses if limits else None

    def add(self, fault: Diagnostic) -> None:
        """Remember a fault."""
        self.found.append(fault)
        if len(self.found) == self._most:
            raise _EnoughError

    def use(self, definition: Definition) -> None:
        """Count a node of an expression."""
        self.uses += 1
        if self._most_uses is not None and self.uses > self._most_uses:
            raise exceeded(
                "expression_uses",
                f"the definitions use more than {self._most_uses} expressions",
                definition.type_name[:60],
            )


def definitions_of(root: Part) -> list[Definition]:
    """Every definition below a part once, in order of first use."""
    found: dict[int, Definition] = {}
    pending = [root.definition]
    while pending:
        definition = pending.pop()
        if id(definition) not in found:
            found[id(definition)] = definition
            pending.extend(part.definition for part in reversed(definition.parts))
    return list(found.values())


class _Check:
    """The checks of one definition."""

    def __init__(self, definition: Definition, names: NamesOfModel, notes: _Notes) -> None:
        self.definition = definition
        self.known = names
        self.domains = names.domains
        self.notes = notes
        self.ports = names.of(definition).ports
        self.parts = names.of(definition).parts
        self.seen: dict[bool, set[Expr]] = {False: set(), True: set()}  # nodes, by what they may mention

    def run(self) -> None:
        """Find every fault of the definition."""
        d = self.definition
        before = len(self.notes.found)
        groups: tuple[Iterable[str], ...] = (
            (p.name for p in d.ports),
            (p.name for p in d.parameters),
            (t.name for t in d.tables),
            (s.name for s in d.signals),
            (p.name for p in d.parts),
        )
        for name, count in Counter(name for group in groups for name in group).items():
            if count > 1:
                self.fault(f"the name '{name}' is given {count} times")
        self.check_ports()
        if len(self.notes.found) > before:
            return
        for parameter in d.parameters:
            if parameter.default is not None:
                self.expr(parameter.default, f"the default of '{parameter.name}'", only_parameters=True)
        for spec in d.tables:
            if len(spec.coordinate_units) != len(spec.values.grids) or len(spec.values.grids) not in (1, 2):
                self.fault(f"the table '{spec.name}' needs one or two grids, each with a unit")
            if spec.extrapolation not in ("hold", "linear"):
                self.fault(f"the table '{spec.name}' has the unknown extrapolation '{spec.extrapolation}'")
        for part in d.parts:
            self.values(part)
        self.behaviour(d.behaviour)
        self.events()
        for connection in d.connections:
            self.connection(connection)

    def fault(self, message: str, help: str = "", source: Source | None = None) -> None:
        """Remember a fault; names in a file may be as long as its author likes, what is said of them may not."""
        d = self.definition
        if len(message) > MOST_TOLD:
            message = f"{message[: MOST_TOLD // 2]} … {message[-MOST_TOLD // 4 :]}"
        cure = help or f"name what {d.type_name} and its direct parts declare, each once and with its own unit"
        self.notes.add(Diagnostic(CODE, message, d.type_name, source or d.source, help=cure))

    def check_ports(self) -> None:
        """Domains exist, and differences are between two plain ports of the same domain."""
        for port in self.definition.ports:
            if port.domain not in self.domains:
                known = nearest(port.domain, self.domains)
                self.fault(f"the domain '{port.domain}' of port '{port.name}' is unknown", known)
            for outer in port.between or ():
                other = self.ports.get(outer)
                if other is None or other.between is not None or other.domain != port.domain:
                    self.fault(f"port '{port.name}' is between '{outer}', which is no plain port of its domain")
            if port.between and port.between[0] == port.between[1]:
                self.fault(f"port '{port.name}' is between one port and itself")
            if port.between and (
                self.definition.behaviour is None or isinstance(self.definition.behaviour, JunctionKind)
            ):
                self.fault(f"port '{port.name}' is between two others, but is not the port of an element")

    # -- expressions -------------------------------------------------------------------------------

    def expr(self, expr: Expr, what: str, *, only_parameters: bool = False, condition: bool = False) -> None:
        """Every symbol of an expression exists."""
        if expr.is_condition is not condition:
            self.fault(f"{what} must be {'a condition' if condition else 'a number'}")
        if _is_table(expr):
            self.fault(f"{what} is a table where a number is due")
        for node in self.unseen(expr, self.seen[only_parameters]):
            if node.op is Op.SYMBOL:
                self.symbol(node, what, only_parameters)
            elif node.args and _is_table(node.args[0]):
                self.lookup(node, what)

    def unseen(self, root: Expr, seen: set[Expr]) -> Iterator[Expr]:
        """The nodes of an expression that no other expression of the definition has shown."""
        stack = [root]
        while stack:
            node = stack.pop()
            if node not in seen:
                seen.add(node)
                self.notes.use(self.definition)
                yield node
                stack.extend(reversed(node.args))

    def symbol(self, leaf: Expr, what: str, only_parameters: bool) -> None:
        """A symbol names what there is, in its unit."""
        kind, path, unit = leaf.data.kind, leaf.data.path, leaf.data.unit
        if only_parameters and kind is not SymbolKind.PARAMETER:
            self.fault(f"{what} mentions '{path}', which is not a parameter")
        elif kind is not SymbolKind.TIME and self.known.unit(self.definition, kind, path) != unit:
            self.fault(f"{what} mentions the {kind} '{path}' ({unit or '1'}), which does not exist")

    def lookup(self, node: Expr, what: str) -> None:
        """The arity of a look-up is that of its table."""
        path = node.args[0].data.path
        owner = self.known.owner(self.definition, path)
        axes = owner.axes.get(path.name) if owner else None
        if axes is not None and axes != len(node.args) - 1:
            self.fault(f"{what} looks up '{path}' with {len(node.args) - 1} coordinates")

    # -- parts, behaviour, connections -------------------------------------------------------------

    def values(self, part: Part) -> None:
        """The values handed to a part belong to its parameters."""
        declared = self.known.of(part.definition)
        parameters = declared.units[SymbolKind.PARAMETER]
        self.names((name for name, _ in part.values), parameters, f"the values of '{part.name}'")
        self.names((name for name, _ in part.tables), declared.axes, f"the tables of '{part.name}'")
        for name, value in part.values:
            self.expr(value, f"the value of '{part.name}.{name}'", only_parameters=True)
        for name, table in part.tables:
            if len(table.grids) != declared.axes.get(name, len(table.grids)):
                self.fault(f"the table '{part.name}.{name}' has another number of grids than it is declared with")

    def names(self, given: Iterable[str], known: Iterable[str], what: str, *, all_of: bool = False) -> None:
        """Names are known and given once; with `all_of`, each is given."""
        names, options = Counter(given), dict.fromkeys(known)
        for name, count in names.items():
            if name not in options:
                self.fault(f"{what}: there is no '{name}'", nearest(name, options))
            elif count > 1:
                self.fault(f"{what}: '{name}' is given {count} times")
        for name in options if all_of else ():
            if name not in names:
                self.fault(f"{what}: '{name}' is missing")

    def behaviour(self, behaviour: Behaviour) -> None:
        """The laws name the ports and states of the element."""
        outer = {name for port in self.definition.ports for name in port.between or ()}
        ports = [name for name in self.ports if name not in outer]
        converts = isinstance(behaviour, Resistive) and behaviour.converts
        is_element = isinstance(behaviour, Resistive | Storage | PowerSource | TwoPort)
        if is_element and not converts and len({self.domains[self.ports[name].domain].is_true for name in ports}) > 1:
            self.fault("an element that does not convert has ports on true and on pseudo bonds")
        match behaviour:
            case Resistive():
                self.resistive(behaviour, ports)
            case Storage():
                self.storage(behaviour, ports)
            case PowerSource():
                self.expr(behaviour.value, "the value of the source")
                if len(ports) != 1:
                    self.fault(f"a source has one port, this has {len(ports)}")
            case TwoPort():
                self.expr(behaviour.modulus, "the modulus")
                if behaviour.position is not None:
                    self.expr(behaviour.position, "the position")
                if ports != ["a", "b"]:
                    self.fault("a transformer or gyrator has the ports a and b")
            case Block() | Sampled():
                self.signals(behaviour)
            case JunctionKind() | None:
                pass

    def resistive(self, behaviour: Resistive, ports: list[str]) -> None:
        """Every law gives one variable of each port; an implicit law has as many parts as ports."""
        if not (behaviour.laws or behaviour.implicit) or not ports:
            self.fault("a resistance needs a port and a law")
        for residual in behaviour.implicit:
            self.expr(residual, "the implicit law")
        if behaviour.implicit and len(behaviour.implicit) != len(ports):
            self.fault(f"an implicit law has one part for each port, this has {len(behaviour.implicit)}")
        for number, law in enumerate(behaviour.laws):
            self.names((r.port for r in law.results), ports, f"law {number + 1}", all_of=True)
            for result in law.results:
                self.expr(result.value, f"the {result.variable} of port '{result.port}'")
        if behaviour.locked is not None:
            self.expr(behaviour.locked, "the condition for being locked", condition=True)
            if len(ports) != 1:
                self.fault("only a resistance with one port can be locked")

    def storage(self, behaviour: Storage, ports: list[str]) -> None:
        """A storage has as many coordinates as ports, and laws for each port."""
        names = [c.name for c in behaviour.coordinates]
        self.names(names, dict.fromkeys(names), "the coordinates")
        if len(names) != len(ports) or not ports:
            self.fault(f"a storage has one coordinate for each port, this has {len(names)} for {len(ports)}")
        self.names((port for port, _ in behaviour.stored), ports, "the stored quantities", all_of=True)
        self.names((port for port, _ in behaviour.outputs), ports, "the outputs", all_of=True)
        for coordinate in behaviour.coordinates:
            for what in ("start", "low", "high"):
                self.expr(getattr(coordinate, what), f"the {what} of '{coordinate.name}'")
        for port, value in (*behaviour.stored, *behaviour.outputs):
            self.expr(value, f"the law of port '{port}'")
        self.expr(behaviour.energy, "the energy")
        if behaviour.inverse is not None:
            self.expr(behaviour.inverse, "the inverse law")
            if len(ports) != 1:
                self.fault("only a storage with one port has an inverse law")

    def signals(self, behaviour: Block | Sampled) -> None:
        """A block or controller gives its outputs and states."""
        outputs = [s.name for s in self.definition.signals if s.direction is Direction.OUTPUT]
        if isinstance(behaviour, Block):
            states = [c.name for c in behaviour.states]
            self.names(states, dict.fromkeys(states), "the states")
            self.names((n for n, _ in behaviour.outputs), outputs, "the outputs")
            self.names((n for n, _ in behaviour.derivatives), states, "the derivatives")
            values = [*behaviour.outputs, *behaviour.derivatives]
            values.extend((c.name, e) for c in behaviour.states for e in (c.start, c.low, c.high))
        else:
            starts = [name for name, _, _ in behaviour.starts]
            self.names(starts, dict.fromkeys(starts), "the starts")
            self.names((n for n, _ in behaviour.updates), starts, "the updates")
            values = [("period", behaviour.period), *behaviour.updates]
            values.extend((name, start) for name, _, start in behaviour.starts)
        for name, value in values:
            self.expr(value, f"the value of '{name}'")

    def events(self) -> None:
        """Events belong to elements and blocks, and change what is their own."""
        d = self.definition
        if (d.events or d.discretes) and isinstance(d.behaviour, (Sampled, JunctionKind, NoneType)):
            self.fault("only an element or a signal block has events and discrete values of its own")
        names = [name for name, _, _ in d.discretes]
        self.names(names, dict.fromkeys(names), "the discrete values")
        for name, _, start in d.discretes:
            self.expr(start, f"the start of '{name}'", only_parameters=True)
        for number, event in enumerate(d.events, 1):
            self.expr(event.condition, f"the condition of event {number}", condition=True)
            for target, value in event.changes:
                self.expr(value, f"a value of event {number}")
                kind = None if target.args else getattr(target.data, "kind", None)
                if kind not in (SymbolKind.STATE, SymbolKind.DISCRETE) or len(target.data.path) != 1:
                    self.fault(
                        f"event {number} changes what is no state or discrete value of its own", source=event.source
                    )
                else:
                    self.expr(target, f"event {number}")
            if event.restitution is not None:
                self.expr(event.restitution, f"the restitution of event {number}")
                if not (isinstance(d.behaviour, Resistive) and _is_one_port(d.behaviour)):
                    self.fault("only a resistance with one port has impulses", source=event.source)
            if not event.changes and event.restitution is None:
                self.fault(f"event {number} changes nothing", source=event.source)

    def connection(self, connection: Connection) -> None:
        """A connection names ports of the definition and of its direct parts."""
        match connection:
            case Node():
                domains = {self.port_domain(path, connection.source) for path in connection.ports} - {None}
                if not connection.ports:
                    self.fault("a connection joins nothing", source=connection.source)
                if len(domains) > 1:
                    joined = ", ".join(sorted(str(d) for d in domains))
                    self.fault(f"a connection joins ports of different domains ({joined})", source=connection.source)
            case HalfArrow() | Activation():
                for path in (connection.tail, connection.head):
                    part = self.parts.get(path.name) if len(path) == 1 else None
                    if part is None or not isinstance(part.definition.behaviour, JunctionKind):
                        self.port_domain(path, connection.source)
            case SignalLink():
                self.expr(connection.value, "a signal")
                for path in connection.targets:
                    if self.known.unit(self.definition, SymbolKind.SIGNAL, path) is None or len(path) > 2:
                        self.fault(f"there is no signal '{path}' to drive", source=connection.source)
            case OpenPort():
                if len(connection.port) != 1 or connection.port.name not in self.ports:
                    self.fault(f"there is no port '{connection.port}' to leave open", source=connection.source)

    def port_domain(self, path: Path, source: Source) -> str | None:
        """The domain of a port of the definition or of a direct part."""
        ports = self.ports
        if len(path) == 2 and path[0] in self.parts:
            ports = self.known.of(self.parts[path[0]].definition).ports
        elif len(path) != 1:
            ports = {}
        if path.name not in ports:
            self.fault(f"there is no port '{path}' to connect", nearest(path.name, ports), source)
            return None
        return ports[path.name].domain


def _is_one_port(behaviour: Resistive) -> bool:
    return all(len(law.results) == 1 for law in behaviour.laws)


def _is_table(expr: Expr) -> bool:
    return not expr.args and getattr(expr.data, "kind", None) is SymbolKind.TABLE
