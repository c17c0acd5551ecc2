"""Implicit laws of resistances: which variables they can give, and which part is solved for which variable."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from propermodel.bondgraph.graph import Element
from propermodel.causality.graph_algorithms import match_each
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, leaves
from propermodel.modelling.model import Resistive, Variable

# An implicit law with more ports than this is offered in the causalities of its explicit laws only.
MOST_PORTS = 10

Given = tuple[tuple[str, Variable], ...]  # per port: the variable that the element gives


def implicit_causalities(element: Element) -> Iterator[Given]:
    """What the implicit law of a resistance can give at its ports, by structure; flows and efforts alike."""
    behaviour = element.behaviour
    if not isinstance(behaviour, Resistive) or not behaviour.implicit or len(element.ports) > MOST_PORTS:
        return
    explicit = {tuple((r.port, r.variable) for r in law.results) for law in behaviour.laws}
    for variables in product((Variable.EFFORT, Variable.FLOW), repeat=len(element.ports)):
        given = tuple(zip(element.ports, variables, strict=True))
        if given not in explicit and pair(element, behaviour, given) is not None:
            yield given


def pair(element: Element, behaviour: Resistive, given: Given) -> tuple[Expr, ...] | None:
    """For every port the part of the implicit law that is solved for what it gives; None where structure forbids it."""
    mentions = [{leaf.data.path for leaf in leaves(residual)} for residual in behaviour.implicit]
    wanted: list[Path] = [element.path / port / variable.value for port, variable in given]
    chosen = match_each([[k for k, found in enumerate(mentions) if path in found] for path in wanted])
    return None if chosen is None else tuple(behaviour.implicit[k] for k in chosen)
