"""From an equation system to a program: every quantity gets its slot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propermodel.bondgraph.graph import Bond, BondGraph, SampledController, Variables
from propermodel.bondgraph.pseudo import pseudo_elements
from propermodel.codegen.program import (
    Array,
    Assign,
    Extrapolation,
    Function,
    Layout,
    Program,
    Slot,
    Solve,
    TableSlot,
)
from propermodel.diagnostics import Path
from propermodel.equations.at_places import sign_at
from propermodel.equations.corrections import Correction, corrections_of
from propermodel.equations.system import (
    EquationSystem,
    Impacts,
    ImplicitBlock,
    Row,
    StateKind,
    StorageReference,
    Switching,
)
from propermodel.expressions.core import (
    ONE,
    TIME,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    leaves,
    postorder,
    symbol,
    where,
)
from propermodel.modelling.model import Variable

IndexArray = NDArray[np.int64]
DEVIATION = "deviation"  # the kind of a power about a datum, and the last name of its path


@dataclass(frozen=True)
class PowerEntry:
    """One entry of the power array: a bond, a row of several bonds, or a table (time spent outside it).

    Entries about a datum stand beside those of their bond or row, under its path and `deviation`.
    """

    path: Path
    kind: str  # "bond", "row", "modulation", "deviation" or "outside"
    value: Expr


@dataclass(frozen=True, slots=True)
class Observable:
    """Where a recordable quantity stands, and its unit."""

    index: int
    unit: str


@dataclass(frozen=True, slots=True)
class ImpactSlots:
    """Where impulses stand: the flag of each event that has one, the states they change, and where JUMP has these."""

    flags: tuple[tuple[int, Slot], ...]  # number of an event, its flag
    states: tuple[Slot, ...]
    first: int  # in JUMP: the states afterwards, then what each event loses


@dataclass(frozen=True, slots=True, eq=False)
class SwitchingSlots:
    """Where a block with ideal switches has its weights, among the unknowns, and its numbers, in SWITCHING.

    From `first` on stand the residuals, their derivatives by rows, and those of the residuals' rates of change.
    """

    of_residual: IndexArray  # size x size, as the next two
    of_drift: IndexArray
    of_other: IndexArray
    tolerance: IndexArray
    first: int
    paths: tuple[Path, ...]


@dataclass(frozen=True)
class Lowered:
    """A program with the meaning of its entries: powers, observables (several may share an entry), parameters."""

    program: Program
    powers: tuple[PowerEntry, ...]
    observables: Mapping[Path, Observable]
    signal_count: int
    parameters: tuple[Path, ...]
    held: tuple[Expr, ...]
    tables: tuple[Path, ...]
    targets: tuple[tuple[Slot, ...], ...] = ()  # of each event: what it changes, in the order of JUMP
    impacts: ImpactSlots | None = None
    switching: tuple[SwitchingSlots, ...] = ()

    @cached_property
    def power_places(self) -> Mapping[Path, int]:
        """The entry of POWER of every bond and row."""
        return {power.path: index for index, power in enumerate(self.powers) if power.kind != "outside"}


def lower(system: EquationSystem) -> Lowered:
    """The program of an equation system."""
    graph = system.causal.graph
    variables = graph.variables
    modulations = (PowerEntry(m.element / "modulation", "modulation", m.power) for m in system.modulations)
    powers = (*_bond_powers(system, variables), *_row_powers(system, variables), *modulations, *_deviations(system))
    observables, signals = _signals(system)
    roots = [state.derivative for state in system.states]
    roots += [e.value for e in powers] + signals
    roots += [value for _, updates in system.updates for _, value in updates]
    roots += [r for b in system.blocks for r in (*b.residuals, *(e for row in b.jacobian for e in row))]
    corrections = corrections_of(system)
    roots += [value for c in corrections for _, value in c.updates]
    roots += [r for c in corrections for r in (*c.residuals, *(e for row in c.jacobian for e in row))]
    guards = [event.guard for event in system.events]
    jumps = [value for event in system.events for _, value in event.changes]
    first, impacts = len(jumps), system.impacts
    inside: list[Expr] = []
    if impacts is not None:
        jumps += [*(value for _, value in impacts.updates), *impacts.losses]
        inside = [*impacts.residuals, *(e for row in impacts.jacobian for e in row)]
    switched = [value for s in system.switching for value in numbers_of(s)]
    outside = _time_outside([state.derivative for state in system.states], system)
    powers = (*powers, *outside)
    roots += [e.value for e in outside]
    periods = [controller.period for controller in graph.controllers]
    # Last, so that what events mention gives nothing else another slot.
    used = leaves(*roots, *periods, *guards, *jumps, *inside, *switched)
    held = tuple(h for h, _ in graph.held)
    parameters = tuple(leaf for leaf in used if leaf.data.kind is SymbolKind.PARAMETER)
    tables = tuple(leaf for leaf in used if leaf.data.kind is SymbolKind.TABLE)
    unknowns = tuple(u for b in (*system.blocks, *corrections) for u in b.unknowns)
    unknowns += tuple(rank_symbol(c) for c in corrections if c.rank is not None)
    if impacts is not None:
        unknowns += (*impacts.unknowns, *(flag for _, flag in impacts.flags))
    unknowns += tuple(weight for s in system.switching for weight in _weights(s))
    counts = {Array.POWER: len(powers), Array.SIGNAL: len(signals), Array.GUARD: len(guards), Array.JUMP: len(jumps)}
    counts[Array.SWITCHING] = len(switched)
    layout = _layout(system, parameters, held, tables, unknowns, counts)
    rates = [Assign(Slot(Array.RATE, i), s.derivative) for i, s in enumerate(system.states)]
    displacement_rates = [
        Assign(Slot(Array.RATE, i), s.derivative)
        for i, s in enumerate(system.states)
        if s.kind is StateKind.DISPLACEMENT
    ]
    program = Program(
        rates=_function("rates", system, [*rates, *_assignments(Array.POWER, (e.value for e in powers))]),
        displacement_rates=_function("displacement_rates", system, displacement_rates),
        observe=_function("observe", system, _assignments(Array.SIGNAL, signals)),
        samples=tuple(_samples(system, held)),
        periods=tuple(layout.slots[c.period].index for c in _in_run_order(system)),
        layout=layout,
        corrections=tuple(_correction(k, correction, layout) for k, correction in enumerate(corrections)),
        guards=_function("guards", system, _assignments(Array.GUARD, guards)) if guards else None,
        jumps=_jumps(system, jumps, inside) if guards else None,
        switching=_switching(system, switched) if switched else None,
    )
    return Lowered(
        program=program,
        powers=powers,
        observables=observables,
        signal_count=len(signals),
        parameters=tuple(leaf.data.path for leaf in parameters),
        held=held,
        tables=tuple(leaf.data.path for leaf in tables),
        targets=tuple(tuple(layout.slots[target] for target, _ in event.changes) for event in system.events),
        impacts=None if impacts is None else _impact_slots(impacts, layout, first),
        switching=tuple(_switching_slots(system, layout)),
    )


def _jumps(system: EquationSystem, jumps: list[Expr], inside: list[Expr]) -> Function:
    """What events make of states and held values; impulses are solved for once their laws' values are known."""
    assigns = _assignments(Array.JUMP, jumps)
    if system.impacts is None:
        return _function("jumps", system, assigns)
    needed = _function("jumps", system, [*assigns, *_assignments(Array.JUMP, inside)])
    blocks = (step for step in needed.steps if isinstance(step, Solve))
    return Function("jumps", (*blocks, _solve(system.impacts), *assigns))


