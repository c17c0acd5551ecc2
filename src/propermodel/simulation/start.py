"""The working memory at the start of a run: parameters, tables, states and held values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.parameters import faults_of_range, in_unit
from propermodel.bondgraph.parameters import parameter_values as find_values
from propermodel.causality.transformer_loops import redundant_loops
from propermodel.codegen.lower import numbers_of
from propermodel.codegen.machine import FloatArray, Memory, start_memory
from propermodel.codegen.program import Array
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Path, SimulationError, one_of
from propermodel.equations.system import EquationSystem, StateKind
from propermodel.expressions.core import TIME, Expr, SymbolKind, leaves
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import Scenario, Storage, TableValues
from propermodel.simulation.consistent import close_loops, keep_loops_closed
from propermodel.simulation.evaluate import HeldTable
from propermodel.simulation.finite import faults_of_scenario, faults_of_values
from propermodel.simulation.merging import Starts, merge_starts
from propermodel.simulation.point import Point
from propermodel.simulation.singular_fields import singular_fields
from propermodel.simulation.switches import Switches, unsettled
from propermodel.simulation.table_store import StoredTable, TableStore

Values = dict[Expr, float]


@dataclass(frozen=True)
class Start:
    """The memory at the start of a run, and what must be said about it."""

    memory: Memory
    notes: tuple[str, ...]


def parameter_values(compiled: CompiledModel, overrides: Mapping[Path, float]) -> Values:
    """The value of every parameter, in SI; overrides replace what the model says.

    Raises:
        SimulationError: an override names no parameter, or a parameter leaves its declared range.
    """
    faults = Faults(SimulationError)
    values = _parameter_values(compiled, overrides, faults)
    faults.raise_if_any()
    return values


def _parameter_values(compiled: CompiledModel, overrides: Mapping[Path, float], faults: Faults) -> Values:
    """The value of every parameter; overrides that cannot be are left out."""
    flat = compiled.graph.parameters
    fitting: dict[Path, float] = {}
    for path, value in overrides.items():
        if path not in flat:
            faults.add(
                Diagnostic(
                    "simulation/unknown-parameter",
                    f"the model has no parameter '{path}'",
                    help=one_of(str(path), map(str, flat), "this model has no parameters"),
                )
            )
        elif not math.isfinite(value):
            faults.add(
                Diagnostic(
                    "simulation/parameter-range",
                    f"'{path}' = {in_unit(value, flat[path].unit)} is no finite number",
                    source=flat[path].source,
                    help="give a finite value in SI",
                )
            )
        else:
            fitting[path] = value
    values = find_values(flat, fitting)
    help = "give a value in SI inside the range, which stands where the parameter is declared"
    faults.found.extend(faults_of_range("simulation/parameter-range", flat.values(), values, help))
    return values


def begin(compiled: CompiledModel, scenario: Scenario) -> Memory:
    """The memory of a run at its start.

    Raises:
        SimulationError: the scenario names something that does not exist, or its numbers do not fit.
    """
    return start_of(compiled, scenario).memory


def start_of(compiled: CompiledModel, scenario: Scenario, store: TableStore | None = None) -> Start:
    """The memory of a run at its start, with notes on starts that could not be kept as declared.

    Args:
        compiled: The model.
        scenario: The scenario.
        store: Tables that other runs have brought, and this one may; by default the run has its own.

    Raises:
        SimulationError: the scenario names something that does not exist, its numbers do not fit, or no start keeps
            what dependent storage should hold.
    """
    store = TableStore() if store is None else store
    faults = Faults(SimulationError)
    flat = compiled.graph.parameters
    parameters = _parameter_values(compiled, scenario.parameters, faults)
    faults.found.extend(redundant_loops(compiled.graph, compiled.transformer_loops, parameters))
    faults.found.extend(faults_of_scenario(scenario, store))
    faults.found.extend(
        faults_of_values("parameter", ((p.path, parameters[p.symbol], p.source) for p in flat.values()))
    )
    tables = _tables(compiled, scenario, store, faults)
    given = _initial_states(compiled, scenario, parameters, faults)
    held = _held(compiled, scenario, parameters)
    faults.raise_if_any()
    known = parameters | dict(zip(compiled.lowered.held, held, strict=True))
    starts = _starts(compiled, scenario, given, known, tables)
    for fault in singular_fields(compiled.system, starts.values, starts.tables):
        faults.add(fault)
    faults.raise_if_any()
    states, notes = _settled(compiled.system, starts, known)
    faults.found.extend(
        faults_of_values(
            "state", ((s.path, value, s.source) for s, value in zip(compiled.system.states, states, strict=True))
        )
    )
    faults.raise_if_any()
    program = compiled.lowered.program
    limits = _grid_limits(tables)
    memory = start_memory(
        program,
        {
            Array.STATE: states,
            Array.DISCRETE: held,
            Array.UNKNOWN: _guesses(compiled, starts),
            Array.PARAMETER: [
                parameters[flat[path].symbol] if path in flat else limits[path] for path in compiled.lowered.parameters
            ],
        },
        tables=[table.data for table in tables.values()],
        origin=scenario.start,
    )
    if compiled.system.switching:
        _position_switches(compiled, memory)
    memory.lower[:] = [interpret(state.low, parameters) for state in compiled.system.states]
    memory.upper[:] = [interpret(state.high, parameters) for state in compiled.system.states]
    return Start(memory, notes)


def _tables(compiled: CompiledModel, scenario: Scenario, store: TableStore, faults: Faults) -> dict[Path, StoredTable]:
    flat = compiled.graph.tables
    found: dict[Path, StoredTable] = {}
    for path in (*scenario.tables, *scenario.inputs):
        if path not in flat:
            faults.add(
                Diagnostic(
                    "simulation/unknown-input",
                    f"scenario '{scenario.name}' gives '{path}', which is no input or table of this model",
                    help=one_of(str(path), map(str, flat), "this model has no inputs or tables"),
                )
            )
    for index, path in enumerate(compiled.lowered.tables):
        table = flat[path]
        values = scenario.tables.get(path, table.values)
        if path in scenario.inputs:
            values = _input(scenario.inputs[path], scenario, store)
        slot = compiled.lowered.program.layout.tables[index]
        stored = store.get(values)
        if len(values.grids) != slot.dimensions or (slot.is_uniform and not stored.is_uniform):
            faults.add(
                Diagnostic(
                    "simulation/table-shape",
                    f"the table '{path}' was compiled with {slot.dimensions} coordinate(s)"
                    f"{' on equidistant grids' if slot.is_uniform else ''}; the scenario gives another shape",
                    help="give the table of the model the same kind of grid",
                )
            )
        found[path] = stored
    return found


def _input(value: float | TableValues, scenario: Scenario, store: TableStore) -> TableValues:
    if isinstance(value, TableValues):
        return value
    end = scenario.stop if scenario.stop > scenario.start else scenario.start + 1.0
    return store.constant(float(value), scenario.start, end)


def _grid_limits(tables: Mapping[Path, StoredTable]) -> dict[Path, float]:
    """The ends of table grids, which the program reads as parameters to count the time spent outside."""
    found: dict[Path, float] = {}
    for path, table in tables.items():
        for axis, grid in enumerate(table.values.grids):
            found[path / f"low{axis}"] = grid[0]
            found[path / f"high{axis}"] = grid[-1]
    return found


def _starts(
    compiled: CompiledModel,
    scenario: Scenario,
    given: Mapping[Path, float],
    known: Values,
    tables: Mapping[Path, StoredTable],
) -> Starts:
    """What the states and dependent storage are declared to start with."""
    system = compiled.system
    values = {**known, TIME: scenario.start}
    for item in (*system.states, *system.dependents):
        start = given.get(item.path)
        if start is not None or all(leaf in known for leaf in leaves(item.start)):
            values[item.symbol] = interpret(item.start, known) if start is None else start
    held = {p: HeldTable(t.data, compiled.graph.tables[p].spec.extrapolation == "hold") for p, t in tables.items()}
    starts = Starts(values, held, frozenset(given))
    return replace(starts, values=values | _following(system, starts, known))


def _following(system: EquationSystem, starts: Starts, known: Iterable[Expr]) -> Values:
    """Starts that their authors give in signals, such as the stretch of a spring between two places."""
    items = [
        item
        for item in (*system.states, *system.dependents)
        if item.path not in starts.given and not all(leaf in known for leaf in leaves(item.start))
    ]
    values = starts.at([item.start for item in items], {})
    return dict(zip((item.symbol for item in items), map(float, values), strict=True))


def _settled(system: EquationSystem, starts: Starts, known: Iterable[Expr]) -> tuple[list[float], tuple[str, ...]]:
    """The states at the start, on the constraints and with what dependent storage holds merged into them; notes."""
    changed, notes = close_loops(system, starts)
    if changed:
        now = replace(starts, values={**starts.values, **changed})
        starts = replace(starts, values={**starts.values, **_following(system, now, known)})
    for further in (merge_starts, keep_loops_closed):
        more, said = further(system, replace(starts, values={**starts.values, **changed}))
        changed, notes = {**changed, **more}, (*notes, *said)
    return [changed.get(state.symbol, starts.values[state.symbol]) for state in system.states], notes


def _guesses(compiled: CompiledModel, starts: Starts) -> FloatArray:
    """Where Newton's method begins: a coordinate of dependent storage at its declared start, all else at zero."""
    declared = {item.path: starts.values[item.symbol] for item in compiled.system.dependents}
    found = np.zeros(compiled.lowered.program.layout.lengths.get(Array.UNKNOWN, 0))
    # The unknowns of the system come first, those of corrections to constraints follow.
    unknowns = [unknown for block in compiled.system.blocks for unknown in block.unknowns]
    found[: len(unknowns)] = [declared.get(unknown.data.path, 0.0) for unknown in unknowns]
    return found


