"""Events: what an element or signal block changes at the instant at which a condition becomes true."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from propermodel.diagnostics import Diagnostic, Involved, ModelError, Path, Source
from propermodel.expressions.core import Expr, ExprLike, Op, SymbolKind, symbol
from propermodel.modelling.elements import ELEMENTS, Compliance, Inertia, Resistance
from propermodel.modelling.model import Event
from propermodel.modelling.references import call_site
from propermodel.modelling.signals import Controller, Discrete, SignalBlock
from propermodel.modelling.tracing import Tracer

_STORED = {SymbolKind.DISPLACEMENT: Compliance, SymbolKind.MOMENTUM: Inertia}


@dataclass(frozen=True, slots=True)
class When:
    """An event as its author writes it."""

    condition: Expr
    changes: Mapping[Expr, ExprLike]
    restitution: ExprLike | None
    source: Source


def when(
    condition: Expr, changes: Mapping[Expr, ExprLike] | None = None, *, restitution: ExprLike | None = None
) -> When:
    """What changes at the instant at which `condition` becomes true; `events()` of a class returns these.

    An event happens when its condition becomes true, and at the start of a run if it is true then; it can happen
    anew only after the condition has been false. Every value is that from before the event.

    Args:
        condition: A condition of port variables, states, discrete values, inputs, parameters and time.
        changes: The value afterwards of own discrete values, own states, and the own stored displacement or momentum.
        restitution: Of a resistance with one port: an impulse of its effort makes its flow -restitution * flow, and
            everything that moves with it jumps; 0 stops it dead (Newton's law of restitution).
    """
    return When(condition, {} if changes is None else changes, restitution, call_site(1))


def discretes_of(tracer: Tracer) -> tuple[tuple[str, str, Expr], ...]:
    """The discrete values of an element or signal block: name, unit, start."""
    if issubclass(tracer.cls, Controller):
        return ()
    return tuple(
        (name, declared.unit, tracer.resolve(declared.start))
        for name, declared in tracer.cls.declarations.items()
        if isinstance(declared, Discrete)
    )


def events_of(tracer: Tracer) -> tuple[Event, ...]:
    """The events of an element or signal block.

    Raises:
        ModelError: an event is not made by `when`, or changes what is not its own.
    """
    if not tracer.has("events"):
        return ()
    if not issubclass(tracer.cls, (*ELEMENTS, SignalBlock)):
        raise _refused(tracer, "has events, but only an element or a signal block can", "move them to an element")
    given = tracer.call("events")
    if not isinstance(given, Iterable):
        raise _refused(tracer, "must return its events as a sequence", "return (when(condition, {...}),)")
    events = tuple(_event(tracer, item) for item in cast("Iterable[Any]", given))
    tracer.faults.raise_if_any()
    return events


def _event(tracer: Tracer, item: Any) -> Event:
    if not isinstance(item, When) or not isinstance(cast("Any", item.condition), Expr):
        raise _refused(tracer, "returns something other than when(condition, {...})", "return (when(...),)")
    if not item.condition.is_condition:
        raise _refused(
            tracer, "has an event whose condition is a number", "compare: when(self.port.flow < 0.0, ...)", item.source
        )
    if not item.changes and item.restitution is None:
        raise _refused(tracer, "has an event that changes nothing", "give it a mapping of new values", item.source)
    condition = tracer.resolve(item.condition)
    tracer.check(condition, "", "events")
    changes: list[tuple[Expr, Expr]] = []
    for key, value in item.changes.items():
        target = _target(tracer, key, item.source)
        new = tracer.resolve(value)
        tracer.check(new, target.data.unit, "events")
        changes.append((target, new))
    return Event(
        condition=condition, changes=tuple(changes), restitution=_restitution(tracer, item), source=item.source
    )


def _restitution(tracer: Tracer, item: When) -> Expr | None:
    if item.restitution is None:
        return None
    if not issubclass(tracer.cls, Resistance):
        raise _refused(
            tracer,
            "has an event with a restitution, but it is no resistance with one port",
            "let a Resistance between both sides have the event, or change the momentum: {self.port.momentum: ...}",
            item.source,
        )
    value = tracer.resolve(item.restitution)
    tracer.check(value, "1", "events")
    return value


def _target(tracer: Tracer, key: Expr, source: Source) -> Expr:
    """The symbol of what an event changes; what a storage holds is named by its port and meant as its state."""
    if key.op is Op.SYMBOL:
        found = tracer.local(key)
        kind, path = found.data.kind, found.data.path
        if kind in (SymbolKind.STATE, SymbolKind.DISCRETE) and len(path) == 1:
            return found
        if kind in _STORED and issubclass(tracer.cls, _STORED[kind]) and path.parent.name in tracer.element_ports:
            return symbol(SymbolKind.STATE, Path((kind.value,)), found.data.unit)
    raise _refused(
        tracer,
        f"has an event that changes {key!r}, which is no state or discrete value of its own",
        "an event changes own Discrete values, own States, and what a storage holds (self.port.momentum)",
        source,
    )


def _refused(tracer: Tracer, problem: str, cure: str, source: Source | None = None) -> ModelError:
    name = tracer.cls.__name__
    place = source or tracer.place("events")
    return ModelError(
        [
            Diagnostic(
                "model/event",
                f"{name}.events {problem}" if problem.startswith(("must", "returns")) else f"{name} {problem}",
                source=place,
                involved=(Involved(name, "is declared here", tracer.cls.defined_at),),
                help=cure,
            )
        ]
    )


__all__ = ["When", "discretes_of", "events_of", "when"]
