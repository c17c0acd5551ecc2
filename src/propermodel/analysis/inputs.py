"""What can be an input of a linear model: inputs of the scenario, sources, and what controllers hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from propermodel.bondgraph.graph import FlatTable
from propermodel.codegen.lower import Lowered, lower
from propermodel.codegen.machine import Memory, TableData
from propermodel.codegen.program import Array, Assign
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Path, SimulationError, one_of
from propermodel.equations.formulate import formulate
from propermodel.equations.system import EquationSystem
from propermodel.expressions.core import TIME, ZERO, Expr, SymbolKind, is_zero, leaves, lookup, slope, symbol
from propermodel.modelling.model import ElementKind, PowerSource, TableSpec, TableValues, Variable
from propermodel.simulation.observables import observable_path

_NOTHING = TableValues(((0.0, 1.0),), (0.0, 0.0))


@dataclass(frozen=True, slots=True)
class InputVariable:
    """An input: its name and unit, and the node that carries it (for a source: what is added to its value)."""

    path: Path
    unit: str
    node: Expr
    value: Expr  # its value at the operating point
    rate: Expr | None = None  # the node that carries its rate of change, where it may be needed


@dataclass(frozen=True, eq=False)
class Opened:
    """A system whose chosen inputs are nodes of its expressions, with the memory of a point in it."""

    system: EquationSystem
    lowered: Lowered
    memory: Memory
    inputs: tuple[InputVariable, ...]

    @cached_property
    def signals(self) -> tuple[Expr, ...]:
        """The expression of every entry of the program's signals."""
        return tuple(step.value for step in self.lowered.program.observe.steps if isinstance(step, Assign))


def open_inputs(compiled: CompiledModel, memory: Memory, chosen: Iterable[Expr | Path | str] | None) -> Opened:
    """The system with inputs opened: by default those of the scenario, or where there are none, the sources.

    Args:
        compiled: The model.
        memory: The point.
        chosen: Root inputs and prescribed ports (`road.flow`), sources (`supply`, or a variable of its port), and
            outputs of controllers.

    Raises:
        SimulationError: one of them is none of these.
    """
    graph = compiled.graph
    tables = {path: table for path, table in graph.tables.items() if table.is_input}
    sources = _sources(compiled)
    held = {item.data.path: item for item in compiled.lowered.held}
    by_port = {path: name for name, source in sources.items() for path in (source.port, *source.variables)}
    if chosen is None:
        names = list(tables) or [
            name for name, source in sources.items() if not source.is_zero and name not in graph.activated_sources
        ]
    else:
        names: list[Path] = []
        faults = Faults(SimulationError)
        for path in map(observable_path, chosen):
            found = by_port.get(path, path)
            if found not in tables and found not in sources and found not in held:
                known = (*tables, *sources, *held)
                faults.add(
                    Diagnostic(
                        "linear/unknown-input",
                        f"'{path}' is no input, source or output of a controller of this model",
                        help=one_of(str(path), map(str, known), "this model has no inputs or sources"),
                    )
                )
            names.append(found)
        faults.raise_if_any()
    names = list(dict.fromkeys(names))
    added = [sources[name] for name in names if name not in tables and name in sources]
    system, lowered = (compiled.system, compiled.lowered) if not added else _with_added(compiled, added)
    inputs: list[InputVariable] = []
    for name in names:
        if name in tables:
            leaf = tables[name].symbol
            node = lookup(leaf, TIME)
            # An input that acts on nothing has no place in the program.
            value = node if leaf in lowered.program.layout.table_index else ZERO
            inputs.append(InputVariable(name, leaf.data.unit, node, value, slope(leaf, 0, TIME)))
        elif name in sources:
            source = sources[name]
            leaf = source.table.symbol
            value = system.values[source.variable]
            inputs.append(InputVariable(name, leaf.data.unit, lookup(leaf, TIME), value, slope(leaf, 0, TIME)))
        else:
            inputs.append(InputVariable(name, held[name].data.unit, held[name], held[name]))
    moved = memory if not added else _moved(memory, compiled.lowered, lowered)
    return Opened(system, lowered, moved, tuple(inputs))


