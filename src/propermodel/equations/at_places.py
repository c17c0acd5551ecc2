"""What definitions at a junction and at an element share: signs, sums, the bond at a port, laws that lock."""

from __future__ import annotations

from collections.abc import Iterable

from propermodel.bondgraph.graph import Bond, Element, End
from propermodel.diagnostics import Path
from propermodel.expressions.core import ZERO, Expr, where
from propermodel.modelling.model import Resistive, Result, Variable


def sign_at(bond: Bond, place: Path) -> bool:
    """Whether the half arrow points into this junction or element."""
    return bond.head.owner == place


def sum_of_others(terms: Iterable[tuple[Expr, bool]], into: bool) -> Expr:
    """The term that makes a signed sum vanish; `into` is the sense of the missing term."""
    total = ZERO
    for term, points_in in terms:
        total = total - term if points_in is into else total + term
    return total


def bond_at(bonds: list[Bond], element: Element, port: str) -> Bond | None:
    """The bond at a port of an element; None where there is none."""
    wanted = End(element.path, port)
    return next((b for b in bonds if wanted in (b.tail, b.head)), None)


def held_when_locked(behaviour: Resistive, result: Result) -> Expr:
    """What a law gives; a flow that it gives is zero while the element is locked."""
    if behaviour.locked is None or result.variable is Variable.EFFORT:
        return result.value
    return where(behaviour.locked, ZERO, result.value)