def _impact_slots(impacts: Impacts, layout: Layout, first: int) -> ImpactSlots:
    return ImpactSlots(
        flags=tuple((number, layout.slots[flag]) for number, flag in impacts.flags),
        states=tuple(layout.slots[state] for state, _ in impacts.updates),
        first=first,
    )


def numbers_of(switching: Switching) -> tuple[Expr, ...]:
    """What the weights of a block with switches follow from, in the order of SWITCHING."""
    matrices = (*switching.jacobian, *switching.drift_jacobian)
    return (*switching.residuals, *(entry for row in matrices for entry in row))


def _weights(switching: Switching) -> tuple[Expr, ...]:
    matrices = (*switching.of_residual, *switching.of_drift, *switching.of_other)
    return (*(weight for row in matrices for weight in row), *switching.tolerance)


def _switching(system: EquationSystem, numbers: list[Expr]) -> Function:
    """What weights follow from; other blocks are solved, those with switches are not."""
    assigns = _assignments(Array.SWITCHING, numbers)
    switched = {s.unknowns for s in system.switching}
    needed = _function("switching", system, assigns)
    return Function(
        "switching", tuple(s for s in needed.steps if not isinstance(s, Solve) or s.unknowns not in switched)
    )


def _switching_slots(system: EquationSystem, layout: Layout) -> Iterator[SwitchingSlots]:
    first = 0
    for switching in system.switching:

        def indices(weights: Iterable[Expr]) -> IndexArray:
            return np.array([layout.slots[weight].index for weight in weights], dtype=np.int64)

        size = len(switching.unknowns)
        matrices = (switching.of_residual, switching.of_drift, switching.of_other)
        of_residual, of_drift, of_other = (
            indices(weight for row in matrix for weight in row).reshape(size, size) for matrix in matrices
        )
        tolerance = indices(switching.tolerance)
        yield SwitchingSlots(of_residual, of_drift, of_other, tolerance, first, switching.paths)
        first += len(numbers_of(switching))