def _position_switches(compiled: CompiledModel, memory: Memory) -> None:
    """Let switches be where they start; which of them move at once, a run finds out."""
    unsettled(compiled.lowered, memory.unknown)
    numbers = [number for switching in compiled.system.switching for number in numbers_of(switching)]
    switches = Switches(compiled.lowered, lambda now: Point(compiled.system, compiled.lowered, now).values(numbers))
    switches.pull(memory, 0.0)


def _initial_states(
    compiled: CompiledModel, scenario: Scenario, parameters: Values, faults: Faults
) -> dict[Path, float]:
    """Initial values of a scenario by state: given as the state itself, or as the variable it decides at its port.

    A model that was reduced runs the scenarios of the full one: starts of elements that were removed are left out.
    """
    states = {s.path for s in (*compiled.system.states, *compiled.system.dependents)}
    held = {h.data.path for h in compiled.lowered.held}
    found: dict[Path, float] = {}
    for path, value in scenario.initial.items():
        if path in states:
            found[path] = value
        elif (
            path in held
            or _at_port(compiled, path, value, parameters, found)
            or _at_merged(compiled, path, value, parameters, found)
            or _is_removed(compiled, path)
        ):
            continue
        else:
            faults.add(
                Diagnostic(
                    "simulation/unknown-initial",
                    f"scenario '{scenario.name}' gives a start for '{path}', which is no state of this model",
                    help=one_of(str(path), map(str, (*states, *held)), "this model has no states"),
                )
            )
    return found


