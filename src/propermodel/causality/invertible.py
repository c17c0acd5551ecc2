"""Whether a law can be solved for what it takes: it must rise or fall everywhere, as far as samples show.

A friction force that saturates, a dead band or a law with a hump has no inverse. A law that is flat at zero (the square
or cube of a flow) has one, but Newton's method does not find it there. Nor is an inverse assumed where tables or
signals decide, since their values come with a run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.bondgraph.parameters import parameter_values
from propermodel.diagnostics import Path
from propermodel.expressions.core import TIME, Expr, Op, SymbolKind, leaves, postorder
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import Resistive, Storage, Variable

Argument = tuple[SymbolKind, Path]

# Magnitudes at which a law is looked at, in SI: from leakage flows to pressures.
_SAMPLES = tuple(10.0**exponent for exponent in range(-12, 9))


class Inversion:
    """Which laws of a graph can be inverted, at the parameter values of the model."""

    def __init__(self, graph: BondGraph) -> None:
        self.parameters = parameter_values(graph.parameters)
        self.known: dict[Path, str] = {}

    def is_possible(self, element: Element) -> bool:
        """Whether the laws of an element can be solved for the variables that they take."""
        return not self.obstacle(element)

    def obstacle(self, element: Element) -> str:
        """What keeps the laws of an element from being inverted, as in "is flat from 1 to 10 m/s"; or nothing."""
        if element.path not in self.known:
            self.known[element.path] = self._look(element)
        return self.known[element.path]

    def _look(self, element: Element) -> str:
        behaviour = element.behaviour
        if isinstance(behaviour, Resistive):
            if behaviour.locked is not None:
                return "can lock"
            if behaviour.implicit:
                return "is implicit"
            arguments = (
                (result.value, _port_variable(element, result.port, result.variable.other))
                for law in behaviour.laws[:1]
                for result in law.results
            )
            return self._first_obstacle(arguments)
        if not isinstance(behaviour, Storage):
            return "is no law"
        if behaviour.inverse is not None:
            return ""
        states = dict(behaviour.stored)
        if any(states[port].op is not Op.SYMBOL for port, _ in behaviour.outputs):
            return "is written in other coordinates than what it stores"
        return self._first_obstacle(
            (value, (SymbolKind.STATE, states[port].data.path)) for port, value in behaviour.outputs
        )

    def _first_obstacle(self, laws: Iterable[tuple[Expr, Argument]]) -> str:
        return next(filter(None, (self._obstacle(law, argument) for law, argument in laws)), "")

    def _obstacle(self, law: Expr, argument: Argument) -> str:
        """Why a law does not rise or fall everywhere, as far as samples show."""
        leaf = next((x for x in leaves(law) if (x.data.kind, x.data.path) == argument), None)
        if leaf is None:
            return "does not depend on what it takes"
        if any(node.op in (Op.LOOKUP, Op.SLOPE) for node in postorder([law])):
            return "reads a table, whose values come with a run"
        given: dict[Expr, float] = {}
        for other in leaves(law):
            if other in self.parameters:
                given[other] = self.parameters[other]
            elif other.data.kind in (SymbolKind.SIGNAL, SymbolKind.DISCRETE, SymbolKind.TABLE) or other is TIME:
                return "changes with a signal or with time"
            else:
                given[other] = 0.0
        return _turn(lambda x: interpret(law, {**given, leaf: x}), leaf.data.unit)


def _turn(law: Callable[[float], float], unit: str) -> str:
    """Where a law is flat or turns, as far as samples show."""
    samples = [*(-x for x in reversed(_SAMPLES)), 0.0, *_SAMPLES]
    points = [(x, value) for x in samples if math.isfinite(value := law(x))]
    if len(points) <= len(_SAMPLES) + 1:
        return "has no value for most of what it may be given"
    steps = [(a, b, upper - lower) for (a, lower), (b, upper) in pairwise(points)]
    # What is nearest to zero is what a reader looks for first.
    steps.sort(key=lambda step: (abs(step[0] + step[1]), -step[0]))
    is_rising = steps[0][2] > 0.0
    for a, b, rise in steps:
        if rise == 0.0:
            return f"is flat from {a:g} to {b:g} {unit}".rstrip()
        if (rise > 0.0) is not is_rising:
            return f"turns back between {a:g} and {b:g} {unit}".rstrip()
    middle, near, far = (law(x) for x in (0.0, _SAMPLES[0], _SAMPLES[3]))
    slope, chord = (near - middle) / _SAMPLES[0], (far - middle) / _SAMPLES[3]
    return "" if abs(slope) > 0.5 * abs(chord) else "is flat at 0"


def _port_variable(element: Element, port: str, variable: Variable) -> Argument:
    kind = SymbolKind.EFFORT if variable is Variable.EFFORT else SymbolKind.FLOW
    return kind, element.path / port / variable.value
