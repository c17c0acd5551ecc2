"""Fields whose laws determine nothing with the parameters of a run: two coils that share all their flux.

Structure cannot see this, as it depends on numbers. A law is tested at the start: where its slopes are not finite, or
change completely when parameters change by a ten-billionth, it divides by a number that rounding alone keeps from
zero; where a field must give coordinates, the matrix of their slopes must have full rank.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from propermodel.bondgraph.graph import Element
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Diagnostic, Path
from propermodel.equations.fields import causality_of, state_symbol
from propermodel.equations.system import EquationSystem
from propermodel.expressions.core import ZERO, Expr, SymbolKind, leaves
from propermodel.expressions.derivatives import kept_derivatives
from propermodel.modelling.model import Storage
from propermodel.simulation.evaluate import HeldTable, evaluate, has_all

NUDGE = 1e-10  # relative change of parameters
ROBUST = 1e-3  # largest relative change of a slope that it may make
RANK = 1e-9  # smallest singular value of a balanced matrix that counts as full rank


def singular_fields(
    system: EquationSystem, values: Mapping[Expr, float], tables: Mapping[Path, HeldTable]
) -> Iterable[Diagnostic]:
    """A fault for every field that its parameters make singular at these values of states and parameters."""
    for element in system.causal.graph.normal.elements.values():
        storage = element.behaviour
        if len(element.ports) < 2 or not isinstance(storage, Storage):
            continue
        laws = [expr for _, expr in (*storage.stored, *storage.outputs)]
        if not all(has_all(expr, values, tables) for expr in laws):
            continue
        if not _is_regular(system, element, storage, values, tables):
            yield _singular(element, laws, values)


def _is_regular(
    system: EquationSystem,
    element: Element,
    storage: Storage,
    values: Mapping[Expr, float],
    tables: Mapping[Path, HeldTable],
) -> bool:
    states = [state_symbol(element, coordinate) for coordinate in storage.coordinates]
    ports = [port for port, _ in storage.stored]
    laws = [*dict(storage.stored).values(), *(dict(storage.outputs)[port] for port in ports)]
    slopes = [p.get(state, ZERO) for p in kept_derivatives(tuple(laws), tuple(states)) for state in states]
    parameters = [leaf for leaf in leaves(*slopes) if leaf.data.kind is SymbolKind.PARAMETER]
    nudged = {p: values[p] * (1.0 + NUDGE * np.cos(1.0 + 2.0 * i)) for i, p in enumerate(parameters)}
    found = np.array(evaluate(slopes, values, tables))
    other = np.array(evaluate(slopes, {**values, **nudged}, tables))
    if not np.all(np.isfinite(found)) or np.any(np.abs(other - found) > ROBUST * np.abs(found)):
        return False
    stored, outputs = found.reshape(2, len(ports), len(states))
    causality = causality_of(system.causal, element)
    if causality is None:
        return _has_full_rank(stored)
    index = {coordinate.name: i for i, coordinate in enumerate(storage.coordinates)}

    def part(matrix: FloatArray, pairs: Sequence[tuple[str, object]]) -> FloatArray:
        rows = [ports.index(port) for port, _ in pairs]
        columns = [index[getattr(coordinate, "name", "")] for _, coordinate in pairs]
        return matrix[np.ix_(rows, columns)]

    return _has_full_rank(part(stored, causality.integral)) and _has_full_rank(part(outputs, causality.derivative))


def _has_full_rank(matrix: FloatArray) -> bool:
    """Whether a square matrix has full rank once its rows and columns are of one size."""
    if not matrix.size:
        return True
    for _ in range(3):
        for axis in (1, 0):
            size = np.max(np.abs(matrix), axis=axis, keepdims=True)
            if np.any(size == 0.0):
                return False
            matrix = matrix / np.sqrt(size)
    return float(np.linalg.svd(matrix, compute_uv=False)[-1]) > RANK


def _singular(element: Element, laws: list[Expr], values: Mapping[Expr, float]) -> Diagnostic:
    parameters = [leaf for leaf in leaves(*laws) if leaf.data.kind is SymbolKind.PARAMETER]
    parameters.sort(key=lambda leaf: leaf.data.path)
    numbers = ", ".join(f"{p.data.path.name} = {values[p]:.6g} {p.data.unit}".rstrip() for p in parameters)
    return Diagnostic(
        "simulation/singular-field",
        f"the field {element.path} does not determine what its ports {' and '.join(element.ports)} do: its law is "
        f"singular with {numbers or 'these states'}",
        source=element.source,
        help="ports without a storage of their own are one storage and a transformer: use these, or couple less",
    )
