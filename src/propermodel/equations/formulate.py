"""From strokes to equations: explicit where possible, with dependent storage and algebraic loops solved in blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace

from propermodel.bondgraph.graph import Element, Variables
from propermodel.causality.causal import CausalGraph
from propermodel.causality.fields import Mixed
from propermodel.diagnostics import Diagnostic, Faults, Involved, Path, Source, StructureError
from propermodel.equations.blocks import solve_blocks
from propermodel.equations.closures import closures_of, positions_of
from propermodel.equations.definitions import Definitions, define
from propermodel.equations.events import SystemEvent, system_events
from propermodel.equations.fields import causality_of, is_coordinate, state_symbol
from propermodel.equations.impacts import impacts_of
from propermodel.equations.impulses import impulse_slopes
from propermodel.equations.loops import Resolution
from propermodel.equations.modulation import modulations_of
from propermodel.equations.rank import rank_losses
from propermodel.equations.rows import rows_of
from propermodel.equations.sequence import in_sequence
from propermodel.equations.solve import eliminate
from propermodel.equations.system import (
    BlockKind,
    DependentStorage,
    EquationSystem,
    StateKind,
    StateVariable,
    Stored,
)
from propermodel.equations.unknowns import Unknown
from propermodel.equations.vanishing import is_independent
from propermodel.expressions.core import (
    ONE,
    TIME,
    Expr,
    Substitution,
    SymbolKind,
    constant,
    divide,
    leaves,
    symbol,
    where,
)
from propermodel.expressions.derivatives import directional_derivative, partial_derivatives
from propermodel.modelling.model import Coordinate, ElementKind, Storage, Variable

# While a resistance is locked, or a switch holds a state, what remains of the flow (or effort) decays with this time
# constant, s; it is the slip left at closing.
RELAXATION = 0.02
LOCK_RELAXATION = constant(RELAXATION, "s")


@dataclass(frozen=True, slots=True)
class Inflow:
    """A rate that is an unknown: what is stored changes by the inflow."""

    element: Element
    unknown: Expr
    stored: Expr
    inflow: Expr


def formulate(causal: CausalGraph) -> EquationSystem:
    """The equations of a causal graph.

    Raises:
        StructureError: a signal or law asks for something that does not exist, or the system is singular.
    """
    definitions = define(causal)
    resolution = Resolution(definitions.values, definitions.laws)
    states, rates, inflows = _states(causal, resolution)
    faults = Faults(StructureError)
    unknowns = _unknowns(definitions, resolution, rates, inflows, faults)
    blocks = solve_blocks(unknowns, rates, faults)
    faults.raise_if_any()
    finish = Substitution(blocks.solution)
    values = {target: finish(value) for target, value in resolution.values.items()}
    events: tuple[SystemEvent, ...] = ()
    with faults.collecting():
        events = system_events(
            causal.graph.events, [s.symbol for s in states], lambda expr: finish(resolution.complete(expr))
        )
    with faults.collecting():
        _check_defined(causal, states, values, events)
    faults.raise_if_any()
    updates = tuple(
        (c.path, tuple((held, finish(resolution.complete(value))) for held, value in c.updates))
        for c in in_sequence(causal.graph)
    )
    finished = tuple(
        StateVariable(
            path=s.path,
            symbol=s.symbol,
            unit=s.unit,
            kind=s.kind,
            start=s.start,
            low=s.low,
            high=s.high,
            derivative=finish(s.derivative),
            source=s.source,
        )
        for s in states
    )
    return EquationSystem(
        causal=causal,
        states=finished,
        dependents=_dependents(definitions, resolution, states),
        closures=closures_of(causal, definitions, resolution, states),
        blocks=tuple(blocks.implicit),
        solved=tuple(blocks.solved),
        values=values,
        energies=_energies(causal, resolution, finish),
        rows=rows_of(causal),
        updates=updates,
        events=(*events, *rank_losses(blocks.solved)),
        impacts=impacts_of(causal, definitions, resolution, states, events, finish),
        modulations=modulations_of(causal, finished, lambda expr: finish(resolution.complete(expr))),
        switching=tuple(blocks.switching),
    )


# -- states --------------------------------------------------------------------------------------------


def _states(causal: CausalGraph, resolution: Resolution) -> tuple[list[StateVariable], dict[Expr, Expr], list[Inflow]]:
    """Every state with its derivative, the rates by symbol (time included), and rates that are unknowns."""
    states: list[StateVariable] = []
    inflows: list[Inflow] = []
    variables = causal.graph.variables
    for element in causal.graph.normal.elements.values():
        if not isinstance(element.behaviour, Storage):
            continue
        causality = causality_of(causal, element)
        if causality is None:
            states.extend(_storage_states(variables, element, element.behaviour, resolution))
        else:
            found, unknown = _field_states(variables, element, element.behaviour, causality, resolution)
            states.extend(found)
            inflows.extend(unknown)
    positions = positions_of(causal, resolution)
    states.extend(
        _state(
            signal.symbol.data.path.parent,
            signal.coordinate,
            StateKind.DISPLACEMENT if signal.symbol in positions else StateKind.SIGNAL,
            resolution.complete(signal.derivative),
            signal.source,
        )
        for signal in causal.graph.signal_states
    )
    states = [replace(state, start=_completed_start(state.start, resolution)) for state in states]
    rates = {state.symbol: state.derivative for state in states}
    rates[TIME] = ONE
    return states, rates, inflows


def _completed_start(start: Expr, resolution: Resolution) -> Expr:
    """A start in parameters, tables and states: the signals that it mentions resolved."""
    mentions_signals = any(leaf.data.kind is SymbolKind.SIGNAL for leaf in leaves(start))
    return resolution.complete(start) if mentions_signals else start


def _state(owner: Path, coordinate: Coordinate, kind: StateKind, derivative: Expr, source: Source) -> StateVariable:
    return StateVariable(
        path=owner / coordinate.name,
        symbol=symbol(SymbolKind.STATE, owner / coordinate.name, coordinate.unit),
        unit=coordinate.unit,
        kind=kind,
        start=coordinate.start,
        low=coordinate.low,
        high=coordinate.high,
        derivative=derivative,
        source=source,
    )


def _storage_states(
    variables: Variables, element: Element, storage: Storage, resolution: Resolution
) -> list[StateVariable]:
    """The states of a storage: its stored quantities change by what its bonds bring."""
    is_c = storage.kind is ElementKind.COMPLIANCE
    driver = Variable.FLOW if is_c else Variable.EFFORT
    bonds = variables.graph.normal.bonds
    state_kind = StateKind.DISPLACEMENT if is_c else StateKind.MOMENTUM
    symbols = [symbol(SymbolKind.STATE, element.path / c.name, c.unit) for c in storage.coordinates]
    inflows = [resolution.values[variables.of(bonds[element.path / port], driver)] for port, _ in storage.stored]
    if [expr for _, expr in storage.stored] == symbols:
        rates = inflows
    else:
        stored = [resolution.complete(expr) for _, expr in storage.stored]
        # Coordinates of the author's choice: (dq/dc) dc/dt = inflow.
        partials = partial_derivatives(stored, symbols)
        matrix = [[p.get(s, constant(0.0)) for s in symbols] for p in partials]
        rates = eliminate(matrix, inflows, [element.path] * len(symbols))
    return [
        _state(element.path, coordinate, state_kind, rate, element.source)
        for coordinate, rate in zip(storage.coordinates, rates, strict=True)
    ]


def _field_states(
    variables: Variables, element: Element, storage: Storage, causality: Mixed, resolution: Resolution
) -> tuple[list[StateVariable], list[Inflow]]:
    """The states of a field that keeps its integral causality at some ports.

    Where a port stores a coordinate itself, its inflow is the rate. Other coordinates have their rate as an unknown:
    the rate of what the port stores, in which also the coordinates decided elsewhere move, is the inflow.
    """
    is_c = storage.kind is ElementKind.COMPLIANCE
    driver = Variable.FLOW if is_c else Variable.EFFORT
    bonds = variables.graph.normal.bonds
    state_kind = StateKind.DISPLACEMENT if is_c else StateKind.MOMENTUM
    states: list[StateVariable] = []
    inflows: list[Inflow] = []
    for port, coordinate in causality.integral:
        rate = resolution.values[variables.of(bonds[element.path / port], driver)]
        if not is_coordinate(element, storage, port, coordinate):
            unknown = symbol(SymbolKind.UNKNOWN, element.path / f"{coordinate.name}_rate", "")
            inflows.append(Inflow(element, unknown, resolution.complete(dict(storage.stored)[port]), rate))
            rate = unknown
        states.append(_state(element.path, coordinate, state_kind, rate, element.source))
    return states, inflows


def _dependents(
    definitions: Definitions, resolution: Resolution, states: list[StateVariable]
) -> tuple[DependentStorage, ...]:
    """The dependent storages, and how the rates of the states change with theirs."""
    if not definitions.dependents:
        return ()
    reactions = impulse_slopes(states, [dependent.unknown for dependent in definitions.dependents])
    found: list[DependentStorage] = []
    for dependent, reaction in zip(definitions.dependents, reactions, strict=True):
        coordinate = dependent.coordinate
        target = state_symbol(dependent.element, coordinate)
        # Starts merge along what ports store; a coordinate of another kind only follows.
        merges = dependent.stored == target
        found.append(
            DependentStorage(
                element=dependent.element.path,
                path=target.data.path,
                symbol=target,
                unit=coordinate.unit,
                start=_completed_start(coordinate.start, resolution),
                stored=resolution.values[target],
                reactions=reaction if merges else (),
            )
        )
    return tuple(found)


# -- the implicit part -----------------------------------------------------------------------------------


def _unknowns(
    definitions: Definitions, resolution: Resolution, rates: dict[Expr, Expr], inflows: list[Inflow], faults: Faults
) -> list[Unknown]:
    """Every unknown with its residual: torn loops, laws to be solved, dependent storage, locks, closed loops."""
    found = [
        Unknown(unknown, unknown - resolution.torn_value(unknown), _owner(target), BlockKind.LOOP)
        for unknown, target in resolution.torn.items()
    ]
    found += [
        Unknown(
            implied.unknown,
            resolution.complete(implied.residual),
            implied.element.path,
            implied.kind,
            resolution.complete(implied.other),
        )
        for implied in definitions.implied
    ]
    found += [
        Unknown(struck.unknown, struck.unknown - resolution.complete(struck.law), struck.element.path, BlockKind.LOOP)
        for struck in definitions.struck
    ]
    answering = (*definitions.dependents, *definitions.lockables, *definitions.held)
    answers = {item.unknown for item in answering}
    # The rate of what a switch answers with may be infinite.
    answers |= {item.unknown for item in definitions.implied if item.kind is BlockKind.SWITCH}
    drifting = _RateUnknowns({unknown.symbol: unknown for unknown in found}, rates, answers)
    for dependent in definitions.dependents:
        with faults.collecting():
            rate = drifting.rate_of(resolution.complete(dependent.stored), dependent.element)
            residual = dependent.unknown - rate
            found.append(Unknown(dependent.unknown, residual, dependent.element.path, BlockKind.DEPENDENT))
    for inflow in inflows:
        with faults.collecting():
            rate = drifting.rate_of(inflow.stored, inflow.element)
            found.append(Unknown(inflow.unknown, inflow.inflow - rate, inflow.element.path, BlockKind.DEPENDENT))
    for lockable in definitions.lockables:
        with faults.collecting():
            flow = resolution.complete(lockable.flow)
            rate = drifting.rate_of(flow, lockable.element)
            residual = where(
                resolution.complete(lockable.locked),
                rate + divide(flow, LOCK_RELAXATION),
                lockable.unknown - resolution.complete(lockable.law),
            )
            found.append(Unknown(lockable.unknown, residual, lockable.element.path, BlockKind.LOCK))
    for held in definitions.held:
        with faults.collecting():
            excess = resolution.complete(held.flow - held.prescribed)
            if not answers.intersection(leaves(excess)):
                excess = drifting.rate_of(excess, held.element)
            found.append(Unknown(held.unknown, excess, held.element.path, BlockKind.CONSTRAINT))
    found.extend(drifting.unknowns)
    return found


def _owner(variable: Expr) -> Path:
    """The part of a signal or state, or the part of the port that another variable belongs to."""
    part = variable.data.path.parent
    return part if variable.data.kind in (SymbolKind.SIGNAL, SymbolKind.STATE) else part.parent


class _RateUnknowns:
    """Rates of change along the solution; the rate of an algebraic unknown is a further unknown."""

    def __init__(self, algebraic: dict[Expr, Unknown], rates: dict[Expr, Expr], answers: set[Expr]) -> None:
        self.algebraic = algebraic
        self.rates = dict(rates)
        self.answers = answers
        self.unknowns: list[Unknown] = []

    def rate_of(self, expr: Expr, element: Element) -> Expr:
        """The rate of an expression of states, time and algebraic unknowns."""
        met: list[tuple[Expr, Path, Expr]] = []
        pending = [expr]
        while pending:
            top = pending.pop()
            for leaf in leaves(top):
                if leaf.data.kind is not SymbolKind.UNKNOWN or leaf in self.rates:
                    continue
                if leaf in self.answers:
                    if is_independent(top, leaf):
                        continue
                    raise _higher_index(element, leaf)
                of = self.algebraic[leaf]
                path = leaf.data.path
                self.rates[leaf] = symbol(SymbolKind.UNKNOWN, path.parent / f"{path.name}_rate", "")
                met.append((self.rates[leaf], of.element, of.residual))
                pending.append(of.residual)
        self.unknowns.extend(
            Unknown(rate, self._derive(residual), path, BlockKind.LOOP) for rate, path, residual in met
        )
        return self._derive(expr)

    def _derive(self, expr: Expr) -> Expr:
        rates = {leaf: self.rates.get(leaf, constant(0.0)) for leaf in leaves(expr)}
        return directional_derivative([expr], rates)[0]


def _higher_index(element: Element, leaf: Expr) -> StructureError:
    return StructureError(
        [
            Diagnostic(
                "equations/index",
                f"the dependent storage {element.path} depends on the reaction of {leaf.data.path.parent}",
                source=element.source,
                involved=(Involved(str(element.path), "is dependent storage", element.source),),
                help="a closed kinematic chain: put a compliance into it, or choose coordinates that respect it",
            )
        ]
    )


# -- what else the system needs ----------------------------------------------------------------------------


def _energies(causal: CausalGraph, resolution: Resolution, finish: Substitution) -> tuple[Stored, ...]:
    return tuple(
        Stored(element.path, finish(resolution.complete(element.behaviour.energy)))
        for element in causal.graph.normal.elements.values()
        if isinstance(element.behaviour, Storage)
    )


def _check_defined(
    causal: CausalGraph, states: list[StateVariable], values: dict[Expr, Expr], events: tuple[SystemEvent, ...]
) -> None:
    """Everything that derivatives, laws and signals mention exists."""
    free = {SymbolKind.TIME, SymbolKind.PARAMETER, SymbolKind.TABLE, SymbolKind.STATE, SymbolKind.DISCRETE}
    free.add(SymbolKind.UNKNOWN)
    known = {state.symbol for state in states}
    missing: dict[Expr, str] = {}
    needs = [*((str(s.path), s.derivative) for s in states), *_signal_values(causal, values)]
    needs += [(str(e.element), expr) for e in events for expr in (e.guard, *(value for _, value in e.changes))]
    needs += [(str(e.element), e.restitution) for e in events if e.restitution is not None]
    for owner, expr in needs:
        for leaf in leaves(expr):
            kind = leaf.data.kind
            if kind not in free or (kind is SymbolKind.STATE and leaf not in known):
                missing.setdefault(leaf, owner)
    if missing:
        raise StructureError(
            [
                Diagnostic(
                    "equations/undefined",
                    f"'{leaf.data.path}' does not exist in this model, but {owner} needs it",
                    help="after a reduction, freeze the signal that reads it; otherwise check the path",
                )
                for leaf, owner in missing.items()
            ]
        )


def _signal_values(causal: CausalGraph, values: dict[Expr, Expr]) -> list[tuple[str, Expr]]:
    return [(str(leaf.data.path), values[leaf]) for leaf in causal.graph.signals if leaf in values]
