"""How parts are wired: `connect`, `bond`, `chain`, and what an open port of the root means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, TypeVar, overload

from propermodel.diagnostics import ModelError, Source, UnknownNameError
from propermodel.expressions.core import Expr
from propermodel.modelling.domains import Domain
from propermodel.modelling.elements import Junction
from propermodel.modelling.model import Opening, Variable
from propermodel.modelling.ports import Port, VectorPort
from propermodel.modelling.references import call_site

D = TypeVar("D", bound=Domain)
V = TypeVar("V", bound=VectorPort)


@dataclass(frozen=True)
class Joined:
    """Ports joined to one node."""

    ports: tuple[Port[Any], ...]
    source: Source


@dataclass(frozen=True)
class Bonded:
    """A half arrow from one port or junction to another."""

    ends: tuple[Port[Any] | Junction, Port[Any] | Junction]  # tail, head
    source: Source


@dataclass(frozen=True)
class Activated:
    """An activated bond from one port or junction to another."""

    ends: tuple[Port[Any] | Junction, Port[Any] | Junction]  # tail, head
    carries: Variable
    source: Source


@dataclass(frozen=True)
class JoinedVectors:
    """Vector ports joined member by member."""

    ports: tuple[VectorPort, ...]
    source: Source


@dataclass(frozen=True)
class BondedVectors:
    """A vector bond: a half arrow for each bond of the vector port at its tail to that at its head."""

    ends: tuple[VectorPort, VectorPort]  # tail, head
    source: Source


@dataclass(frozen=True)
class Driven:
    """A signal that drives others."""

    value: Expr
    targets: tuple[Expr, ...]
    source: Source


@dataclass(frozen=True)
class Open:
    """What an open port means when its component is the root."""

    ports: tuple[Port[Any]]
    opening: Opening
    source: Source


VectorWiring = JoinedVectors | BondedVectors
ScalarWiring = Joined | Bonded | Activated | Driven | Open
Wiring = ScalarWiring | VectorWiring


@overload
def connect(first: Port[D], *others: Port[D]) -> Wiring: ...
@overload
def connect(first: V, *others: V) -> Wiring: ...
@overload
def connect(first: Expr, *others: Expr) -> Wiring: ...
def connect(first: Any, *others: Any) -> Wiring:
    """Join power ports to one node, vector ports member by member, or let the first signal drive the others.

    A node is a 1-junction where the domain shares a flow (mechanics), a 0-junction where it shares an effort.
    The first signal may be any expression of outputs, inputs and observables of parts.
    """
    return _connected(first, others, call_site(1))


def _connected(first: Any, others: tuple[Any, ...], site: Source) -> Wiring:
    if isinstance(first, Port) and all(isinstance(other, Port) for other in others):
        return Joined((first, *others), site)
    if isinstance(first, Expr) and others and all(isinstance(other, Expr) for other in others):
        return Driven(first, others, site)
    if isinstance(first, VectorPort) and all(isinstance(other, VectorPort) for other in others):
        return JoinedVectors((first, *others), site)
    names = ", ".join(type(item).__name__ for item in (first, *others))
    if any(isinstance(item, VectorPort) for item in (first, *others)):
        raise ModelError.of(
            "model/connect",
            f"connect joins a vector port with vector ports only; it was given {names}",
            source=site,
            help="name the member that is meant (connect(a.frame.x, b.flange)), or join vector ports of equal members",
        )
    raise ModelError.of(
        "model/connect",
        f"connect joins power ports, or a signal with the inputs it drives; it was given {names}",
        source=site,
        help="name a port of the part (connect(a.flange, b.flange)), "
        "or an observable (connect(a.flange.flow, c.speed))",
    )


@overload
def bond(tail: Port[Any] | Junction, head: Port[Any] | Junction) -> Wiring: ...
@overload
def bond(tail: V, head: V) -> Wiring: ...
def bond(tail: Any, head: Any) -> Wiring:
    """A bond whose half arrow points from `tail` to `head`: power is positive that way.

    Between vector ports it is a vector bond, with one half arrow for each pair of members.
    """
    site = call_site(1)
    if isinstance(tail, VectorPort) and isinstance(head, VectorPort):
        return BondedVectors((tail, head), site)
    if isinstance(tail, VectorPort) or isinstance(head, VectorPort):
        raise ModelError.of(
            "model/bond",
            f"a bond joins a vector port with a vector port only; it was given {type(tail).__name__} "
            f"and {type(head).__name__}",
            source=site,
            help="name the member that is meant: bond(a.frame.x, junction)",
        )
    return Bonded((tail, head), site)


def activated_bond(
    tail: Port[Any] | Junction, head: Port[Any] | Junction, *, carries: Literal["effort", "flow"]
) -> Wiring:
    """An activated bond: the effort (or flow) at `tail` acts at `head`, and nothing acts back.

    At its tail it takes no power, at its head it gives what the effort (or flow) there needs; the energy balance of a
    run names it with that energy. An effort is taken from a 0-junction, a flow from a 1-junction: anywhere else a bond
    without the other variable would hold the junction still.
    """
    site = call_site(1)
    if carries not in tuple(Variable):
        raise ModelError.of(
            "model/activated-bond",
            f"an activated bond carries an effort or a flow; it was given '{carries}'",
            source=site,
            help='write carries="effort" or carries="flow"',
        )
    return Activated((tail, head), Variable(carries), site)


def chain(parts: Sequence[Any], out: str, into: str) -> tuple[Wiring, ...]:
    """Connections of each part's port `out` with the next one's port `into`; both may be vector ports."""
    site = call_site(1)
    return tuple(_connected(_port(a, out, site), (_port(b, into, site),), site) for a, b in pairwise(parts))


def _port(part: Any, name: str, site: Source) -> Any:
    """The port of a part that the author names at a place."""
    try:
        return getattr(part, name)
    except UnknownNameError as error:
        raise UnknownNameError([replace(diagnostic, source=site) for diagnostic in error.diagnostics]) from None


@overload
def free(port: Port[Any]) -> Wiring: ...
@overload
def free(port: VectorPort) -> tuple[Wiring, ...]: ...
def free(port: Port[Any] | VectorPort) -> Any:
    """Leave this port open on purpose when its component is the root of a model."""
    return _opened(port, Opening.FREE, call_site(1))


@overload
def prescribed_flow(port: Port[Any]) -> Wiring: ...
@overload
def prescribed_flow(port: VectorPort) -> tuple[Wiring, ...]: ...
def prescribed_flow(port: Port[Any] | VectorPort) -> Any:
    """The scenario gives this port's flow when its component is the root: input `port.flow`."""
    return _opened(port, Opening.FLOW, call_site(1))


@overload
def prescribed_effort(port: Port[Any]) -> Wiring: ...
@overload
def prescribed_effort(port: VectorPort) -> tuple[Wiring, ...]: ...
def prescribed_effort(port: Port[Any] | VectorPort) -> Any:
    """The scenario gives this port's effort when its component is the root: input `port.effort`."""
    return _opened(port, Opening.EFFORT, call_site(1))


def _opened(port: Port[Any] | VectorPort, opening: Opening, site: Source) -> Wiring | tuple[Wiring, ...]:
    if isinstance(port, VectorPort):
        return tuple(Open((member,), opening, site) for member in port.members.values() if isinstance(member, Port))
    return Open((port,), opening, site)
