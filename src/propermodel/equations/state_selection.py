"""Which storage is a state, where the graph leaves a choice.

Storage that depends on other storage leaves a choice of states. A bad choice sends efforts backwards through parts
that only know one direction (a lossy gear), which makes algebraic loops, or divides by a modulus that can vanish (the
sine of an angle). The search moves single storages to the end or the front of the order of assignment while that
helps. Where dependent storage would still depend on its own answer, laws may be solved for what they take instead.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from propermodel.bondgraph.graph import Structure
from propermodel.causality.assign import assign_causality
from propermodel.causality.causal import CausalGraph
from propermodel.causality.completion import assign_beyond_laws
from propermodel.causality.graph_algorithms import strong_components
from propermodel.causality.vanishing import dividing_two_ports
from propermodel.diagnostics import Path, StructureError
from propermodel.equations.definitions import Definitions, define_needed
from propermodel.expressions.core import Expr, leaves
from propermodel.modelling.model import ElementKind, JunctionKind

# Larger graphs with this many storages keep the order of the model.
MOST_STORAGES = 200

Score = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class _Choice:
    """A causal graph under examination; its equations are written once."""

    causal: CausalGraph

    @cached_property
    def definitions(self) -> Definitions:
        """What defines every variable that equations need."""
        return define_needed(self.causal)

    @cached_property
    def score(self) -> Score:
        """Divisions by moduli that may vanish, variables in loops of dependent storage, constraints, dependents."""
        loops = _looped_variables(self.definitions) if self.causal.derivative else 0
        return _divisions(self.causal), loops, len(self.causal.constraints), len(self.causal.derivative)


def select_states(causal: CausalGraph) -> CausalGraph:
    """The same graph with the best states found, or the given one where there is nothing to gain."""
    found = _search(causal)
    if not found.causal.derivative or not _answers_itself(found.definitions):
        return found.causal
    other = assign_beyond_laws(causal.graph)
    return found.causal if other is None or _answers_itself(define_needed(other)) else other


def _search(causal: CausalGraph) -> _Choice:
    elements = [e.path for e in causal.graph.normal.elements.values() if e.kind.is_storage]
    best = _Choice(causal)
    if not (causal.derivative or causal.constraints) or len(elements) > MOST_STORAGES:
        return best
    order = elements
    classes = _rigid_classes(causal.graph.normal)
    while best.score[:2] > (0, 0):
        found = min(_moves(best, order, classes), key=lambda item: item[0].score, default=None)
        if found is None:
            return best
        best, order = found
    return best


def _moves(choice: _Choice, order: list[Path], classes: list[list[Path]]) -> Iterator[tuple[_Choice, list[Path]]]:
    """The better causal graphs that moving one rigid class to the end or the front of the order gives."""
    causal, score = choice.causal, choice.score
    for members in classes:
        moved = [path for path in order if path in members]
        rest = [path for path in order if path not in members]
        for attempt in ([*rest, *moved], [*moved, *rest]):
            try:
                other = _Choice(assign_causality(causal.graph, attempt, causal.constraints))
            except StructureError:
                continue
            if _divisions(other.causal) <= score[0] and other.score < score:
                yield other, attempt
    for constraint in causal.constraints:
        # A part without mass in a loop: its flow follows from the closure, not from an effort.
        try:
            other = _Choice(assign_causality(causal.graph, order, [c for c in causal.constraints if c != constraint]))
        except StructureError:
            continue
        if other.score < score:
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


def _divisions(causal: CausalGraph) -> int:
    return len(dividing_two_ports(causal))


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
