"""Turns the law methods of an element, block or controller class into expressions, once per class."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from propermodel.diagnostics import Diagnostic, Faults, Involved, ModelError, Path, Source, portable_file
from propermodel.expressions.core import (
    ZERO,
    Expr,
    ExprLike,
    Op,
    Substitution,
    SymbolKind,
    as_expr,
    constant,
    divide,
    is_zero,
    leaves,
    postorder,
    substitute,
    symbol,
)
from propermodel.expressions.derivatives import derivative
from propermodel.expressions.dimensions import DimensionMismatch, dimension_of
from propermodel.expressions.units import dimension_text, parse_unit
from propermodel.modelling.components import Component
from propermodel.modelling.elements import (
    Compliance,
    EffortSource,
    FlowSource,
    Gyrator,
    Inertia,
    Junction,
    MultiportCompliance,
    MultiportInertia,
    MultiportResistance,
    OneJunction,
    Resistance,
    Transformer,
)
from propermodel.modelling.model import (
    Behaviour,
    Block,
    Coordinate,
    ElementKind,
    JunctionKind,
    PowerSource,
    Preference,
    ResistanceLaw,
    Resistive,
    Result,
    Sampled,
    Storage,
    TwoPort,
    Variable,
)
from propermodel.modelling.ports import Port
from propermodel.modelling.references import Reference
from propermodel.modelling.signals import Controller, Discrete, Output, SignalBlock, State

INFINITY = constant(float("inf"))


class Tracer:
    """Calls the law methods of one class with symbols and resolves what they mention."""

    def __init__(self, cls: type[Component], component: Component) -> None:
        self.cls = cls
        self.component = component
        self.faults = Faults(ModelError)
        self.ports: dict[str, Port[Any]] = {n: p for n, p in cls.declarations.items() if isinstance(p, Port)}
        outer = {id(o) for port in self.ports.values() if port.between for o in port.between}
        self.element_ports = [name for name, port in self.ports.items() if id(port) not in outer]

    def place(self, method: str) -> Source:
        """The file and line of a law method."""
        function = getattr(self.cls, method, None)
        code = getattr(function, "__code__", None)
        return Source(portable_file(code.co_filename), code.co_firstlineno) if code else self.cls.defined_at

    def resolve(self, value: ExprLike) -> Expr:
        """The expression with symbols relative to the class in place of references."""
        expr = as_expr(value)
        return Substitution({leaf: self.local(leaf) for leaf in leaves(expr)})(expr)

    def local(self, leaf: Expr) -> Expr:
        """The symbol that a leaf of a law or class body stands for."""
        data = leaf.data
        if not isinstance(data, Reference):
            return leaf
        if data.root is self.component:
            return symbol_like(leaf, data.path)
        name = self.cls.names.get(id(data.root))
        if name is None:
            raise ModelError.of(
                "model/foreign-reference",
                f"{self.cls.__name__} mentions '{data.path or leaf!r}' of something "
                "that is not one of its direct parts",
                source=self.cls.defined_at,
                help="refer to ports, parameters and parts declared in the same class body",
            )
        return symbol_like(leaf, Path((name,)) + data.path)

    def call(self, method: str, *args: Expr) -> Any:
        """What a law method gives."""
        try:
            return getattr(self.component, method)(*args)
        except ModelError as error:
            place = self.failing_line(method)
            raise ModelError([d if d.source.line else replace(d, source=place) for d in error.diagnostics]) from None
        except Exception as error:
            raise ModelError.of(
                "model/law",
                f"the law {self.cls.__name__}.{method} cannot be read: {type(error).__name__}: {error}",
                source=self.failing_line(method),
                help="a law gives an expression of its argument, parameters, inputs and states",
            ) from error

    def failing_line(self, method: str) -> Source:
        """The author's line at which the law being called has failed."""
        place = self.place(method)
        files = ((portable_file(frame.filename), frame.lineno) for frame in reversed(inspect.trace()))
        line = next((line for file, line in files if file == place.file), place.line)
        return Source(place.file, line)

    def law(self, method: str, unit: str, *args: Expr) -> Expr:
        """The expression of a law, checked to have the dimension of `unit`."""
        value = self.resolve(self.call(method, *args))
        self.check(value, unit, method)
        return value

    def mapping(self, method: str, *args: Expr) -> dict[Path, Expr]:
        """The expressions of a law that gives several values, by the path of what they define."""
        result: dict[Path, Expr] = {}
        given: Mapping[Expr, ExprLike] = self.call(method, *args)
        for key, value in given.items():
            target = self.local(key)
            expr = self.resolve(value)
            self.check(expr, target.data.unit, method)
            result[target.data.path] = expr
        return result

    def check(self, value: Expr, unit: str, method: str) -> None:
        """Report a law whose dimension is not that of `unit`."""
        try:
            found = dimension_of(value)
        except DimensionMismatch as mismatch:
            problem = str(mismatch)
        else:
            expected = parse_unit(unit).dimension
            if found is None or found == expected:
                return
            due = f"{unit or '1'} ({dimension_text(expected)})"
            problem = f"it has the dimension {dimension_text(found)} where {due} is due"
        self.inconsistent(method, problem)

    def residual(self, given: ExprLike, method: str) -> Expr:
        """A part of an implicit law, checked to be dimensionally consistent; it may have any dimension."""
        value = self.resolve(given)
        try:
            dimension_of(value)
        except DimensionMismatch as mismatch:
            self.inconsistent(method, str(mismatch))
        return value

    def inconsistent(self, method: str, problem: str) -> None:
        """Remember a law whose dimensions do not fit."""
        self.faults.add(
            Diagnostic(
                "model/dimension",
                f"the law {self.cls.__name__}.{method} is not dimensionally consistent: {problem}",
                source=self.place(method),
                help="check the units of the parameters; write a number with its unit: quantity(1e-6, 'm3/s')",
            )
        )

    def has(self, method: str) -> bool:
        """Whether the class offers this law."""
        return callable(getattr(self.cls, method, None))

    def port(self) -> tuple[str, Port[Any]]:
        """The one port of a one-port element."""
        if len(self.element_ports) != 1:
            raise ModelError.of(
                "model/ports",
                f"{self.cls.__name__} is a one-port element but has the ports "
                f"{', '.join(self.element_ports) or 'none'}",
                source=self.cls.defined_at,
                help="give it one port; an element between two flanges has Port(domain, between=(a, b))",
            )
        name = self.element_ports[0]
        return name, self.ports[name]

    def missing(self, what: str) -> ModelError:
        """The error for a law that is not there."""
        return ModelError.of(
            "model/law-missing",
            f"{self.cls.__name__} has no {what}",
            source=self.cls.defined_at,
            involved=[Involved(self.cls.__name__, "is declared here", self.cls.defined_at)],
            help="define the law as a method of the class",
        )


