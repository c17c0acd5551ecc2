"""Why removals together leave no equations: the fewest of them that do so, and what could be taken instead.

Elements whose flow is prescribed may close a loop (three rigid parts in a ring), elements whose effort is prescribed
may cut something off (nothing holds a mass without inertia): a loop or a cutset, by what the domain shares. Exchanging
effort and flow at one member leaves as few elements, and equations: the regular twin.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.graph import Bond
from propermodel.causality.complete import complete_causality
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import ProperModelError
from propermodel.modelling.domains import Shared
from propermodel.modelling.model import (
    BondRemoval,
    ConstantEffort,
    ConstantFlow,
    Freeze,
    Merge,
    Model,
    Removal,
    ZeroEffort,
    ZeroFlow,
)


class Closure(StrEnum):
    """How elements without a variable of their own hang together."""

    LOOP = "loop"  # what runs round it adds up to nothing, whatever happens
    CUTSET = "cutset"  # what passes through it adds up to nothing
    MIXED = "set"


@dataclass(frozen=True, slots=True)
class Twin:
    """A member of a singular set, and what could take its place so that equations are left."""

    member: BondRemoval
    instead: BondRemoval

    def __str__(self) -> str:
        return f"{meaning_of(self.instead)} at {self.instead.bond}"


@dataclass(frozen=True, slots=True)
class SingularRemovals:
    """Removals that together leave no equations, none of which could be missed; `fault` says what is wrong."""

    members: tuple[BondRemoval, ...]
    closure: Closure
    fault: ProperModelError = field(compare=False)
    twins: tuple[Twin, ...]

    @property
    def message(self) -> str:
        """What is wrong with the equations."""
        return self.fault.diagnostics[0].message

    def __str__(self) -> str:
        names = ", ".join(f"{member.bond} ({meaning_of(member)})" for member in self.members)
        others = [entry.path for entry in self.fault.diagnostics[0].involved]
        owners = [str(member.bond.parent) for member in self.members]
        met = [name for name in others if not any(name == o or name.startswith(f"{o}.") for o in owners)]
        with_others = f" with {', '.join(met)}" if met else ""
        twins = " or ".join(map(str, self.twins))
        what = "is a" if len(self.members) == 1 else "are a"
        closure = f"{names}{with_others} {what} {self.closure} without a free variable: {self.message}"
        return f"{closure}; regular would be {twins}" if twins else closure


def meaning_of(removal: BondRemoval) -> str:
    """What a removal puts in the place of an element, in words."""
    match removal:
        case ZeroEffort():
            return "no effort"
        case ZeroFlow():
            return "no flow"
        case ConstantEffort():
            return f"constant effort {removal.value:.6g}"
        case ConstantFlow():
            return f"constant flow {removal.value:.6g}"
        case Merge():
            return f"merged into {removal.into}"
        case _:
            return f"driven by its {removal.driven}"


def explain_removals(model: Model, removals: Iterable[Removal]) -> SingularRemovals | None:
    """Why removals together leave a model without equations, and their regular twins; None if they do leave a model.

    Args:
        model: The model, which can be compiled.
        removals: What is to be removed.

    Raises:
        ReductionError: a removal names nothing, or something twice.
    """
    removals = tuple(removals)
    frozen = [removal for removal in removals if isinstance(removal, Freeze)]
    bonds: list[BondRemoval] = [removal for removal in removals if not isinstance(removal, Freeze)]
    fault = _fault(model, [*bonds, *frozen])
    if fault is None:
        return None
    strokes_only = _fault(model, [*bonds, *frozen], strokes_only=True) is not None
    members = _fewest(model, bonds, strokes_only)
    fault = _fault(model, members) or fault
    twins = [
        Twin(member, dual)
        for member in members
        for dual in _duals(member)
        if _fault(model, [dual if removal is member else removal for removal in bonds] + frozen) is None
    ]
    return SingularRemovals(tuple(members), _closure(model, members), fault, tuple(twins))


def _fault(model: Model, removals: Sequence[Removal], *, strokes_only: bool = False) -> ProperModelError | None:
    """Why removals leave no model; with `strokes_only` what causality says, which takes a fraction of the time."""
    try:
        if strokes_only:
            complete_causality(flatten(model.without(removals)))
        else:
            compile_quietly(model.without(removals))
    except ProperModelError as error:
        if error.diagnostics[0].code.startswith("reduction/"):
            raise
        return error
    return None


def _fewest(model: Model, removals: list[BondRemoval], strokes_only: bool) -> list[BondRemoval]:
    """A smallest set that is singular: each round finds, by halving, one more that it cannot do without."""
    needed: list[BondRemoval] = []
    rest = removals
    while rest and _fault(model, needed, strokes_only=strokes_only) is None:
        low, high = 0, len(rest)
        while high - low > 1:
            middle = (low + high) // 2
            fault = _fault(model, [*needed, *rest[:middle]], strokes_only=strokes_only)
            low, high = (low, middle) if fault is not None else (middle, high)
        needed.append(rest[high - 1])
        rest = rest[: high - 1]
    return needed


def _duals(removal: BondRemoval) -> tuple[BondRemoval, ...]:
    if isinstance(removal, ZeroFlow | ConstantFlow):
        return (ZeroEffort(removal.bond),)
    if isinstance(removal, ZeroEffort | ConstantEffort):
        return (ZeroFlow(removal.bond),)
    return (ZeroEffort(removal.bond), ZeroFlow(removal.bond))


def _closure(model: Model, members: Sequence[BondRemoval]) -> Closure:
    """Where nodes share flow, prescribed flows close loops; where they share effort, prescribed efforts do."""
    bonds = flatten(model).normal.bonds
    kinds: set[Closure] = set()
    for member in members:
        bond: Bond | None = bonds.get(member.bond)
        if bond is None:
            return Closure.MIXED
        shares_flow = model.domain(bond.domain).shared is Shared.FLOW
        prescribes_flow = isinstance(member, ZeroFlow | ConstantFlow)
        kinds.add(Closure.LOOP if shares_flow is prescribes_flow else Closure.CUTSET)
    return kinds.pop() if len(kinds) == 1 else Closure.MIXED
