"""Vector bonds as scalar ones: what joins vector ports joins their members, and what does not fit is explained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from propermodel.diagnostics import Diagnostic, Faults, Involved, Path
from propermodel.modelling.components import Component, Repeated
from propermodel.modelling.connections import (
    Bonded,
    BondedVectors,
    Driven,
    Joined,
    JoinedVectors,
    ScalarWiring,
    VectorWiring,
)
from propermodel.modelling.model import Connection, HalfArrow, Node
from propermodel.modelling.places import place_of
from propermodel.modelling.ports import Port, VectorPort, member_name

CODE = "model/vector-port"


def scalar_wiring(cls: type[Component], item: VectorWiring, faults: Faults) -> tuple[ScalarWiring, ...]:
    """The connections of members that a connection of vector ports stands for."""
    ports = item.ports if isinstance(item, JoinedVectors) else item.ends
    if len({tuple(_members(port).items()) for port in ports}) > 1:
        faults.add(_different(cls, item, ports))
        return ()
    found: list[ScalarWiring] = []
    signals: list[str] = []
    for name, member in ports[0].members.items():
        if not isinstance(member, Port):
            signals.append(name)
        elif isinstance(item, BondedVectors):
            found.append(Bonded((item.ends[0].members[name], item.ends[1].members[name]), item.source))
        else:
            found.append(Joined(tuple(port.members[name] for port in ports), item.source))
    if not signals:
        return tuple(found)
    giving = [port for port in ports if _gives(port)]
    if len(giving) != 1:
        faults.add(_not_given_once(cls, item, ports, signals))
        return ()
    (giver,) = giving
    takers = [port for port in ports if port is not giver]
    if takers:
        found.extend(
            Driven(giver.members[name], tuple(port.members[name] for port in takers), item.source) for name in signals
        )
    return tuple(found)


def _members(port: VectorPort) -> Mapping[str, str]:
    """The members of a vector port, each with its domain or unit."""
    return {
        name: member.domain.name if isinstance(member, Port) else member.data.unit or "1"
        for name, member in port.members.items()
    }


def _gives(port: VectorPort) -> bool:
    """Whether a vector port, as seen from inside the component that wires it, gives its signals.

    A part gives its outputs; what the component itself takes from outside it gives to its parts.
    """
    is_own = port.root is port
    return port.gives is not is_own


def faults_of_vector_ports(
    cls: type[Component], component: Component, connections: Sequence[Connection]
) -> list[Diagnostic]:
    """Vector ports of the parts of a class that are not connected, or of which only some members are."""
    named: set[Path] = set()
    for connection in connections:
        if isinstance(connection, Node):
            named.update(connection.ports)
        elif isinstance(connection, HalfArrow):
            named.update((connection.tail, connection.head))
    return [
        fault
        for label, part in _parts(cls, component)
        for name, vector in type(part).declarations.items()
        if isinstance(vector, VectorPort) and (fault := _incomplete(label, part, name, vector, named)) is not None
    ]


def _parts(cls: type[Component], component: Component) -> list[tuple[str, Component]]:
    found: list[tuple[str, Component]] = []
    for name, declared in cls.declarations.items():
        if isinstance(declared, Component):
            found.append((name, component.replaced.get(name, declared)))
        elif isinstance(declared, Repeated):
            found.extend((f"{name}[{index}]", member) for index, member in enumerate(declared.parts))
    return found


def _incomplete(label: str, part: Component, name: str, vector: VectorPort, named: set[Path]) -> Diagnostic | None:
    bonds = [member for member, port in vector.members.items() if isinstance(port, Port)]
    missing = [member for member in bonds if Path((label, member_name(name, member))) not in named]
    if not missing:
        return None
    involved = (Involved(label, f"is a {type(part).__name__}", part.declared_at),)
    place = Path((label, name))
    if missing == bonds:
        return Diagnostic(
            "model/unconnected-port",
            f"the vector port '{place}' ({', '.join(bonds)}) is not connected",
            source=part.declared_at,
            involved=involved,
            help="connect it, or end it with sources of no effort or no flow",
        )
    rest = ", ".join(member for member in bonds if member not in missing)
    return Diagnostic(
        CODE,
        f"of the vector port '{place}' only {rest} {'is' if ',' not in rest else 'are'} connected, "
        f"not {', '.join(missing)}",
        source=part.declared_at,
        involved=involved,
        help="connect it as one, or each of its members: end what is left with a source of no effort or no flow",
    )


def _different(cls: type[Component], item: VectorWiring, ports: Sequence[VectorPort]) -> Diagnostic:
    def listed(port: VectorPort) -> str:
        return ", ".join(f"{name} ({what})" for name, what in _members(port).items())

    return Diagnostic(
        CODE,
        "a connection joins vector ports of different members",
        source=item.source,
        involved=tuple(
            Involved(str(place_of(cls, port, item.source)), f"has {listed(port)}", port.source) for port in ports
        ),
        help="join vector ports of equal members, or name those that are meant: connect(a.frame.x, b.point.x)",
    )


def _not_given_once(
    cls: type[Component], item: VectorWiring, ports: Sequence[VectorPort], signals: Sequence[str]
) -> Diagnostic:
    gives = [_gives(port) for port in ports]
    what = ", ".join(signals)
    return Diagnostic(
        CODE,
        f"{sum(gives)} vector ports of a connection give {what}"
        if any(gives)
        else f"no vector port of a connection gives {what}",
        source=item.source,
        involved=tuple(
            Involved(str(place_of(cls, port, item.source)), "gives them" if given else "takes them", port.source)
            for port, given in zip(ports, gives, strict=True)
        ),
        help="exactly one gives them to the others: where two do, put a part between that takes them on both sides"
        if any(gives)
        else "exactly one gives them to the others: connect a part whose port is declared by giving()",
    )
