"""Whether a law can be solved for what it takes: it must rise or fall everywhere, as far as samples show.

A friction force that saturates, a dead band or a law with a hump has no inverse. A law that is flat at zero (the square
or cube of a flow) has one, but Newton's method does not find it there. Nor is an inverse assumed where tables or
signals decide, since their values come with a run.
"""

from __future__ import annotations

import math
from itertools import pairwise

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.diagnostics import Path
from propermodel.expressions.core import TIME, Expr, Op, SymbolKind, leaves, postorder
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import Resistive, Storage, Variable

# Magnitudes at which a law is looked at, in SI: from leakage flows to pressures.
_SAMPLES = tuple(10.0**exponent for exponent in range(-12, 9))


class Inversion:
    """Which laws of a graph can be inverted, at the parameter values of the model."""

    def __init__(self, graph: BondGraph) -> None:
        self.parameters = _parameter_values(graph)
        self.known: dict[Path, bool] = {}

    def is_possible(self, element: Element) -> bool:
        """Whether the laws of an element can be solved for the variables that they take."""
        if element.path not in self.known:
            self.known[element.path] = self._look(element)
        return self.known[element.path]

    def _look(self, element: Element) -> bool:
        behaviour = element.behaviour
        if isinstance(behaviour, Resistive):
            return (
                behaviour.locked is None
                and not behaviour.implicit
                and all(
                    self._is_monotone(result.value, _port_variable(element, result.port, result.variable.other))
                    for law in behaviour.laws[:1]
                    for result in law.results
                )
            )
        if not isinstance(behaviour, Storage):
            return False
        states = dict(behaviour.stored)
        return behaviour.inverse is not None or all(
            states[port].op is Op.SYMBOL and self._is_monotone(value, (SymbolKind.STATE, states[port].data.path))
            for port, value in behaviour.outputs
        )

    def _is_monotone(self, law: Expr, argument: tuple[SymbolKind, Path]) -> bool:
        leaf = next((x for x in leaves(law) if (x.data.kind, x.data.path) == argument), None)
        if leaf is None or any(node.op in (Op.LOOKUP, Op.SLOPE) for node in postorder([law])):
            return False
        given: dict[Expr, float] = {}
        for other in leaves(law):
            if other in self.parameters:
                given[other] = self.parameters[other]
            elif other.data.kind in (SymbolKind.SIGNAL, SymbolKind.DISCRETE, SymbolKind.TABLE) or other is TIME:
                return False
            else:
                given[other] = 0.0
        samples = [*(-x for x in reversed(_SAMPLES)), 0.0, *_SAMPLES]
        values = [value for x in samples if math.isfinite(value := interpret(law, {**given, leaf: x}))]
        rises = [b - a for a, b in pairwise(values)]
        if len(rises) <= len(_SAMPLES) or not (all(x > 0.0 for x in rises) or all(x < 0.0 for x in rises)):
            return False
        middle, near, far = (interpret(law, {**given, leaf: x}) for x in (0.0, _SAMPLES[0], _SAMPLES[3]))
        slope, chord = (near - middle) / _SAMPLES[0], (far - middle) / _SAMPLES[3]
        return abs(slope) > 0.5 * abs(chord)


def _port_variable(element: Element, port: str, variable: Variable) -> tuple[SymbolKind, Path]:
    kind = SymbolKind.EFFORT if variable is Variable.EFFORT else SymbolKind.FLOW
    return kind, element.path / port / variable.value


def _parameter_values(graph: BondGraph) -> dict[Expr, float]:
    """The values of parameters, as far as they follow from each other."""
    found: dict[Expr, float] = {}
    pending = list(graph.parameters.values())
    while pending:
        ready = [p for p in pending if all(leaf in found for leaf in leaves(p.value))]
        if not ready:
            break
        found.update((p.symbol, interpret(p.value, found)) for p in ready)
        pending = [p for p in pending if p.symbol not in found]
    return found