def _in_run_order(system: EquationSystem) -> list[SampledController]:
    by_path = {c.path: c for c in system.causal.graph.controllers}
    return [by_path[path] for path, _ in system.updates]


def _samples(system: EquationSystem, held: tuple[Expr, ...]) -> list[Function]:
    index = {h: i for i, h in enumerate(held)}
    return [
        _function(
            f"sample_{number}",
            system,
            [Assign(Slot(Array.DISCRETE, index[h]), value) for h, value in updates],
        )
        for number, (_, updates) in enumerate(system.updates)
    ]


def _assignments(array: Array, values: Iterable[Expr]) -> list[Assign]:
    return [Assign(Slot(array, i), value) for i, value in enumerate(values)]


def _function(name: str, system: EquationSystem, assigns: list[Assign]) -> Function:
    """A function with the implicit blocks that its values need, in order."""
    if not system.blocks:
        return Function(name, tuple(assigns))
    owner = {u: block for block in system.blocks for u in block.unknowns}
    needed: set[ImplicitBlock] = set()
    pending = [a.value for a in assigns]
    while pending:
        found = {owner[leaf]: None for leaf in leaves(*pending) if leaf in owner and owner[leaf] not in needed}
        needed.update(found)
        pending = [e for block in found for e in (*block.residuals, *(e for row in block.jacobian for e in row))]
    solves = [_solve(block) for block in system.blocks if block in needed]
    return Function(name, (*solves, *assigns))


def _correction(number: int, correction: Correction, layout: Layout) -> Function:
    assigns = (Assign(layout.slots[state], value) for state, value in correction.updates)
    return Function(f"correct_{number}", (*_rank_checks(correction), _solve(correction), *assigns))


def _rank_checks(correction: Correction) -> tuple[Solve, ...]:
    """An equation without a finite solution where the constraints that are corrected depend on each other."""
    if correction.rank is None:
        return ()
    unknown = rank_symbol(correction)
    residual = unknown - where(correction.rank, ZERO, math.inf)
    return (
        Solve(unknowns=(unknown,), residuals=(residual,), jacobian=((ONE,),), scales=(1.0,), paths=correction.paths),
    )


def rank_symbol(correction: Correction) -> Expr:
    """The unknown that is infinite where the constraints of a correction depend on each other."""
    return symbol(SymbolKind.UNKNOWN, correction.paths[0] / "rank", "")


def _solve(block: ImplicitBlock | Correction | Impacts) -> Solve:
    return Solve(
        unknowns=block.unknowns,
        residuals=block.residuals,
        jacobian=block.jacobian,
        scales=tuple(1.0 for _ in block.unknowns),
        paths=block.paths,
    )


def _bond_powers(system: EquationSystem, variables: Variables) -> tuple[PowerEntry, ...]:
    bonds = system.causal.graph.normal.bonds.values()
    return tuple(PowerEntry(bond.name, "bond", _power(system, variables, bond)) for bond in bonds)


def _power(system: EquationSystem, variables: Variables, bond: Bond, reference: StorageReference | None = None) -> Expr:
    """Effort times flow, one of them counted from what it is at a datum."""
    effort, flow = (system.values[variables.of(bond, variable)] for variable in (Variable.EFFORT, Variable.FLOW))
    if reference is None:
        return effort * flow
    if reference.variable is Variable.EFFORT:
        return (effort - reference.value) * flow
    return effort * (flow - reference.value)


def _row_powers(system: EquationSystem, variables: Variables) -> tuple[PowerEntry, ...]:
    rows = (row for row in system.rows if len(row.bonds) > 1)
    return tuple(PowerEntry(row.path, "row", _row_power(system, variables, row, {})) for row in rows)


def _row_power(
    system: EquationSystem, variables: Variables, row: Row, references: Mapping[Path, StorageReference]
) -> Expr:
    """The power of all bonds of a row together, into it."""
    inside = set(row.elements)
    total = ZERO
    for name in row.bonds:
        bond = system.causal.graph.normal.bonds[name]
        power = _power(system, variables, bond, references.get(name))
        owner = bond.head.owner if bond.head.owner in inside else bond.tail.owner
        total = total + power if sign_at(bond, owner) else total - power
    return total


def _deviations(system: EquationSystem) -> tuple[PowerEntry, ...]:
    """The powers of storage about the datum, of bonds and of rows of several bonds."""
    if system.datum is None:
        return ()
    variables, bonds = system.causal.graph.variables, system.causal.graph.normal.bonds
    references = {reference.bond: reference for reference in system.datum.references}
    found = [
        PowerEntry(name / DEVIATION, DEVIATION, _power(system, variables, bonds[name], reference))
        for name, reference in references.items()
    ]
    found += [
        PowerEntry(row.path / DEVIATION, DEVIATION, _row_power(system, variables, row, references))
        for row in system.rows
        if len(row.bonds) > 1 and not references.keys().isdisjoint(row.bonds)
    ]
    return tuple(found)


