"""What keeps a run on its kinematic constraints: small corrections of the states after every step.

Displacements move along the gradient of what must vanish. Momenta change by impulses of the constraints' efforts, so
that the correction is the one that an impact would bring: it takes the least kinetic energy away.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from propermodel.diagnostics import Path
from propermodel.equations.system import Closure, DependentStorage, EquationSystem
from propermodel.expressions.core import ZERO, Expr, Substitution, SymbolKind, divide, is_zero, leaves, symbol
from propermodel.expressions.derivatives import partial_derivatives

# A constraint whose effort moves less than this share of what it would move alone depends on the others.
LEAST_PIVOT = 1e-10


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """Unknowns that make the residuals vanish, and the states that change with them.

    Where `rank` does not hold, the constraints that are corrected depend on each other.
    """

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    jacobian: tuple[tuple[Expr, ...], ...]
    updates: tuple[tuple[Expr, Expr], ...]  # symbol of a state, its corrected value
    paths: tuple[Path, ...]
    rank: Expr | None = None


def corrections_of(system: EquationSystem) -> tuple[Correction, ...]:
    """The corrections of displacements, then those of momenta, each in blocks that share no state."""
    positions = [_Moved.by_gradient(c) for c in system.closures if c.displacement is not None and c.coordinates]
    return (*_corrections(positions, is_momenta=False), *momentum_corrections(system))


def momentum_corrections(system: EquationSystem) -> tuple[Correction, ...]:
    """The corrections of momenta: impulses of the constraints' efforts, which dependent storage answers."""
    flows = [_Moved.by_impulse(c) for c in system.closures if c.flow is not None]
    if not flows:
        return ()
    flows += [_Moved.by_reaction(d) for d in system.dependents]
    return _corrections([item for item in flows if item.is_explicit()], is_momenta=True)


def _corrections(items: Sequence[_Moved], is_momenta: bool) -> tuple[Correction, ...]:
    blocks = _blocks(items)
    return tuple(_correction(block, is_momenta) for block in blocks if any(item.must_vanish for item in block))


@dataclass(frozen=True, slots=True)
class _Moved:
    """One unknown: the states it moves, and the expression that must vanish, or whose change it must equal."""

    path: Path
    name: str
    value: Expr
    slopes: tuple[tuple[Expr, Expr], ...]
    must_vanish: bool

    @staticmethod
    def by_gradient(closure: Closure) -> _Moved:
        assert closure.displacement is not None
        return _Moved(closure.element, "displacement_correction", closure.displacement, closure.coordinates, True)

    @staticmethod
    def by_impulse(closure: Closure) -> _Moved:
        assert closure.flow is not None
        return _Moved(closure.element, "impulse", closure.flow, closure.impulses, True)

    @staticmethod
    def by_reaction(dependent: DependentStorage) -> _Moved:
        return _Moved(dependent.element, "impulse", dependent.stored, dependent.reactions, False)

    def is_explicit(self) -> bool:
        """Whether it runs through no algebraic loop."""
        inside = leaves(self.value, *(slope for _, slope in self.slopes))
        return bool(self.slopes) and all(leaf.data.kind is not SymbolKind.UNKNOWN for leaf in inside)

    def touched(self) -> Iterable[Expr]:
        """The states that it moves or reads."""
        yield from (state for state, _ in self.slopes)
        yield from (leaf for leaf in leaves(self.value) if leaf.data.kind is SymbolKind.STATE)


def _blocks(items: Sequence[_Moved]) -> list[list[_Moved]]:
    """Items that share states which one of them moves, in the order of the model."""
    moved = {state for item in items for state, _ in item.slopes}
    blocks: list[tuple[set[Expr], list[_Moved]]] = []
    for item in items:
        reached, inside = moved.intersection(item.touched()), [item]
        apart: list[tuple[set[Expr], list[_Moved]]] = []
        for states, others in blocks:
            if states & reached:
                reached, inside = reached | states, [*others, *inside]
            else:
                apart.append((states, others))
        blocks = [*apart, (reached, inside)]
    return [inside for _, inside in blocks]


def _correction(block: Sequence[_Moved], is_momenta: bool) -> Correction:
    unknowns = tuple(symbol(SymbolKind.UNKNOWN, item.path / item.name, "") for item in block)
    updates = _updates(block, unknowns)
    moved = Substitution(updates)
    residuals = tuple(
        moved(item.value) if item.must_vanish else unknown - (moved(item.value) - item.value)
        for item, unknown in zip(block, unknowns, strict=True)
    )
    partials = partial_derivatives(residuals, unknowns)
    return Correction(
        unknowns=unknowns,
        residuals=residuals,
        jacobian=tuple(tuple(p.get(unknown, ZERO) for unknown in unknowns) for p in partials),
        updates=tuple(updates.items()),
        paths=tuple(item.path for item in block),
        rank=_rank(block, unknowns, partials) if is_momenta else None,
    )


def _rank(block: Sequence[_Moved], unknowns: Sequence[Expr], partials: Sequence[Mapping[Expr, Expr]]) -> Expr | None:
    """The condition that the constraints of a block are independent: no pivot is small beside its diagonal.

    Pivots of dependent storage come first; they are at least one. What is left is the matrix of a quadratic form, the
    effort that an impulse meets, which needs no exchange of rows.
    """
    at_rest = Substitution(dict.fromkeys(unknowns, ZERO))
    order = sorted(range(len(block)), key=lambda i: block[i].must_vanish)
    rows = [[at_rest(partials[i].get(unknowns[j], ZERO)) for j in order] for i in order]
    diagonal = [rows[k][k] for k in range(len(rows))]
    holds: Expr | None = None
    for k, row in enumerate(rows):
        if is_zero(row[k]):
            return None
        if block[order[k]].must_vanish:
            is_large = LEAST_PIVOT * abs(diagonal[k]) < abs(row[k])
            holds = is_large if holds is None else holds & is_large
        for below in rows[k + 1 :]:
            if not is_zero(below[k]):
                factor = divide(below[k], row[k])
                for j in range(k + 1, len(rows)):
                    below[j] = below[j] - factor * row[j]
    return holds


def _updates(block: Sequence[_Moved], unknowns: Sequence[Expr]) -> Mapping[Expr, Expr]:
    updates: dict[Expr, Expr] = {}
    for item, unknown in zip(block, unknowns, strict=True):
        for state, slope in item.slopes:
            updates[state] = updates.get(state, state) + slope * unknown
    return updates
