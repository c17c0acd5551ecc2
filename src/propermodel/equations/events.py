"""Events of the equation system: conditions as numbers whose sign tells, changes in terms of states and held values."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from propermodel.bondgraph.graph import FlatEvent
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Faults, Involved, Path, Source, StructureError
from propermodel.expressions.core import ONE, Expr, Op, SymbolKind, constant, maximum, minimum, postorder, where

_TINY = constant(1e-300)  # what makes the guard of "<=" positive where both sides are equal


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemEvent:
    """An event: it happens when its guard becomes positive; then states and held values get new values.

    With a `restitution`, an impulse of the element's effort makes its flow -restitution * flow.
    """

    element: Path
    guard: Expr
    changes: tuple[tuple[Expr, Expr], ...]  # symbol of a state or held value, its value afterwards
    restitution: Expr | None = None
    source: Source = field(default=NO_SOURCE, compare=False)


def guard_of(condition: Expr) -> Expr:
    """A number that is positive exactly where the condition holds, continuous where the sides of comparisons are."""
    guards: dict[Expr, tuple[Expr, Expr]] = {}  # of the condition, of its contrary
    for node in postorder([condition]):
        if not node.is_condition:
            continue
        a, b = node.args[0], node.args[-1]
        match node.op:
            case Op.LESS:
                guards[node] = (b - a, _at_least(a, b))
            case Op.LESS_EQUAL:
                guards[node] = (_at_least(b, a), a - b)
            case Op.AND:
                guards[node] = (minimum(guards[a][0], guards[b][0]), maximum(guards[a][1], guards[b][1]))
            case Op.OR:
                guards[node] = (maximum(guards[a][0], guards[b][0]), minimum(guards[a][1], guards[b][1]))
            case Op.NOT:
                guards[node] = (guards[a][1], guards[a][0])
            case _:
                guards[node] = (where(node, ONE, -ONE), where(node, -ONE, ONE))
    return guards[condition][0]


def _at_least(a: Expr, b: Expr) -> Expr:
    return where(b <= a, maximum(a - b, _TINY), a - b)


def system_events(
    events: Iterable[FlatEvent], states: Iterable[Expr], resolved: Callable[[Expr], Expr]
) -> tuple[SystemEvent, ...]:
    """The events of a graph, with everything that is defined resolved.

    Raises:
        StructureError: an event changes what a dependent storage holds, which follows from other states.
    """
    independent = set(states)
    faults = Faults(StructureError)
    found: list[SystemEvent] = []
    for event in events:
        for target, _ in event.changes:
            if target.data.kind is SymbolKind.STATE and target not in independent:
                faults.add(
                    Diagnostic(
                        "equations/event",
                        f"an event changes {target.data.path}, which is no state: its storage is dependent",
                        source=event.source,
                        involved=(Involved(str(event.element), "is dependent storage", event.source),),
                        help="change the state of the storage that it depends on, or put a compliance in between",
                    )
                )
        found.append(
            SystemEvent(
                element=event.element,
                guard=resolved(guard_of(event.condition)),
                changes=tuple((target, resolved(value)) for target, value in event.changes),
                restitution=None if event.restitution is None else resolved(event.restitution),
                source=event.source,
            )
        )
    faults.raise_if_any()
    return tuple(found)