@dataclass(frozen=True, slots=True)
class _Source:
    element: Path
    port: Path
    variables: tuple[Path, ...]
    variable: Expr  # the symbol of what it prescribes
    table: FlatTable  # what is added to it
    is_zero: bool


def _sources(compiled: CompiledModel) -> dict[Path, _Source]:
    """The sources that no input of the scenario drives directly, by element."""
    graph = compiled.graph
    variables = graph.variables
    at = graph.normal.at()
    inputs = {table.symbol for table in graph.tables.values() if table.is_input}
    found: dict[Path, _Source] = {}
    for element in graph.normal.elements.values():
        behaviour = element.behaviour
        if not isinstance(behaviour, PowerSource) or inputs & set(leaves(behaviour.value)):
            continue
        (bond,) = at[element.path]
        is_effort = behaviour.kind is ElementKind.EFFORT_SOURCE
        variable = variables.of(bond, Variable.EFFORT if is_effort else Variable.FLOW)
        path = element.path / "added"
        unit = variable.data.unit
        spec = TableSpec(name="added", unit=unit, coordinate_units=("s",), extrapolation="hold", values=_NOTHING)
        leaf = symbol(SymbolKind.TABLE, path, unit)
        port = element.path / element.ports[0]
        value = behaviour.value
        found[element.path] = _Source(
            element.path,
            port,
            (port / "effort", port / "flow"),
            variable,
            FlatTable(path=path, symbol=leaf, spec=spec, values=_NOTHING, is_input=True),
            is_zero(_resolved(compiled, value)),
        )
    return found


def _resolved(compiled: CompiledModel, value: Expr) -> Expr:
    """What a parameter is defined as, down to a number or a formula."""
    known = {parameter.symbol: parameter.value for parameter in compiled.graph.parameters.values()}
    seen: set[Expr] = set()
    while value in known and value not in seen:
        seen.add(value)
        value = known[value]
    return value


def _with_added(compiled: CompiledModel, sources: list[_Source]) -> tuple[EquationSystem, Lowered]:
    """The system in which a further input is added to each of these sources."""
    graph = compiled.graph
    elements = dict(graph.normal.elements)
    for source in sources:
        element = elements[source.element]
        assert isinstance(element.behaviour, PowerSource)
        value = element.behaviour.value + lookup(source.table.symbol, TIME)
        elements[source.element] = replace(element, behaviour=replace(element.behaviour, value=value))
    opened = replace(
        graph,
        normal=replace(graph.normal, elements=elements),
        tables={**graph.tables, **{source.table.path: source.table for source in sources}},
    )
    system = formulate(replace(compiled.system.causal, graph=opened))
    return system, lower(system)


def _moved(memory: Memory, before: Lowered, after: Lowered) -> Memory:
    """The same point in a program with further inputs."""

    def spread(array: Array, values: Iterable[float]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        known: Mapping[Expr, int] = {
            leaf: slot.index for leaf, slot in before.program.layout.slots.items() if slot.array is array
        }
        old = list(values)
        result = np.zeros(after.program.layout.lengths[array])
        for leaf, slot in after.program.layout.slots.items():
            if slot.array is array and leaf in known:
                result[slot.index] = old[known[leaf]]
        return result

    tables = dict(zip(before.tables, memory.tables, strict=True))
    nothing = TableData(tuple(np.array(grid) for grid in _NOTHING.grids), np.array(_NOTHING.values))
    moved = memory.copy()
    moved.parameter = spread(Array.PARAMETER, memory.parameter)
    moved.unknown = spread(Array.UNKNOWN, memory.unknown)
    moved.tables = tuple(tables.get(path, nothing) for path in after.tables)
    return moved