def symbol_like(leaf: Expr, path: Path) -> Expr:
    """The plain symbol for a reference, now that its path is known; tables keep the units of their grids."""
    return symbol(leaf.data.kind, path, leaf.data.unit)


def variable_symbol(port: str, variable: Variable, domain: Any) -> Expr:
    """The symbol for an effort or flow of a port."""
    kind = SymbolKind.EFFORT if variable is Variable.EFFORT else SymbolKind.FLOW
    unit = domain.effort_unit if variable is Variable.EFFORT else domain.flow_unit
    return symbol(kind, Path((port, variable.value)), unit)


def linear_inverse(law: Expr, argument: Expr, result: Expr) -> Expr | None:
    """The argument as a function of the result when the law is linear in it whatever conditions say, otherwise None."""
    gain = derivative(law, argument)
    may_vanish = any(node.op is Op.WHERE and any(map(is_zero, node.args[1:])) for node in postorder([gain]))
    if may_vanish or is_zero(gain) or argument in leaves(gain):
        return None
    offset = substitute(law, {argument: ZERO})
    return divide(result - offset, gain)


def trace(cls: type[Component], component: Component) -> Behaviour:
    """The behaviour of an element, junction, block or controller class; None for a composite."""
    tracer = Tracer(cls, component)
    behaviour = _behaviour(tracer, cls)
    tracer.faults.raise_if_any()
    if isinstance(behaviour, Resistive | Storage | PowerSource | TwoPort):
        _check_pseudo(tracer, isinstance(behaviour, Resistive) and behaviour.converts)
    return behaviour


