"""Linear elements that could be one, with the formula of the parameter that they have together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from propermodel.bondgraph.merging import LinearOnePort, linear_one_port, merged_coefficient, sharing
from propermodel.bondgraph.parameters import parameter_values
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import Merge

_WORDS = {"I": "inertia", "C": "stiffness", "R": "resistance"}


@dataclass(frozen=True, slots=True)
class MergedElement:
    """An element that can stand for others: what goes into it, and its parameter as a formula and a number, SI."""

    into: Path  # bond
    removals: tuple[Merge, ...]
    kind: str
    formula: str
    value: float
    dependent: bool  # whether one of them is dependent storage

    @property
    def members(self) -> frozenset[Path]:
        """The bonds of all that become one."""
        return frozenset((self.into, *(removal.bond for removal in self.removals)))

    def __str__(self) -> str:
        names = ", ".join(str(removal.bond.parent) for removal in self.removals)
        return f"{names} into {self.into.parent}: {_WORDS[self.kind]} {self.formula} = {self.value:.6g}"


def find_merges(compiled: CompiledModel) -> tuple[MergedElement, ...]:
    """The linear elements that share a variable with others of their kind, rigidly or through constant transformers.

    Merging is exact: without all `removals` found here a model has the same answer with fewer elements, and no
    dependent storage where it came from these. Variables of what was merged stay as they are; efforts inside
    transformers between merged elements become those of the merged model.
    """
    structure = compiled.graph.normal
    found = {p: one for p in structure.elements if (one := linear_one_port(structure, p)) is not None}
    dependent = set(compiled.system.causal.derivative)
    values = parameter_values(compiled.graph.parameters)
    merges: list[MergedElement] = []
    taken: set[Path] = set()
    # Storage that is a state stands for what depends on it.
    for path in sorted(found, key=lambda p: p in dependent):
        if path in taken:
            continue
        one = found[path]
        partners = [p for p in _partners(one, found, dict(sharing(structure, one))) if p[0].element.path not in taken]
        if not partners:
            continue
        total = one
        for other, factor in partners:
            coefficient = merged_coefficient(total, other, factor)
            total = LinearOnePort(one.element, one.junction, one.kind, coefficient)
        members = [other.element for other, _ in partners]
        taken.update((path, *(element.path for element in members)))
        bond = one.element.path / one.element.ports[0]
        merges.append(
            MergedElement(
                into=bond,
                removals=tuple(Merge(element.path / element.ports[0], bond) for element in members),
                kind=one.element.kind.value,
                formula=str(total.coefficient),
                value=interpret(total.coefficient, values),
                dependent=not dependent.isdisjoint(element.path for element in (one.element, *members)),
            )
        )
    return tuple(merges)


def merges_after(full: CompiledModel, reduced: CompiledModel) -> tuple[MergedElement, ...]:
    """The linear elements that could be one since removals have joined them, as rigid parts do."""
    before = [merge.members for merge in find_merges(full)]
    return tuple(m for m in find_merges(reduced) if not any(m.members <= known for known in before))


def _partners(
    one: LinearOnePort, found: dict[Path, LinearOnePort], factors: dict[Path, Expr]
) -> Iterable[tuple[LinearOnePort, Expr]]:
    for other in found.values():
        is_same_kind = other.element.kind is one.element.kind and other.kind is one.kind
        if other is not one and is_same_kind and other.junction in factors:
            yield other, factors[other.junction]
