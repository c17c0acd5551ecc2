"""Which storage is a state, where the graph leaves a choice.

Storage that depends on other storage leaves a choice of states. A bad choice sends efforts backwards through parts
that only know one direction (a lossy gear), which makes algebraic loops, or divides by a modulus that can vanish (the
sine of an angle). The search moves single storages to the end or the front of the order of assignment while that
helps. Where dependent storage would still depend on its own answer, laws may be solved for what they take instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

from propermodel.bondgraph.graph import Structure
from propermodel.causality.assign import assign_causality
from propermodel.causality.causal import CausalGraph
from propermodel.causality.completion import assign_beyond_laws
from propermodel.causality.graph_algorithms import strong_components
from propermodel.causality.vanishing import dividing_two_ports
from propermodel.diagnostics import Path, StructureError
from propermodel.equations.definitions import Definitions, define_needed, observables_of
from propermodel.expressions.core import Expr, leaves
from propermodel.modelling.model import ElementKind, JunctionKind

# Larger graphs with this many storages keep the order of the model.
MOST_STORAGES = 200

Score = tuple[int, int, int, int]


def select_states(causal: CausalGraph) -> CausalGraph:
    """The same graph with the best states found, or the given one where there is nothing to gain."""
    search = _Search(causal)
    found = search.best()
    if not found.derivative or not search.answers_itself(found):
        return found
    other = assign_beyond_laws(causal.graph)
    return found if other is None or search.answers_itself(other) else other


class _Search:
    """The search among the causal graphs of one bond graph; strokes that were looked at are not looked at again."""

    def __init__(self, causal: CausalGraph) -> None:
        self._causal = causal
        self._scores: dict[tuple[Path, ...], Score] = {}

    def best(self) -> CausalGraph:
        """The causal graph from which no single move leads to a better one."""
        best = self._causal
        elements = [e.path for e in best.graph.normal.elements.values() if e.kind.is_storage]
        if not (best.derivative or best.constraints) or len(elements) > MOST_STORAGES:
            return best
        order = elements
        classes = _rigid_classes(best.graph.normal)
        while self.score(best)[:2] > (0, 0):
            found = min(self._moves(best, order, classes), key=lambda item: self.score(item[0]), default=None)
            if found is None:
                return best
            best, order = found
        return best

    def score(self, causal: CausalGraph) -> Score:
        """Divisions by moduli that may vanish, variables in loops of dependent storage, constraints, dependents."""
        bonds = causal.graph.normal.bonds
        strokes = (*(causal.strokes[name].effort_into for name in bonds), *causal.constraints)
        if strokes not in self._scores:
            loops = _looped_variables(self._definitions(causal)) if causal.derivative else 0
            divisions = len(dividing_two_ports(causal))
            self._scores[strokes] = divisions, loops, len(causal.constraints), len(causal.derivative)
        return self._scores[strokes]

    def answers_itself(self, causal: CausalGraph) -> bool:
        """Whether the content of dependent storage follows from what dependent storage answers: a higher index."""
        return _answers_itself(self._definitions(causal))

    def _definitions(self, causal: CausalGraph) -> Definitions:
        return define_needed(causal, self._observables)

    @cached_property
    def _observables(self) -> Mapping[Expr, Expr]:
        return observables_of(self._causal)

    def _moves(
        self, causal: CausalGraph, order: list[Path], classes: list[list[Path]]
    ) -> Iterator[tuple[CausalGraph, list[Path]]]:
        """The better causal graphs that moving one rigid class to the end or the front of the order gives."""
        score = self.score(causal)
        for members in classes:
            moved = [path for path in order if path in members]
            rest = [path for path in order if path not in members]
            for attempt in ([*rest, *moved], [*moved, *rest]):
                try:
                    other = assign_causality(causal.graph, attempt, causal.constraints)
                except StructureError:
                    continue
                if len(dividing_two_ports(other)) <= score[0] and self.score(other) < score:
                    yield other, attempt
        for constraint in causal.constraints:
            # A part without mass in a loop: its flow follows from the closure, not from an effort.
            fewer = [c for c in causal.constraints if c != constraint]
            try:
                other = assign_causality(causal.graph, order, fewer)
            except StructureError:
                continue
            if self.score(other) < score:
                yield other, order


def _rigid_classes(structure: Structure) -> list[list[Path]]:
    """Storage that moves together: joined by junctions of its own kind and transformers only."""
    parent: dict[Path, Path] = {}

    def find(path: Path) -> Path:
        while parent.setdefault(path, path) != path:
            path = parent[path]
        return path

    for bond in structure.bonds.values():
        a, b = bond.tail.owner, bond.head.owner
        kinds = {structure.junctions[p].kind for p in (a, b) if p in structure.junctions}
        elements = [structure.elements[p] for p in (a, b) if p in structure.elements]
        if len(kinds) == 1 and all(
            e.kind is ElementKind.TRANSFORMER
            or e.kind is (ElementKind.INERTIA if JunctionKind.ONE in kinds else ElementKind.COMPLIANCE)
            for e in elements
        ):
            parent[find(a)] = find(b)
    classes: dict[Path, list[Path]] = {}
    for element in structure.elements.values():
        if element.kind.is_storage:
            classes.setdefault(find(element.path), []).append(element.path)
    return list(classes.values())


def _looped_variables(found: Definitions) -> int:
    """How many variables stand in algebraic loops that the answer of dependent storage runs through."""
    symbols = list(found.values)
    index = {s: i for i, s in enumerate(symbols)}
    answers = {d.unknown for d in found.dependents}
    uses: list[list[int]] = []
    driven = [False] * len(symbols)
    for i, target in enumerate(symbols):
        inside = leaves(found.values[target])
        uses.append([index[leaf] for leaf in inside if leaf in index])
        driven[i] = any(leaf in answers for leaf in inside)
    count = 0
    for component in strong_components(len(symbols), [(i, j) for i, js in enumerate(uses) for j in js]):
        reached = any(driven[i] or any(driven[j] for j in uses[i]) for i in component)
        for i in component:
            driven[i] = reached
        if reached and (len(component) > 1 or component[0] in uses[component[0]]):
            count += len(component)
    return count


def _answers_itself(found: Definitions) -> bool:
    """Whether the content of dependent storage follows from what dependent storage answers: a higher index."""
    sources = found.values | {item.unknown: item.residual for item in found.implied}
    answers = {dependent.unknown for dependent in found.dependents}
    pending = [leaf for dependent in found.dependents for leaf in leaves(dependent.stored) if leaf in sources]
    seen: set[Expr] = set(pending)
    while pending:
        for leaf in leaves(sources[pending.pop()]):
            if leaf in answers:
                return True
            if leaf in sources and leaf not in seen:
                seen.add(leaf)
                pending.append(leaf)
    return False
