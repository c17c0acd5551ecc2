"""Storage with several ports of which some are decided elsewhere: what it keeps as state, and what follows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

from propermodel.bondgraph.graph import Element
from propermodel.causality.graph_algorithms import match_each
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, leaves
from propermodel.modelling.model import Coordinate, Storage

# A field with more ports than this is a state at all its ports or at none.
MOST_PORTS = 8


@dataclass(frozen=True, slots=True)
class Mixed:
    """The ports of a field by causality, each with the coordinate that it keeps (integral) or decides (derivative)."""

    integral: tuple[tuple[str, Coordinate], ...]
    derivative: tuple[tuple[str, Coordinate], ...]


def field_causalities(element: Element) -> Iterator[tuple[str, ...]]:
    """The ports of a field that may be in derivative causality together, fewest first; at least one."""
    ports = element.ports
    sizes = range(1, len(ports) + 1) if len(ports) <= MOST_PORTS else (len(ports),)
    for size in sizes:
        for derivative in combinations(ports, size):
            if mixed(element, derivative) is not None:
                yield derivative


def mixed(element: Element, derivative: tuple[str, ...]) -> Mixed | None:
    """Which coordinate belongs to which port when these are in derivative causality; None where structure forbids it.

    A port in integral causality needs a coordinate that its stored quantity depends on, one in derivative causality a
    coordinate that its output depends on. Where coordinates are the stored quantities, every port has its own.
    """
    storage = element.behaviour
    assert isinstance(storage, Storage)
    stored, outputs = dict(storage.stored), dict(storage.outputs)
    own = _own_coordinates(element, storage)
    used = [_mentioned(outputs[p] if p in derivative else stored[p]) for p in element.ports]
    names = [element.path / c.name for c in storage.coordinates]
    chosen = [own.get(port, -1) for port in element.ports]
    if any(index < 0 or names[index] not in found for index, found in zip(chosen, used, strict=True)):
        chosen = match_each([[k for k, name in enumerate(names) if name in found] for found in used])
    if chosen is None:
        return None
    pairs = [(port, storage.coordinates[index]) for port, index in zip(element.ports, chosen, strict=True)]
    return Mixed(
        integral=tuple(pair for pair in pairs if pair[0] not in derivative),
        derivative=tuple(pair for pair in pairs if pair[0] in derivative),
    )


def _own_coordinates(element: Element, storage: Storage) -> Mapping[str, int]:
    """The coordinate that is the stored quantity of a port, by port."""
    names = {element.path / c.name: index for index, c in enumerate(storage.coordinates)}
    return {
        port: names[expr.data.path]
        for port, expr in storage.stored
        if not expr.args and getattr(expr.data, "path", None) in names
    }


def _mentioned(expr: Expr) -> set[Path]:
    return {leaf.data.path for leaf in leaves(expr)}