def _check_pseudo(tracer: Tracer, converts: bool) -> None:
    """Refuse an element on true and pseudo bonds that is not declared to convert between them."""
    true = [name for name in tracer.element_ports if tracer.ports[name].domain.is_true]
    pseudo = [name for name in tracer.element_ports if name not in true]
    if true and pseudo and not converts:
        raise ModelError.of(
            "model/pseudo-domain",
            f"{tracer.cls.__name__} joins true bonds ({', '.join(true)}) with pseudo bonds ({', '.join(pseudo)}), "
            "whose effort times flow is no power",
            source=tracer.cls.defined_at,
            involved=[
                Involved(name, f"is {tracer.ports[name].domain.name}", tracer.ports[name].source)
                for name in (*true, *pseudo)
            ],
            help="a MultiportResistance that is meant to convert says so: converts = True",
        )


def _behaviour(tracer: Tracer, cls: type[Component]) -> Behaviour:
    if issubclass(cls, Resistance):
        return _resistance(tracer)
    if issubclass(cls, MultiportResistance):
        return _multiport_resistance(tracer)
    if issubclass(cls, Compliance):
        return _one_port_storage(tracer, ElementKind.COMPLIANCE, "displacement", Variable.EFFORT)
    if issubclass(cls, Inertia):
        return _one_port_storage(tracer, ElementKind.INERTIA, "momentum", Variable.FLOW)
    if issubclass(cls, MultiportCompliance):
        return _multiport_storage(tracer, ElementKind.COMPLIANCE, "displacements", "efforts")
    if issubclass(cls, MultiportInertia):
        return _multiport_storage(tracer, ElementKind.INERTIA, "momenta", "flows")
    if issubclass(cls, EffortSource):
        _, port = tracer.port()
        return PowerSource(kind=ElementKind.EFFORT_SOURCE, value=tracer.law("effort", port.domain.effort_unit))
    if issubclass(cls, FlowSource):
        _, port = tracer.port()
        return PowerSource(kind=ElementKind.FLOW_SOURCE, value=tracer.law("flow", port.domain.flow_unit))
    if issubclass(cls, (Transformer, Gyrator)):
        return _two_port(tracer, cls)
    if issubclass(cls, Junction):
        return JunctionKind.ONE if issubclass(cls, OneJunction) else JunctionKind.ZERO
    if issubclass(cls, SignalBlock):
        return _block(tracer)
    if issubclass(cls, Controller):
        return _sampled(tracer)
    return None


def _resistance(tracer: Tracer) -> Resistive:
    name, port = tracer.port()
    effort = variable_symbol(name, Variable.EFFORT, port.domain)
    flow = variable_symbol(name, Variable.FLOW, port.domain)
    effort_law = tracer.law("effort", port.domain.effort_unit, flow) if tracer.has("effort") else None
    flow_law = tracer.law("flow", port.domain.flow_unit, effort) if tracer.has("flow") else None
    implicit: tuple[Expr, ...] = ()
    if tracer.has("residual"):
        residual = tracer.residual(tracer.call("residual", effort, flow), "residual")
        tracer.faults.raise_if_any()
        _check_mentions(tracer, residual, effort, flow)
        # Where the implicit law is linear in a variable it gives that variable; otherwise it is solved for it.
        effort_law = linear_inverse(residual, effort, ZERO) if effort_law is None else effort_law
        flow_law = linear_inverse(residual, flow, ZERO) if flow_law is None else flow_law
        implicit = (residual,) if effort_law is None or flow_law is None else ()
    elif effort_law is None and flow_law is None:
        raise tracer.missing("law: neither effort(flow) nor flow(effort) nor residual(effort, flow)")
    elif flow_law is None and effort_law is not None:
        flow_law = linear_inverse(effort_law, flow, effort)
    elif effort_law is None and flow_law is not None:
        effort_law = linear_inverse(flow_law, effort, flow)
    laws = [
        ResistanceLaw(results=(Result(port=name, variable=variable, value=law),))
        for variable, law in ((Variable.EFFORT, effort_law), (Variable.FLOW, flow_law))
        if law is not None
    ]
    locked = tracer.resolve(tracer.call("locked")) if tracer.has("locked") else None
    if locked is not None and effort_law is None:
        raise tracer.missing("law effort(flow), which an element with locked() needs")
    return Resistive(laws=tuple(laws), locked=locked, implicit=implicit, preference=_preference(tracer, storage=False))


