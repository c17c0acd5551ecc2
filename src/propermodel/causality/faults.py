"""All faults of causality in one graph, found by going on after each."""

from __future__ import annotations

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.causality.assign import Pattern
from propermodel.causality.causal import Why
from propermodel.causality.closures import closures
from propermodel.causality.completion import Completion
from propermodel.causality.conflicts import Conflict, Contradiction, contradiction, explain, merged, no_inverse
from propermodel.diagnostics import Diagnostic
from propermodel.modelling.model import PowerSource, Resistive, Storage


def causal_faults(graph: BondGraph) -> list[Diagnostic]:
    """Every contradiction that is met when what cannot be satisfied is left out; laws are inverted where they can be.

    What is left out asks for nothing, so that each fault stands for itself.
    """
    search = _Search(graph)
    elements = graph.normal.elements.values()
    closing = closures(graph.normal)
    for element in elements:
        if isinstance(element.behaviour, PowerSource) and element.path not in closing:
            search.demand(element, [search.source_pattern(element)], Why.SOURCE)
    for element in elements:
        if isinstance(element.behaviour, Resistive) and not search.inversion.is_possible(element):
            patterns = search.law_patterns(element)
            if len(patterns) == 1:
                search.demand(element, patterns, Why.LAW)
    for element in elements:
        if isinstance(element.behaviour, Storage):
            search.demand_storage(element)
    for element in elements:
        if isinstance(element.behaviour, Resistive) and not search.inversion.is_possible(element):
            patterns = search.law_patterns(element)
            if len(patterns) > 1:
                search.demand(element, patterns, Why.CHOICE)
    found = [explain(search, item, search.inversion) for item in merged(search.contradictions)]
    return [*found, *search.without_inverse]


class _Search(Completion):
    """An assignment that remembers contradictions and goes on."""

    def __init__(self, graph: BondGraph) -> None:
        super().__init__(graph)
        self.contradictions: list[Contradiction] = []
        self.without_inverse: list[Diagnostic] = []

    def demand(self, element: Element, patterns: list[Pattern], why: Why) -> bool:
        """Give an element one of its causalities; where none fits, remember why the first does not."""
        if any(self.attempt(element, pattern, why) for pattern in patterns):
            return True
        mark = len(self.trail)
        try:
            self.assign(element, patterns[0], why)
        except Conflict as conflict:
            self.contradictions.append(contradiction(self, element, conflict))
        self.undo(mark)
        return False

    def demand_storage(self, element: Element) -> None:
        """Integral causality if possible, derivative causality where the law has an inverse."""
        if self.attempt(element, self.storage_pattern(element, integral=True), Why.INTEGRAL):
            return
        if len(element.ports) > 1 and self.assign_field(element):
            return
        if (
            self.demand(element, [self.storage_pattern(element, integral=False)], Why.DERIVATIVE)
            and len(element.ports) == 1
            and not self.inversion.is_possible(element)
        ):
            self.without_inverse.append(no_inverse(self, element, self.inversion))
