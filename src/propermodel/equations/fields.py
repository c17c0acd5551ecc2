"""Fields in derivative causality at some or all ports: what decides their coordinates, and the rates of the others.

At a port in derivative causality the output (the effort of a compliance) is given, and a coordinate follows from it:
openly where the laws are linear in these coordinates, otherwise as the solution of the laws. The field answers with
the rate of what the port stores.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from propermodel.bondgraph.graph import Element
from propermodel.causality.causal import CausalGraph
from propermodel.causality.fields import Mixed, mixed
from propermodel.equations.solve import eliminate
from propermodel.expressions.core import ZERO, Expr, Substitution, SymbolKind, leaves, symbol
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.modelling.model import Coordinate, ElementKind, Storage


@dataclass(frozen=True, slots=True)
class Decided:
    """The coordinates that given outputs decide: as expressions, or as unknowns with the residuals they solve."""

    values: Mapping[Expr, Expr]
    unknowns: tuple[tuple[Expr, Expr], ...]


def causality_of(causal: CausalGraph, element: Element) -> Mixed | None:
    """The causality of a storage by port; None where it is a state at every port."""
    is_c = element.kind is ElementKind.COMPLIANCE
    bonds = causal.graph.normal.bonds
    derivative = tuple(
        port for port in element.ports if causal.receives_effort(bonds[element.path / port], element) is is_c
    )
    if not derivative:
        return None
    storage = element.behaviour
    assert isinstance(storage, Storage)
    if len(element.ports) == 1:
        return Mixed(integral=(), derivative=tuple(zip(element.ports, storage.coordinates, strict=True)))
    found = mixed(element, derivative)
    assert found is not None
    return found


def state_symbol(element: Element, coordinate: Coordinate) -> Expr:
    """The symbol of a coordinate."""
    return symbol(SymbolKind.STATE, element.path / coordinate.name, coordinate.unit)


def decide(element: Element, storage: Storage, causality: Mixed, given: Mapping[str, Expr]) -> Decided:
    """What the outputs given at the ports in derivative causality make of their coordinates."""
    outputs = dict(storage.outputs)
    targets = [state_symbol(element, coordinate) for _, coordinate in causality.derivative]
    residuals = [outputs[port] - given[port] for port, _ in causality.derivative]
    partials = partial_derivatives(residuals, targets)
    matrix = [[p.get(target, ZERO) for target in targets] for p in partials]
    if not any(leaf in targets for row in matrix for entry in row for leaf in leaves(entry)):
        at_zero = Substitution(dict.fromkeys(targets, ZERO))
        values = eliminate(matrix, [-at_zero(r) for r in residuals], [element.path] * len(targets))
        return Decided(dict(zip(targets, values, strict=True)), ())
    unknowns = [symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit) for target in targets]
    return Decided(dict(zip(targets, unknowns, strict=True)), tuple(zip(unknowns, residuals, strict=True)))


def is_coordinate(element: Element, storage: Storage, port: str, coordinate: Coordinate) -> bool:
    """Whether a port stores one of the coordinates itself."""
    return dict(storage.stored)[port] == state_symbol(element, coordinate)