def _preference(tracer: Tracer, *, storage: bool) -> Preference | None:
    """The causality that the class prefers, of the kind that its element can have."""
    wanted: object = getattr(tracer.cls, "preference", None)
    if wanted is None or (isinstance(wanted, Preference) and wanted.is_of_storage is storage):
        return wanted
    possible = [preference.value for preference in Preference if preference.is_of_storage is storage]
    raise ModelError.of(
        "model/preference",
        f"{tracer.cls.__name__} prefers the causality {wanted!s}, which it cannot have",
        source=tracer.cls.defined_at,
        help=f"write preference = Preference.{possible[0].upper()} or Preference.{possible[1].upper()}",
    )


def _check_mentions(tracer: Tracer, residual: Expr, effort: Expr, flow: Expr) -> None:
    """Refuse an implicit law without effort or without flow: it is that of a source."""
    for variable in (effort, flow):
        if variable not in leaves(residual):
            name = variable.data.path.name
            raise ModelError.of(
                "model/implicit-law",
                f"the implicit law {tracer.cls.__name__}.residual does not depend on the {name}",
                source=tracer.place("residual"),
                help="a law that leaves one variable free is that of a source: write an EffortSource or FlowSource",
            )


def _multiport_resistance(tracer: Tracer) -> Resistive:
    laws: list[ResistanceLaw] = []
    for given in tracer.call("laws"):
        results: list[Result] = []
        for key, value in given.items():
            target, expr = tracer.local(key), tracer.resolve(value)
            tracer.check(expr, target.data.unit, "laws")
            port, variable = target.data.path
            results.append(Result(port=port, variable=Variable(variable), value=expr))
        results.sort(key=lambda r: tracer.element_ports.index(r.port))
        laws.append(ResistanceLaw(results=tuple(results)))
    implicit = tuple(tracer.residual(given, "residuals") for given in tracer.call("residuals"))
    if not laws and not implicit:
        raise tracer.missing("law: neither laws() nor residuals()")
    if implicit and len(implicit) != len(tracer.element_ports):
        raise tracer.missing(
            f"residual for every port: {len(implicit)} for the ports {', '.join(tracer.element_ports)}"
        )
    return Resistive(laws=tuple(laws), implicit=implicit, converts=bool(getattr(tracer.cls, "converts", False)))


def _limits(tracer: Tracer) -> tuple[Expr, Expr]:
    if not tracer.has("limits"):
        return -INFINITY, INFINITY
    low, high = tracer.call("limits")
    return tracer.resolve(low), tracer.resolve(high)


def _one_port_storage(tracer: Tracer, kind: ElementKind, coordinate: str, output: Variable) -> Storage:
    name, port = tracer.port()
    is_c = kind is ElementKind.COMPLIANCE
    unit = port.domain.displacement_unit if is_c else port.domain.momentum_unit
    out_unit = port.domain.effort_unit if is_c else port.domain.flow_unit
    state = symbol(SymbolKind.STATE, Path((coordinate,)), unit)
    out = variable_symbol(name, output, port.domain)
    law = tracer.law(output.value, out_unit, state) if tracer.has(output.value) else None
    inverse = tracer.law(coordinate, unit, out) if tracer.has(coordinate) else None
    if law is None and inverse is not None:
        law = linear_inverse(inverse, out, state)
    if law is None:
        raise tracer.missing(f"law {output.value}({coordinate})")
    if inverse is None:
        inverse = linear_inverse(law, state, out)
    if tracer.has("energy"):
        energy = _energy(tracer, [port], state)
    else:
        gain = derivative(law, state)
        if state in leaves(gain):
            raise tracer.missing(f"energy({coordinate}), which a nonlinear storage needs for the energy balance")
        energy = gain * state * state / 2.0 + substitute(law, {state: ZERO}) * state
    start = tracer.law("start", unit) if tracer.has("start") else ZERO
    low, high = _limits(tracer)
    return Storage(
        kind=kind,
        coordinates=(Coordinate(name=coordinate, unit=unit, start=start, low=low, high=high),),
        stored=((name, state),),
        outputs=((name, law),),
        energy=energy,
        inverse=inverse,
        preference=_preference(tracer, storage=True),
    )


def _energy(tracer: Tracer, ports: Sequence[Port[Any]], *args: Expr) -> Expr:
    """The stored energy, J; on pseudo bonds the function whose slopes are the efforts, in their own unit."""
    if all(port.domain.is_true for port in ports):
        return tracer.law("energy", "J", *args)
    return tracer.residual(tracer.call("energy", *args), "energy")


