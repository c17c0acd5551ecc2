"""Signals that came from removed parts keep their mean."""

from __future__ import annotations

from collections.abc import Iterable

from propermodel.bondgraph.flatten import flatten
from propermodel.causality.causal import CausalGraph
from propermodel.causality.complete import complete_causality
from propermodel.diagnostics import Path
from propermodel.equations.definitions import define
from propermodel.expressions.core import Expr, SymbolKind, leaves
from propermodel.modelling.model import Freeze, Removal
from propermodel.reduction.evidence import RunEvidence

# What a signal can read of an element.
OBSERVED = frozenset(
    {
        SymbolKind.EFFORT,
        SymbolKind.FLOW,
        SymbolKind.POWER,
        SymbolKind.DISPLACEMENT,
        SymbolKind.MOMENTUM,
        SymbolKind.STATE,
    }
)


def signals_to_freeze(evidence: RunEvidence, removals: Iterable[Removal]) -> tuple[Freeze, ...]:
    """Inputs that read a removed element and still matter to what is left, at the mean of the runs."""
    removals = tuple(removals)
    full = evidence.compiled.graph
    reduced = flatten(evidence.compiled.model.without(removals))
    gone = set(full.normal.elements) - set(reduced.normal.elements)
    needed = _needed_signals(complete_causality(reduced))
    found: list[Freeze] = []
    for signal in needed:
        value = full.signals[signal]
        if any(_reads(leaf, gone) for leaf in leaves(value)):
            path: Path = signal.data.path
            if evidence.is_recorded(path):
                found.append(Freeze(path, evidence.mean_signal(path)))
    return tuple(found)


def _reads(leaf: Expr, gone: set[Path]) -> bool:
    data = leaf.data
    if data.kind not in OBSERVED:
        return False
    path: Path = data.path
    return any(Path(path[:length]) in gone for length in range(1, len(path)))


def _needed_signals(causal: CausalGraph) -> list[Expr]:
    """The signals that laws, controllers and outputs of the reduced model use."""
    definitions = define(causal)
    graph = causal.graph
    bonds = set(graph.normal.bonds)
    starts: list[Expr] = [s.derivative for s in graph.signal_states]
    starts += [value for c in graph.controllers for _, value in c.updates]
    starts += [expr for e in graph.events for expr in (e.condition, *(value for _, value in e.changes))]
    starts += [e.restitution for e in graph.events if e.restitution is not None]
    starts += [
        value
        for target, value in definitions.values.items()
        if target.data.kind in (SymbolKind.EFFORT, SymbolKind.FLOW) and target.data.path.parent in bonds
    ]
    needed: dict[Expr, None] = {}
    pending = starts
    while pending:
        for leaf in leaves(pending.pop()):
            if leaf.data.kind is SymbolKind.SIGNAL and leaf not in needed and leaf in graph.signals:
                needed[leaf] = None
                pending.append(graph.signals[leaf])
    return list(needed)