def _time_outside(roots: list[Expr], system: EquationSystem) -> tuple[PowerEntry, ...]:
    """For every table with a grid: 1 while its coordinate is outside, integrated to the time spent outside."""
    graph = system.causal.graph
    conditions: dict[Path, Expr] = {}
    for node in postorder(roots):
        if node.op is not Op.LOOKUP:
            continue
        path = node.args[0].data.path
        if graph.tables[path].is_input:
            continue
        for axis, coordinate in enumerate(node.args[1:]):
            low = symbol(SymbolKind.PARAMETER, path / f"low{axis}", "")
            high = symbol(SymbolKind.PARAMETER, path / f"high{axis}", "")
            leaving = (coordinate < low) | (coordinate > high)
            conditions[path] = conditions[path] | leaving if path in conditions else leaving
    return tuple(PowerEntry(path, "outside", where(c, ONE, ZERO)) for path, c in conditions.items())


def _signals(system: EquationSystem) -> tuple[dict[Path, Observable], list[Expr]]:
    """What can be recorded: states, held values, signals, stored energies, and the variables of ports.

    Quantities with the same expression share one entry. Powers are left out: they are effort times flow.
    """
    values: list[Expr] = []
    index: dict[Expr, int] = {}
    found: dict[Path, Observable] = {}

    def offer(path: Path, value: Expr, unit: str) -> None:
        if value not in index:
            index[value] = len(values)
            values.append(value)
        found.setdefault(path, Observable(index[value], unit))

    states = {s.symbol for s in system.states}
    open_leaves = {
        leaf for leaf in leaves(*system.values.values()) if leaf.data.kind not in _GIVEN and leaf not in states
    }
    for state in system.states:
        offer(state.path, state.symbol, state.unit)
    for held, _ in system.causal.graph.held:
        offer(held.data.path, held, held.data.unit)
    pseudo = pseudo_elements(system.causal.graph)
    for stored in system.energies:
        offer(stored.element / "energy", stored.energy, "" if stored.element in pseudo else "J")
    for leaf, value in system.values.items():
        if leaf.data.kind is not SymbolKind.POWER and not (open_leaves and open_leaves.intersection(leaves(value))):
            offer(leaf.data.path, value, leaf.data.unit)
    return found, values


_GIVEN = frozenset({SymbolKind.TIME, SymbolKind.PARAMETER, SymbolKind.TABLE, SymbolKind.DISCRETE, SymbolKind.UNKNOWN})


def _layout(
    system: EquationSystem,
    parameters: tuple[Expr, ...],
    held: tuple[Expr, ...],
    tables: tuple[Expr, ...],
    unknowns: tuple[Expr, ...],
    counts: Mapping[Array, int],
) -> Layout:
    slots: dict[Expr, Slot] = {TIME: Slot(Array.TIME, 0)}
    slots.update({s.symbol: Slot(Array.STATE, i) for i, s in enumerate(system.states)})
    slots.update({p: Slot(Array.PARAMETER, i) for i, p in enumerate(parameters)})
    slots.update({h: Slot(Array.DISCRETE, i) for i, h in enumerate(held)})
    slots.update({u: Slot(Array.UNKNOWN, i) for i, u in enumerate(unknowns)})
    graph = system.causal.graph
    kinds = [s.kind for s in system.states]
    return Layout(
        slots=slots,
        lengths={
            Array.TIME: 1,
            Array.STATE: len(system.states),
            Array.RATE: len(system.states),
            Array.DISCRETE: len(held),
            Array.PARAMETER: len(parameters),
            Array.UNKNOWN: len(unknowns),
            **counts,
        },
        tables=tuple(_table_slot(graph, t.data.path) for t in tables),
        table_index={t: i for i, t in enumerate(tables)},
        momenta=tuple(i for i, k in enumerate(kinds) if k is StateKind.MOMENTUM),
        displacements=tuple(i for i, k in enumerate(kinds) if k is StateKind.DISPLACEMENT),
    )


def _table_slot(graph: BondGraph, path: Path) -> TableSlot:
    table = graph.tables[path]
    return TableSlot(
        path=path,
        dimensions=len(table.values.grids),
        extrapolation=Extrapolation(table.spec.extrapolation),
        is_uniform=False if table.is_input else is_uniform(table.values.grids),
    )


def is_uniform(grids: Iterable[ArrayLike]) -> bool:
    """Whether every grid is equidistant to rounding."""
    for grid in grids:
        gaps = np.diff(np.asarray(grid))
        if np.any(np.abs(gaps - np.mean(gaps)) > 1e-9 * abs(np.mean(gaps))):
            return False
    return True
