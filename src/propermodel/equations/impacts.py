"""Impulses at events: what the impacts that happen at one instant do to the states.

An impulse acts through the effort of the element that is struck. Dependent storage takes up its share, kinematic
closures and locked resistances stay closed and locked, each by an impulse of its own. What lets go at some effort
(friction) gives way, as every finite effort does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.bondgraph.graph import Element
from propermodel.causality.causal import CausalGraph
from propermodel.diagnostics import Diagnostic, Faults, Involved, Path, StructureError
from propermodel.equations.definitions import Definitions
from propermodel.equations.events import SystemEvent
from propermodel.equations.loops import Resolution
from propermodel.equations.system import Impacts, StateKind, StateVariable
from propermodel.expressions.core import (
    ZERO,
    Expr,
    Substitution,
    SymbolKind,
    is_zero,
    leaves,
    symbol,
    where,
)
from propermodel.expressions.derivatives import partial_derivatives

_CURE = "put an inertia where it strikes, joined to it without resistance or algebraic loop"


@dataclass(frozen=True, slots=True)
class _Bearer:
    """What bears impulses: the unknown effort or flow, and the value that must keep, or follow, what it does."""

    element: Element
    unknown: Expr
    value: Expr
    is_reaction: bool = False  # of dependent storage: the impulse is the change of the value
    locked: Expr | None = None  # bears while this holds; None: always


def impacts_of(
    causal: CausalGraph,
    definitions: Definitions,
    resolution: Resolution,
    states: Sequence[StateVariable],
    events: Sequence[SystemEvent],
    finish: Callable[[Expr], Expr],
) -> Impacts | None:
    """The impulses of a model, None if none of its events has any; the states' rates are those before elimination.

    Raises:
        StructureError: an impulse acts on no state, or through an algebraic loop.
    """
    striking = [(number, event) for number, event in enumerate(events) if event.restitution is not None]
    if not striking:
        return None
    by_path = {item.element.path: item for item in (*definitions.struck, *definitions.lockables)}
    faults = Faults(StructureError)
    for _, event in striking:
        if event.element not in by_path:
            faults.add(_fault(causal, event, "acts on no state: something else gives its effort"))
    faults.raise_if_any()
    locks = _locks(causal, definitions, resolution)
    struck = {
        event.element: _Bearer(
            item.element, item.unknown, resolution.complete(item.flow), locked=locks.get(event.element)
        )
        for _, event in striking
        if (item := by_path[event.element])
    }
    web = _Web(definitions, resolution, states)
    others = [
        *_answers(definitions, resolution),
        *(
            _Bearer(item.element, item.unknown, resolution.complete(item.flow), locked=locks[item.element.path])
            for item in definitions.lockables
            if item.element.path in locks and item.element.path not in struck
        ),
    ]
    bearers = web.reached([*struck.values()], others)
    for _, event in striking:
        problem = web.problem(struck[event.element], bearers)
        if problem:
            faults.add(_fault(causal, event, problem))
    faults.raise_if_any()
    return _impacts(striking, struck, bearers, web, finish)


def _answers(definitions: Definitions, resolution: Resolution) -> list[_Bearer]:
    """Dependent storage and kinematic closures."""
    found = [
        _Bearer(item.element, item.unknown, resolution.complete(item.stored), is_reaction=True)
        for item in definitions.dependents
    ]
    found += [
        _Bearer(item.element, item.unknown, resolution.complete(item.flow - item.prescribed))
        for item in definitions.held
    ]
    return found


def _locks(causal: CausalGraph, definitions: Definitions, resolution: Resolution) -> Mapping[Path, Expr]:
    """When each lock bears impulses; one that lets go at some effort never does."""
    found: dict[Path, Expr] = {}
    for item in definitions.lockables:
        path, locked = item.element.path, resolution.complete(item.locked)
        conditions = [resolution.complete(event.condition) for event in causal.graph.events if event.element == path]
        if item.unknown not in leaves(locked, *conditions):
            found[path] = locked
    return found


class _Web:
    """Which states each impulse changes, and which algebraic unknowns would follow it."""

    def __init__(self, definitions: Definitions, resolution: Resolution, states: Sequence[StateVariable]) -> None:
        self.states = states
        self.algebraic: Mapping[Expr, frozenset[Expr]] = {
            **{unknown: frozenset(leaves(resolution.torn_value(unknown))) for unknown in resolution.torn},
            **{item.unknown: frozenset(leaves(resolution.complete(item.residual))) for item in definitions.implied},
        }
        self.slopes: dict[Expr, dict[Expr, Expr]] = {}  # of the unknown: state, slope of its rate

    def reached(self, struck: list[_Bearer], others: list[_Bearer]) -> list[_Bearer]:
        """The elements that are struck and all that bears what reaches them."""
        everything = [*struck, *others]
        unknowns = [item.unknown for item in everything]
        rates = partial_derivatives([state.derivative for state in self.states], unknowns)
        for unknown in unknowns:
            self.slopes[unknown] = {
                state.symbol: rate[unknown]
                for state, rate in zip(self.states, rates, strict=True)
                if unknown in rate and not is_zero(rate[unknown])
            }
        found, left = struck, others
        while True:
            moved = {state for item in found for state in self.slopes[item.unknown]}
            reached = [item for item in left if moved.intersection(leaves(item.value))]
            if not reached:
                return found
            found = [*found, *reached]
            left = [item for item in left if item not in reached]

    def problem(self, item: _Bearer, bearers: Sequence[_Bearer]) -> str:
        """Why an impulse cannot be followed; empty if it can."""
        moved = {state for bearer in bearers for state in self.slopes[bearer.unknown]}
        unknowns = {bearer.unknown for bearer in bearers}
        following = self._following(unknowns | moved)
        if not moved.intersection(self.slopes[item.unknown]):
            return "acts on no state"
        if not moved.intersection(leaves(item.value)):
            return "does not change its flow"
        for bearer in bearers:
            if any(leaf in following or leaf in unknowns for leaf in leaves(bearer.value)):
                return f"reaches {bearer.element.path} through an algebraic loop"
        endless = self._following(unknowns)
        for state in self.states:
            if state.kind is not StateKind.SIGNAL and endless.intersection(leaves(state.derivative)):
                return f"reaches {state.path} through an algebraic loop"
            for bearer in bearers:
                slope = self.slopes[bearer.unknown].get(state.symbol, ZERO)
                if state.kind is not StateKind.SIGNAL and unknowns.intersection(leaves(slope)):
                    return f"changes {state.path} by more than in proportion"
        return ""

    def _following(self, causes: set[Expr]) -> frozenset[Expr]:
        """The algebraic unknowns that depend on any of these."""
        found: set[Expr] = set()
        while True:
            more = {u for u, inside in self.algebraic.items() if u not in found and inside & (causes | found)}
            if not more:
                return frozenset(found)
            found |= more


def _impacts(
    striking: Sequence[tuple[int, SystemEvent]],
    struck: Mapping[Path, _Bearer],
    bearers: Sequence[_Bearer],
    web: _Web,
    finish: Callable[[Expr], Expr],
) -> Impacts:
    flags = {number: symbol(SymbolKind.UNKNOWN, event.element / f"impact_{number}", "") for number, event in striking}
    inside = {bearer.unknown for bearer in bearers}
    impulse = {
        bearer.unknown: symbol(SymbolKind.UNKNOWN, bearer.element.path / f"impact_impulse_{k}", "")
        for k, bearer in enumerate(bearers)
    }
    updates: dict[Expr, Expr] = {}
    for bearer in bearers:
        for state, slope in web.slopes[bearer.unknown].items():
            # A signal that is not in proportion to an effort has no finite answer to an impulse of it.
            if not inside.intersection(leaves(slope)):
                updates[state] = updates.get(state, state) + finish(slope) * impulse[bearer.unknown]
    moved = Substitution(updates)
    residuals: list[Expr] = []
    losses: dict[int, Expr] = {}
    for bearer in bearers:
        own, value = impulse[bearer.unknown], finish(bearer.value)
        change = moved(value) - value
        if bearer.is_reaction:
            residual = own - change
        elif struck.get(bearer.element.path) is not bearer:
            residual = change if bearer.locked is None else where(finish(bearer.locked), change, own)
        else:
            residual = own if bearer.locked is None else where(finish(bearer.locked), change, own)
            for number, event in striking:
                if event.element == bearer.element.path and event.restitution is not None:
                    is_struck = flags[number] > 0.5
                    residual = where(is_struck, moved(value) + event.restitution * value, residual)
                    losses[number] = where(is_struck, 0.5 * own * (value + moved(value)), ZERO)
        residuals.append(residual)
    unknowns = tuple(impulse.values())
    partials = partial_derivatives(residuals, unknowns)
    return Impacts(
        flags=tuple(flags.items()),
        unknowns=unknowns,
        residuals=tuple(residuals),
        jacobian=tuple(tuple(p.get(unknown, ZERO) for unknown in unknowns) for p in partials),
        updates=tuple(updates.items()),
        losses=tuple(losses[number] for number in flags),
        paths=tuple(bearer.element.path for bearer in bearers),
    )


def _fault(causal: CausalGraph, event: SystemEvent, problem: str) -> Diagnostic:
    element = causal.graph.normal.elements[event.element]
    return Diagnostic(
        "equations/impulse",
        f"the impulse of {event.element} {problem}",
        source=event.source,
        involved=(Involved(str(event.element), "is struck", element.source),),
        help=_CURE,
    )
