"""Causality for any graph that can have one, and all reasons where it cannot."""

from __future__ import annotations

from propermodel.bondgraph.graph import BondGraph
from propermodel.bondgraph.parameters import parameter_values
from propermodel.causality.assign import assign_causality
from propermodel.causality.causal import CausalGraph
from propermodel.causality.completion import assign_beyond_laws
from propermodel.causality.faults import causal_faults
from propermodel.causality.transformer_loops import redundant_loops, transformer_loops
from propermodel.diagnostics import Faults, StructureError


def complete_causality(graph: BondGraph) -> CausalGraph:
    """The strokes of sequential assignment, or where it meets a contradiction, strokes beyond the laws offered.

    Raises:
        StructureError: there are no strokes at all, or two-ports in a ring repeat each other; with every fault found.
    """
    faults = Faults(StructureError)
    if loops := transformer_loops(graph.normal):
        faults.found.extend(redundant_loops(graph, loops, parameter_values(graph.parameters)))
    found: CausalGraph | None = None
    try:
        found = assign_causality(graph)
    except StructureError as error:
        found = assign_beyond_laws(graph)
        if found is None:
            faults.found.extend(causal_faults(graph) or error.diagnostics)
    faults.raise_if_any()
    assert found is not None
    return found
