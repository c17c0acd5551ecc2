"""Bond graphs as drawn: junctions, the bonds between them, and elements that hang on junctions; and their models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from propermodel.diagnostics import Path
from propermodel.expressions import Expr, exp, log, sin, sqrt, time
from propermodel.expressions.core import ZERO, SymbolKind, constant, divide, symbol
from propermodel.modelling import Electrical, Hydraulic, Rotation, Translation
from propermodel.modelling.domains import Domain, DomainData
from propermodel.modelling.model import (
    Behaviour,
    Coordinate,
    Definition,
    Direction,
    ElementKind,
    HalfArrow,
    JunctionKind,
    Model,
    Part,
    PortData,
    PowerSource,
    ResistanceLaw,
    Resistive,
    Result,
    SignalData,
    SignalLink,
    Storage,
    TwoPort,
    Variable,
)

DOMAINS: tuple[type[Domain], ...] = (Translation, Rotation, Hydraulic, Electrical)
DATA: dict[str, DomainData] = {domain.name: domain.data() for domain in DOMAINS}

LawKind = Literal["linear", "sinh", "cubic"]  # a u; a sinh(u), invertible; a (u + u^3), given one way only


@dataclass(frozen=True)
class Knot:
    """A junction."""

    kind: JunctionKind
    domain: str


@dataclass(frozen=True)
class Wire:
    """A bond between two junctions."""

    tail: int
    head: int


@dataclass(frozen=True)
class OnePort:
    """A C, I or R with a law, or a source whose value is size + swing sin(2 time)."""

    kind: ElementKind
    knot: int
    size: float
    law: LawKind = "linear"
    swing: float = 0.0
    turned: bool = False  # the half arrow points away from it


@dataclass(frozen=True)
class Modulus:
    """size (1 + depth sin(argument)); the argument is time or the stored quantity of a one-port storage."""

    size: float
    depth: float = 0.0
    storage: int | None = None


@dataclass(frozen=True)
class Coupler:
    """A transformer or gyrator from one junction to another."""

    kind: ElementKind
    knots: tuple[int, int]
    modulus: Modulus
    turned: tuple[bool, bool] = (False, False)


@dataclass(frozen=True)
class Field:
    """A C, I or R with several ports: its matrix gives efforts from displacements (flows), or flows from momenta."""

    kind: ElementKind
    knots: tuple[int, ...]
    matrix: tuple[tuple[float, ...], ...]

    @property
    def ports(self) -> tuple[str, ...]:
        """The names of the ports."""
        return tuple(f"p{number}" for number in range(len(self.knots)))


@dataclass(frozen=True)
class Graph:
    """A bond graph as drawn."""

    knots: tuple[Knot, ...]
    wires: tuple[Wire, ...]
    one_ports: tuple[OnePort, ...]
    couplers: tuple[Coupler, ...] = ()
    fields: tuple[Field, ...] = ()

    def domain(self, knot: int) -> DomainData:
        """The domain of a junction."""
        return DATA[self.knots[knot].domain]


# -- the model of a graph -------------------------------------------------------------------------------


def model_of(graph: Graph, prefix: str = "", order: Sequence[int] | None = None) -> Model:
    """The model of a graph, as plain data; names get the prefix, parts and bonds stand in the order of the keys."""
    parts = [
        *(Part(name=f"{prefix}j{n}", definition=_junction(knot)) for n, knot in enumerate(graph.knots)),
        *(Part(name=f"{prefix}e{n}", definition=_one_port(graph, one)) for n, one in enumerate(graph.one_ports)),
        *(Part(name=f"{prefix}t{n}", definition=_coupler(graph, two)) for n, two in enumerate(graph.couplers)),
        *(Part(name=f"{prefix}m{n}", definition=_field(graph, field)) for n, field in enumerate(graph.fields)),
    ]
    arrows: list[HalfArrow | SignalLink] = [
        HalfArrow(tail=Path((f"{prefix}j{wire.tail}",)), head=Path((f"{prefix}j{wire.head}",))) for wire in graph.wires
    ]

    def arrow(port: Path, knot: int, inward: bool) -> None:
        junction = Path((f"{prefix}j{knot}",))
        tail, head = (junction, port) if inward else (port, junction)
        arrows.append(HalfArrow(tail=tail, head=head))

    for n, one in enumerate(graph.one_ports):
        arrow(Path((f"{prefix}e{n}", "port")), one.knot, not one.turned)
    for n, two in enumerate(graph.couplers):
        arrow(Path((f"{prefix}t{n}", "a")), two.knots[0], not two.turned[0])
        arrow(Path((f"{prefix}t{n}", "b")), two.knots[1], two.turned[1])
        if two.modulus.depth and two.modulus.storage is not None:
            arrows.append(_argument(graph, prefix, n, two.modulus.storage))
    for n, field in enumerate(graph.fields):
        for port, knot in zip(field.ports, field.knots, strict=True):
            arrow(Path((f"{prefix}m{n}", port)), knot, True)
    if order is not None:
        parts = _shuffled(parts, order)
        arrows = _shuffled(arrows, order)
    root = Definition(type_name="Drawn", doc="", parts=tuple(parts), connections=tuple(arrows))
    return Model(name="drawn", root=Part(name="drawn", definition=root), domains=tuple(DATA.values()))


def _shuffled(items: list, order: Sequence[int]) -> list:
    keys = [order[n % len(order)] + n // len(order) for n in range(len(items))]
    return [item for _, _, item in sorted(zip(keys, range(len(items)), items, strict=True), key=lambda x: x[:2])]


def _argument(graph: Graph, prefix: str, coupler: int, storage: int) -> SignalLink:
    one = graph.one_ports[storage]
    domain = graph.domain(one.knot)
    is_c = one.kind is ElementKind.COMPLIANCE
    kind = SymbolKind.DISPLACEMENT if is_c else SymbolKind.MOMENTUM
    unit = domain.displacement_unit if is_c else domain.momentum_unit
    value = symbol(kind, Path((f"{prefix}e{storage}", "port", kind.value)), unit)
    return SignalLink(value=value, targets=(Path((f"{prefix}t{coupler}", "argument")),))


def _junction(knot: Knot) -> Definition:
    return Definition(type_name=f"Junction{knot.kind}", doc="", behaviour=knot.kind)


def _variable(domain: DomainData, port: str, variable: Variable) -> Expr:
    kind = SymbolKind.EFFORT if variable is Variable.EFFORT else SymbolKind.FLOW
    unit = domain.effort_unit if variable is Variable.EFFORT else domain.flow_unit
    return symbol(kind, Path((port, variable.value)), unit)


def _law(kind: LawKind, size: float, u: Expr) -> Expr:
    if kind == "linear":
        return size * u
    if kind == "sinh":
        return size * (exp(u) - exp(-u)) / 2.0
    return size * (u + u * u * u)


def _inverse(kind: LawKind, size: float, v: Expr) -> Expr | None:
    w = divide(v, size)
    if kind == "linear":
        return w
    return log(w + sqrt(w * w + 1.0)) if kind == "sinh" else None


def _energy(kind: LawKind, size: float, u: Expr) -> Expr:
    if kind == "linear":
        return size * u * u / 2.0
    if kind == "sinh":
        return size * ((exp(u) + exp(-u)) / 2.0 - 1.0)
    return size * (u * u / 2.0 + u * u * u * u / 4.0)


def _coordinate(name: str, domain: DomainData, kind: ElementKind) -> tuple[Coordinate, Expr]:
    unit = domain.displacement_unit if kind is ElementKind.COMPLIANCE else domain.momentum_unit
    infinite = constant(float("inf"))
    coordinate = Coordinate(name=name, unit=unit, start=ZERO, low=-infinite, high=infinite)
    return coordinate, symbol(SymbolKind.STATE, Path((name,)), unit)


def _one_port(graph: Graph, one: OnePort) -> Definition:
    domain = graph.domain(one.knot)
    effort, flow = (_variable(domain, "port", variable) for variable in Variable)
    behaviour: Behaviour
    match one.kind:
        case ElementKind.EFFORT_SOURCE | ElementKind.FLOW_SOURCE:
            value = constant(one.size) + one.swing * sin(2.0 * time) if one.swing else constant(one.size)
            behaviour = PowerSource(kind=one.kind, value=value)
        case ElementKind.RESISTANCE:
            laws = [_result(("port", Variable.EFFORT, _law(one.law, one.size, flow)))]
            inverse = _inverse(one.law, one.size, effort)
            if inverse is not None:
                laws.append(_result(("port", Variable.FLOW, inverse)))
            behaviour = Resistive(laws=tuple(laws))
        case _:
            name = "displacement" if one.kind is ElementKind.COMPLIANCE else "momentum"
            coordinate, state = _coordinate(name, domain, one.kind)
            given = effort if one.kind is ElementKind.COMPLIANCE else flow
            behaviour = Storage(
                kind=one.kind,
                coordinates=(coordinate,),
                stored=(("port", state),),
                outputs=(("port", _law(one.law, one.size, state)),),
                energy=_energy(one.law, one.size, state),
                inverse=_inverse(one.law, one.size, given),
            )
    return Definition(
        type_name=f"{one.kind}_{one.law}",
        doc="",
        ports=(PortData(name="port", domain=domain.name),),
        behaviour=behaviour,
    )


def _result(*given: tuple[str, Variable, Expr]) -> ResistanceLaw:
    return ResistanceLaw(results=tuple(Result(port=p, variable=v, value=x) for p, v, x in given))


def _coupler(graph: Graph, two: Coupler) -> Definition:
    modulus: Expr = constant(two.modulus.size)
    signals: tuple[SignalData, ...] = ()
    if two.modulus.depth:
        argument = time
        if two.modulus.storage is not None:
            argument = symbol(SymbolKind.SIGNAL, Path(("argument",)))
            signals = (SignalData(name="argument", unit="", direction=Direction.INPUT),)
        modulus = two.modulus.size * (1.0 + two.modulus.depth * sin(argument))
    a, b = (graph.domain(knot).name for knot in two.knots)
    return Definition(
        type_name=f"{two.kind}",
        doc="",
        ports=(PortData(name="a", domain=a), PortData(name="b", domain=b)),
        signals=signals,
        behaviour=TwoPort(kind=two.kind, modulus=modulus),
    )


def _field(graph: Graph, field: Field) -> Definition:
    domains = [graph.domain(knot) for knot in field.knots]
    behaviour: Behaviour
    if field.kind is ElementKind.RESISTANCE:
        flows = [_variable(d, p, Variable.FLOW) for d, p in zip(domains, field.ports, strict=True)]
        efforts = [sum((c * f for c, f in zip(row, flows, strict=True)), ZERO) for row in field.matrix]
        law = _result(*((p, Variable.EFFORT, e) for p, e in zip(field.ports, efforts, strict=True)))
        behaviour = Resistive(laws=(law,))
    else:
        made = [_coordinate(f"{p}_stored", d, field.kind) for p, d in zip(field.ports, domains, strict=True)]
        states = [state for _, state in made]
        gradient = [sum((c * s for c, s in zip(row, states, strict=True)), ZERO) for row in field.matrix]
        behaviour = Storage(
            kind=field.kind,
            coordinates=tuple(coordinate for coordinate, _ in made),
            stored=tuple(zip(field.ports, states, strict=True)),
            outputs=tuple(zip(field.ports, gradient, strict=True)),
            energy=sum((s * g for s, g in zip(states, gradient, strict=True)), ZERO) / 2.0,
        )
    ports = tuple(PortData(name=p, domain=d.name) for p, d in zip(field.ports, domains, strict=True))
    return Definition(type_name=f"Field{field.kind}", doc="", ports=ports, behaviour=behaviour)
