"""The program: what a compiled model computes, as straight-line functions over numbered slots.

A `Program` knows nothing of bond graphs. `Layout` is the only place where quantities have indices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr


class Array(StrEnum):
    """The arrays a program reads and writes; every entry is one float64 per lane."""

    TIME = "time"  # one entry: the time, s
    STATE = "state"
    RATE = "rate"  # derivative of each state
    DISCRETE = "discrete"  # held values of controllers: discrete states and outputs
    PARAMETER = "parameter"
    UNKNOWN = "unknown"  # solutions of the implicit blocks, kept as the next start
    POWER = "power"  # what is integrated in time, with and without its sign: bond powers and row powers
    SIGNAL = "signal"  # what can be recorded
    GUARD = "guard"  # of each event: positive where its condition holds
    JUMP = "jump"  # what events make of states and held values
    STEP = "step"  # one entry: the length of the step that is being taken, s
    FACTOR = "factor"  # of the matrix of an implicit step, kept while it serves
    STAGE = "stage"  # what the stages of an implicit step hand on
    ERROR = "error"  # estimate of the error of each state in a step
    WEAK = "weak"  # one entry: 1 + the first state whose equation in an implicit step is singular, or 0
    SWITCHING = "switching"  # of blocks with ideal switches: residuals and derivatives, from which weights follow


@dataclass(frozen=True, slots=True)
class Slot:
    """One entry of one array."""

    array: Array
    index: int


@dataclass(frozen=True, slots=True)
class Assign:
    """Store the value of an expression in a slot."""

    slot: Slot
    value: Expr


@dataclass(frozen=True, slots=True)
class Solve:
    """Find the unknowns that make the residuals vanish, by Newton's method started from their slots.

    After it the unknowns' symbols have their solution as value, which is also stored in their slots.
    `jacobian[i][j]` is the exact derivative of residual i with respect to unknown j. `scales` are typical magnitudes of
    the unknowns: the iteration ends when every correction is below `tolerance * (|unknown| + scale)`.
    """

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]
    jacobian: tuple[tuple[Expr, ...], ...]
    scales: tuple[float, ...]
    paths: tuple[Path, ...]
    tolerance: float = 1e-10
    most_iterations: int = 25


@dataclass(frozen=True, slots=True)
class Function:
    """A named sequence of assignments and solutions; a `Solve` stands before what uses its unknowns.

    Every value is read before any slot is written, except that the unknowns of a `Solve` are available after it.
    """

    name: str
    steps: tuple[Assign | Solve, ...]


class Extrapolation(StrEnum):
    """What a table answers outside its grid."""

    HOLD = "hold"
    LINEAR = "linear"


@dataclass(frozen=True, slots=True)
class TableSlot:
    """The shape of one table; its data are given at run time.

    A one-dimensional table holds a strictly growing grid and as many values; a two-dimensional one two grids and
    values in row-major order (first coordinate slowest). `is_uniform` says that every grid is equidistant, so that
    the cell is computed rather than searched for; data given at run time must then be equidistant too.
    """

    path: Path
    dimensions: int
    extrapolation: Extrapolation
    is_uniform: bool


@dataclass(frozen=True)
class Layout:
    """Where everything is: leaves of expressions to slots, and the lengths of the arrays."""

    slots: Mapping[Expr, Slot]
    lengths: Mapping[Array, int]
    tables: tuple[TableSlot, ...]
    table_index: Mapping[Expr, int]  # table symbol to index in `tables`
    momenta: tuple[int, ...]  # states advanced first by semi-implicit Euler
    displacements: tuple[int, ...]  # states advanced second, with the new momenta


@dataclass(frozen=True, slots=True)
class ImplicitStep:
    """A step with linear equations, as functions that move STATE from stage to stage and at last to its end.

    `first` computes POWER at the beginning, FACTOR, WEAK and the first stage; `first_again` the same with the FACTOR
    that is there, where the method allows it. `later` are the other stages, at times `shares` of the step after its
    beginning; the last one computes ERROR, if the method has an estimate. `middle` moves STATE to the middle of the
    step that was taken. All read STEP.
    """

    first: Function
    first_again: Function | None
    later: tuple[Function, ...]
    shares: tuple[float, ...]
    start: tuple[Slot, ...]  # where each STATE of the beginning is kept
    middle: Function | None = None

    @property
    def functions(self) -> tuple[Function, ...]:
        """Every function."""
        optional = (function for function in (self.first_again, self.middle) if function is not None)
        return (self.first, *self.later, *optional)


@dataclass(frozen=True)
class Program:
    """Everything a backend needs.

    `rates` computes RATE and POWER (and UNKNOWN by its solves); `displacement_rates` computes the RATE of the
    displacements only; `observe` computes SIGNAL; `samples[k]` computes the DISCRETE entries of sampled controllers
    of rate k, due every `periods[k]` (an index into PARAMETER). `corrections` compute entries of STATE after every
    step, one after the other. A program with events has `guards`, which computes GUARD, and `jumps`, which computes
    JUMP; `switching`, which computes SWITCHING, solves no block with switches, but reads what was solved last. For an
    implicit method there is `implicit_step`.
    """

    rates: Function
    displacement_rates: Function
    observe: Function
    samples: tuple[Function, ...]
    periods: tuple[int, ...]
    layout: Layout
    corrections: tuple[Function, ...] = ()
    guards: Function | None = None
    jumps: Function | None = None
    switching: Function | None = None
    implicit_step: ImplicitStep | None = None

    @property
    def continuous(self) -> tuple[Function, ...]:
        """The functions that read what is kept between samples: all but the samples."""
        return (self.rates, self.displacement_rates, self.observe, *self.corrections, *self._optional)

    @property
    def functions(self) -> tuple[Function, ...]:
        """Every function."""
        first = (self.rates, self.displacement_rates, self.observe, *self.samples, *self.corrections)
        return (*first, *self._optional)

    @property
    def _optional(self) -> tuple[Function, ...]:
        events = (function for function in (self.guards, self.jumps, self.switching) if function is not None)
        return (*events, *(() if self.implicit_step is None else self.implicit_step.functions))