def _is_removed(compiled: CompiledModel, path: Path) -> bool:
    """Whether a path leads to an element that only the model without removals has."""
    merged = compiled.graph.merged
    if not compiled.model.removals or any(path.parent in (name, name.parent) for name in merged):
        return False
    full = flatten(replace(compiled.model, removals=())).normal.elements
    owners = [Path(path[:length]) for length in range(1, len(path))]
    return any(owner in full and owner not in compiled.graph.normal.elements for owner in owners)


def _at_merged(compiled: CompiledModel, path: Path, value: float, parameters: Values, found: dict[Path, float]) -> bool:
    """Whether a path is the variable that merged elements share: it is the start of the element that stands for all."""
    absorbed = compiled.graph.merged.get(path.parent)
    if absorbed is None or path.name != absorbed.kind.common.value:
        return False
    port = compiled.graph.normal.elements[absorbed.merged].ports[0]
    own = value / interpret(absorbed.factor, parameters)
    return _at_port(compiled, absorbed.merged / port / path.name, own, parameters, found)


def _at_port(compiled: CompiledModel, path: Path, value: float, parameters: Values, found: dict[Path, float]) -> bool:
    element = compiled.graph.normal.elements.get(Path(path[:-2]))
    if element is None or not isinstance(element.behaviour, Storage):
        return False
    storage = element.behaviour
    state = element.path / storage.coordinates[0].name
    if path.name in (StateKind.DISPLACEMENT.value, StateKind.MOMENTUM.value) and len(storage.coordinates) == 1:
        found[state] = value
        return True
    if storage.inverse is None or path.name not in ("effort", "flow"):
        return False
    driver = next(
        (leaf for leaf in leaves(storage.inverse) if leaf.data.kind in (SymbolKind.EFFORT, SymbolKind.FLOW)),
        None,
    )
    if driver is None or driver.data.path != path:
        return False
    found[state] = interpret(storage.inverse, {**parameters, driver: value})
    return True


def _held(compiled: CompiledModel, scenario: Scenario, parameters: Values) -> list[float]:
    starts = dict(compiled.graph.held)
    return [scenario.initial.get(held.data.path, interpret(starts[held], parameters)) for held in compiled.lowered.held]