def _states(tracer: Tracer) -> tuple[Coordinate, ...]:
    ranges = _ranges(tracer)
    free = (-INFINITY, INFINITY)
    return tuple(
        Coordinate(
            name=name,
            unit=state.unit,
            start=tracer.resolve(state.start),
            low=ranges.get(name, free)[0],
            high=ranges.get(name, free)[1],
        )
        for name, state in tracer.cls.declarations.items()
        if isinstance(state, State)
    )


def _ranges(tracer: Tracer) -> dict[str, tuple[Expr, Expr]]:
    """The range of each state that `limits()` names: `{self.volume: (low, high)}`."""
    if not tracer.has("limits"):
        return {}
    found: dict[str, tuple[Expr, Expr]] = {}
    for key, (low, high) in tracer.call("limits").items():
        target = tracer.local(key)
        ends = (tracer.resolve(low), tracer.resolve(high))
        for end in ends:
            tracer.check(end, target.data.unit, "limits")
        found[target.data.path.name] = ends
    return found


def _multiport_storage(tracer: Tracer, kind: ElementKind, stored: str, outputs: str) -> Storage:
    coordinates = _states(tracer)
    states = [symbol(SymbolKind.STATE, Path((c.name,)), c.unit) for c in coordinates]
    if len(coordinates) != len(tracer.element_ports):
        raise tracer.missing(f"one State per port ({len(tracer.element_ports)} ports, {len(coordinates)} states)")
    energy = _energy(tracer, [tracer.ports[name] for name in tracer.element_ports])
    if tracer.has(stored):
        by_port = {path[0]: expr for path, expr in tracer.mapping(stored).items()}
        stored_laws = tuple((port, by_port[port]) for port in tracer.element_ports)
    else:
        stored_laws = tuple(zip(tracer.element_ports, states, strict=True))
    if tracer.has(outputs):
        laws = {path[0]: expr for path, expr in tracer.mapping(outputs).items()}
        output_laws = tuple((port, laws[port]) for port in tracer.element_ports)
    else:
        output_laws = tuple(
            (port, derivative(energy, state)) for port, state in zip(tracer.element_ports, states, strict=True)
        )
    return Storage(
        kind=kind,
        coordinates=coordinates,
        stored=stored_laws,
        outputs=output_laws,
        energy=energy,
        preference=_preference(tracer, storage=True),
    )


def _two_port(tracer: Tracer, cls: type[Component]) -> TwoPort:
    if tracer.element_ports != ["a", "b"]:
        raise tracer.missing("ports a and b, in this order")
    a, b = tracer.ports["a"].domain, tracer.ports["b"].domain
    kind = ElementKind.TRANSFORMER if issubclass(cls, Transformer) else ElementKind.GYRATOR
    per = b.effort_unit if kind is ElementKind.TRANSFORMER else b.flow_unit
    modulus = tracer.resolve(tracer.call("modulus"))
    tracer.check(modulus * symbol(SymbolKind.EFFORT, Path(("b", "unit")), per), a.effort_unit, "modulus")
    return TwoPort(kind=kind, modulus=modulus)


def _block(tracer: Tracer) -> Block:
    outputs = tuple((path.name, expr) for path, expr in tracer.mapping("outputs").items())
    states = _states(tracer)
    rates: list[tuple[str, Expr]] = []
    for key, value in tracer.call("derivatives").items():
        target, expr = tracer.local(key), tracer.resolve(value)
        tracer.check(expr * symbol(SymbolKind.TIME, Path(("time",)), "s"), target.data.unit, "derivatives")
        rates.append((target.data.path.name, expr))
    return Block(outputs=outputs, states=states, derivatives=tuple(rates))


def _sampled(tracer: Tracer) -> Sampled:
    starts = tuple(
        (name, port.unit, tracer.resolve(port.start))
        for name, port in tracer.cls.declarations.items()
        if isinstance(port, (Discrete, Output))
    )
    updates = tuple((path.name, expr) for path, expr in tracer.mapping("step").items())
    period = symbol(SymbolKind.PARAMETER, Path(("period",)), "s")
    return Sampled(period=period, starts=starts, updates=updates)
