"""How parts are wired: `connect`, `bond`, `chain`, and what an open port of the root means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, TypeVar, overload

from propermodel.diagnostics import ModelError, Source, UnknownNameError
from propermodel.expressions.core import Expr
from propermodel.modelling.components import Port, call_site
from propermodel.modelling.domains import Domain
from propermodel.modelling.elements import Junction
from propermodel.modelling.model import Opening, Variable

D = TypeVar("D", bound=Domain)


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


Wiring = Joined | Bonded | Activated | Driven | Open


@overload
def connect(first: Port[D], *others: Port[D]) -> Wiring: ...
@overload
def connect(first: Expr, *others: Expr) -> Wiring: ...
def connect(first: Any, *others: Any) -> Wiring:
    """Join power ports to one node, or let the first signal drive the others.

    A node is a 1-junction where the domain shares a flow (mechanics), a 0-junction where it shares an effort.
    The first signal may be any expression of outputs, inputs and observables of parts.
    """
    site = call_site(1)
    if isinstance(first, Port) and all(isinstance(other, Port) for other in others):
        return Joined((first, *others), site)
    if isinstance(first, Expr) and others and all(isinstance(other, Expr) for other in others):
        return Driven(first, others, site)
    names = ", ".join(type(item).__name__ for item in (first, *others))
    raise ModelError.of(
        "model/connect",
        f"connect joins power ports, or a signal with the inputs it drives; it was given {names}",
        source=site,
        help="name a port of the part (connect(a.flange, b.flange)), "
        "or an observable (connect(a.flange.flow, c.speed))",
    )


def bond(tail: Port[Any] | Junction, head: Port[Any] | Junction) -> Wiring:
    """A bond whose half arrow points from `tail` to `head`: power is positive that way."""
    return Bonded((tail, head), call_site(1))


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
    """Connections of each part's port `out` with the next one's port `into`."""
    site = call_site(1)
    return tuple(Joined((_port(a, out, site), _port(b, into, site)), site) for a, b in pairwise(parts))


def _port(part: Any, name: str, site: Source) -> Port[Any]:
    """The port of a part that the author names at a place."""
    try:
        return getattr(part, name)
    except UnknownNameError as error:
        raise UnknownNameError([replace(diagnostic, source=site) for diagnostic in error.diagnostics]) from None


def free(port: Port[Any]) -> Wiring:
    """Leave this port open on purpose when its component is the root of a model."""
    return Open((port,), Opening.FREE, call_site(1))


def prescribed_flow(port: Port[Any]) -> Wiring:
    """The scenario gives this port's flow when its component is the root: input `port.flow`."""
    return Open((port,), Opening.FLOW, call_site(1))


def prescribed_effort(port: Port[Any]) -> Wiring:
    """The scenario gives this port's effort when its component is the root: input `port.effort`."""
    return Open((port,), Opening.EFFORT, call_site(1))
