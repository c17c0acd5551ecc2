"""The equation system: states with their derivatives, implicit blocks, and every variable as an expression."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from propermodel.causality.causal import CausalGraph
from propermodel.diagnostics import NO_SOURCE, Path, Source
from propermodel.equations.events import SystemEvent
from propermodel.equations.printing import equations_text
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Variable


class StateKind(StrEnum):
    """What a state is."""

    DISPLACEMENT = "displacement"
    MOMENTUM = "momentum"
    SIGNAL = "signal"


@dataclass(frozen=True, slots=True, kw_only=True)
class StateVariable:
    """A continuous state with its start, range and derivative."""

    path: Path  # of the coordinate: element path and coordinate name
    symbol: Expr
    unit: str
    kind: StateKind
    start: Expr
    low: Expr
    high: Expr
    derivative: Expr
    source: Source = field(default=NO_SOURCE, compare=False)


class BlockKind(StrEnum):
    """Why an implicit block is there."""

    LOOP = "algebraic loop"
    DEPENDENT = "dependent storage"
    LOCK = "locked resistance"
    CONSTRAINT = "kinematic constraint"
    IMPLICIT = "implicit law"
    SWITCH = "ideal switch"


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplicitBlock:
    """Unknowns that must be solved for together, with Newton's method; the residuals vanish at the solution."""

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    jacobian: tuple[tuple[Expr, ...], ...]
    paths: tuple[Path, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SolvedBlock:
    """Unknowns that were eliminated exactly; `matrix` is what multiplied them in linear equations.

    Of a block that is left to Newton's method, it is that of the unknowns which the block contains linearly.
    """

    unknowns: tuple[Expr, ...]
    paths: tuple[Path, ...]
    kinds: tuple[BlockKind, ...]
    matrix: tuple[tuple[Expr, ...], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Switching:
    """The equations of a block with ideal switches, as they are before they are weighed.

    Row i of the block is the sum over j of `of_residual[i][j]` times residual j, `of_drift[i][j]` times its rate of
    change with the unknowns held, and `of_other[i][j]` times what it would be if its switch were the other way. What
    is weighed with `of_other` must vanish to `tolerance[i]`. Weights stand among the unknowns and change at events.
    """

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    jacobian: tuple[tuple[Expr, ...], ...]
    drift_jacobian: tuple[tuple[Expr, ...], ...]
    of_residual: tuple[tuple[Expr, ...], ...]
    of_drift: tuple[tuple[Expr, ...], ...]
    of_other: tuple[tuple[Expr, ...], ...]
    tolerance: tuple[Expr, ...]
    paths: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Stored:
    """The energy of one storage element, as an expression of states."""

    element: Path
    energy: Expr


@dataclass(frozen=True, slots=True)
class Modulation:
    """The power that enters one storage element where its law changes from outside, through a signal or with time."""

    element: Path
    power: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class DependentStorage:
    """Storage that follows from the states, with the start that its author gave it.

    What it takes up comes from the states: `reactions` says by how much the rate of each changes with the rate of the
    stored quantity.
    """

    element: Path
    path: Path  # of the coordinate
    symbol: Expr
    unit: str
    start: Expr
    stored: Expr
    reactions: tuple[tuple[Expr, Expr], ...]  # symbol of a state, factor


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """Where a kinematic loop closes: what must vanish along a run, and what gives way.

    `flow` must vanish where the constraint acts through an effort: impulses of it change the states by `impulses`.
    `displacement` must vanish where the loop has a geometry: the `coordinates` give way.
    """

    element: Path
    flow: Expr | None
    flow_unit: str
    impulses: tuple[tuple[Expr, Expr], ...]  # symbol of a state, slope of its rate with respect to the effort
    displacement: Expr | None
    displacement_unit: str
    coordinates: tuple[tuple[Expr, Expr], ...]  # symbol of a state, slope of the displacement
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impacts:
    """What the impulses of all events that happen at once do to the states.

    An event takes part while its flag, which stands among the unknowns, is 1. The residuals vanish at the impulses.
    """

    flags: tuple[tuple[int, Expr], ...]  # number of an event, its flag
    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    jacobian: tuple[tuple[Expr, ...], ...]
    updates: tuple[tuple[Expr, Expr], ...]  # symbol of a state, its value afterwards
    losses: tuple[Expr, ...]  # of each flagged event: the energy that its impulse takes away, J
    paths: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a ranking: an energy element or a declared group, with the bonds whose powers make it up."""

    path: Path
    kind: str
    elements: tuple[Path, ...]
    bonds: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class StorageReference:
    """What one bond of a storage has at the point about which activity is measured: a C an effort, an I a flow."""

    bond: Path
    variable: Variable
    value: float


@dataclass(frozen=True, slots=True)
class StorageDatum:
    """The point about which the activity of storage is measured, in words and in numbers."""

    point: str
    references: tuple[StorageReference, ...]


@dataclass(frozen=True, kw_only=True)
class EquationSystem:
    """Everything the model computes, as expressions of states, held values, parameters and time.

    `values` holds efforts and flows of bonds, signals and stored quantities by symbol. Expressions may contain the
    unknowns of `blocks`, in whose order they are solved.
    """

    causal: CausalGraph
    states: tuple[StateVariable, ...]
    dependents: tuple[DependentStorage, ...]
    closures: tuple[Closure, ...]
    blocks: tuple[ImplicitBlock, ...]
    solved: tuple[SolvedBlock, ...]
    values: Mapping[Expr, Expr]
    energies: tuple[Stored, ...]
    rows: tuple[Row, ...]
    updates: tuple[tuple[Path, tuple[tuple[Expr, Expr], ...]], ...]  # controller: held value, new value
    events: tuple[SystemEvent, ...] = ()
    impacts: Impacts | None = None
    modulations: tuple[Modulation, ...] = ()
    switching: tuple[Switching, ...] = ()
    datum: StorageDatum | None = None  # beside its powers, those of storage about it are integrated

    def laws_of(self, block: ImplicitBlock) -> tuple[Expr, ...]:
        """What a block says in terms of laws: its residuals, without the weights that switches give them."""
        return next((s.residuals for s in self.switching if s.unknowns == block.unknowns), block.residuals)

    def __str__(self) -> str:
        return equations_text(self)
