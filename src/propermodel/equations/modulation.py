"""Modulated storage: whoever changes its law from outside (a gap, a length, a volume) works on its energy."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from propermodel.bondgraph.graph import Element
from propermodel.causality.causal import CausalGraph
from propermodel.equations.fields import state_symbol
from propermodel.equations.system import Modulation, StateVariable
from propermodel.expressions.core import ONE, TIME, ZERO, Expr, SymbolKind, is_zero, leaves
from propermodel.expressions.derivatives import directional_derivative, partial_derivatives
from propermodel.modelling.model import Storage

_FIXED = frozenset({SymbolKind.PARAMETER, SymbolKind.TABLE})


def modulations_of(
    causal: CausalGraph, states: Iterable[StateVariable], complete: Callable[[Expr], Expr]
) -> tuple[Modulation, ...]:
    """The powers that signals and time bring into storage, along the solution.

    A storage whose signals come from an implicit block has none: what it takes then shows as a residual of a balance.

    Args:
        causal: The causal graph.
        states: The states with their rates.
        complete: Gives an expression of states, held values, parameters, time and unknowns for one of any symbols.
    """
    rates = {state.symbol: state.derivative for state in states} | {TIME: ONE}
    found: list[Modulation] = []
    for element in causal.graph.normal.elements.values():
        if isinstance(element.behaviour, Storage):
            power = _power(element, element.behaviour, rates, complete)
            if not is_zero(power):
                found.append(Modulation(element.path, power))
    return tuple(found)


def _power(element: Element, storage: Storage, rates: dict[Expr, Expr], complete: Callable[[Expr], Expr]) -> Expr:
    """The sum of what the energy changes with each symbol that is not its own, times the rate of that symbol."""
    own = {state_symbol(element, coordinate) for coordinate in storage.coordinates}
    outside = [leaf for leaf in leaves(storage.energy) if leaf not in own and leaf.data.kind not in _FIXED]
    values = [complete(leaf) for leaf in outside]
    if any(leaf.data.kind is SymbolKind.UNKNOWN for leaf in leaves(*values)):
        return ZERO
    changes = directional_derivative(values, {leaf: rates.get(leaf, ZERO) for leaf in leaves(*values)})
    (slopes,) = partial_derivatives([storage.energy], outside)
    power = ZERO
    for leaf, change in zip(outside, changes, strict=True):
        power = power + complete(slopes.get(leaf, ZERO)) * change
    return power
