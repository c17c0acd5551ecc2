"""All equations of a model, linear in small deviations: one row for each, whatever its causality.

The columns are the efforts and flows of all bonds, signals, stored quantities, states, and unknowns; the rows are what
defines them (junctions, two-ports, laws, signals), the residuals of what is implied, and the rates of states:

    (M_0 + s M_1 + sum over controllers of exp(s T) M_T) w = 0,      s the variable of Laplace's transformation

Nothing is eliminated, so an element is taken away by one other row in the place of its law: its effort or its flow
does not deviate any more. What a controller holds follows the signals that it reads, one period T later; its decisions
(what stands in conditions) do not deviate.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from propermodel.bondgraph.graph import Bond, Element
from propermodel.causality.causal import CausalGraph
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.equations.definitions import Definitions, define
from propermodel.equations.fields import causality_of, state_symbol
from propermodel.equations.sequence import in_sequence
from propermodel.expressions.core import ONE, ZERO, Expr, Op, SymbolKind, leaves, where
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.modelling.model import ElementKind, Resistive, Storage, Variable

_GIVEN = frozenset({SymbolKind.TIME, SymbolKind.PARAMETER, SymbolKind.TABLE})


@dataclass(frozen=True, slots=True)
class Entry:
    """A coefficient of the equations: of a column, in a row, the derivative of what stands there."""

    row: int
    column: int
    value: Expr
    is_rate: bool = False  # in M_1
    period: Expr | None = None  # in M_T


@dataclass(frozen=True, slots=True)
class Law:
    """The row of a law at a bond, and the columns of the element's own variables on its right side."""

    bond: Path
    row: int
    element: Path
    own: tuple[int, ...]


@dataclass(frozen=True)
class Tableau:
    """The equations of a model by their coefficients, which are expressions of the variables themselves."""

    compiled: CompiledModel
    columns: Mapping[Expr, int]
    entries: tuple[Entry, ...]
    laws: tuple[Law, ...]
    subjects: tuple[Expr, ...]  # of each row: the variable that it defines, or the unknown that it answers with

    @property
    def size(self) -> int:
        """The number of equations."""
        return len(self.columns)

    def owner(self, row: int) -> Path:
        """The part of the model that an equation belongs to."""
        subject = self.subjects[row]
        part = subject.data.path.parent
        return part if subject.data.kind in (SymbolKind.SIGNAL, SymbolKind.STATE) or not part.parent else part.parent

    def column(self, path: Path) -> int | None:
        """The column of an observable; None if it deviates from nothing (a parameter, a constant)."""
        return next((index for leaf, index in self.columns.items() if leaf.data.path == path), None)

    def column_of(self, bond: Bond, variable: Variable) -> int:
        """The column of the effort or flow of a bond."""
        return self.columns[self.compiled.graph.variables.of(bond, variable)]


def tableau_of(compiled: CompiledModel, outputs: Iterable[Path]) -> Tableau:
    """The equations of all that the energy elements and some outputs depend on."""
    return _Builder(compiled, frozenset(outputs)).tableau()


@dataclass(frozen=True, slots=True)
class _Row:
    """An equation: `left` - `right` - s `stored` = 0, where given; a residual `answers` with an unknown.

    What a controller holds is `left` one `period` later.
    """

    left: Expr | None
    right: Expr
    stored: Expr | None = None
    answers: Expr | None = None
    period: Expr | None = None


class _Builder:
    def __init__(self, compiled: CompiledModel, outputs: frozenset[Path]) -> None:
        self._compiled = compiled
        self._causal: CausalGraph = compiled.system.causal
        self._graph = compiled.graph
        self._definitions: Definitions = define(self._causal)
        self._outputs = outputs

    def tableau(self) -> Tableau:
        rows = self._needed([*self._defined(), *self._residuals(), *self._rates()])
        columns = {leaf: index for index, leaf in enumerate(self._variables(rows))}
        if len(columns) != len(rows):
            raise AssertionError(f"{len(rows)} equations for {len(columns)} variables")
        return Tableau(
            compiled=self._compiled,
            columns=columns,
            entries=tuple(self._entries(rows, columns)),
            laws=tuple(self._laws(rows, columns)),
            subjects=tuple(map(_subject, rows)),
        )

    # -- rows ------------------------------------------------------------------------------------------

    def _defined(self) -> Iterator[_Row]:
        for target, value in self._definitions.values.items():
            yield _Row(target, value)

    def _residuals(self) -> Iterator[_Row]:
        found = self._definitions
        for dependent in found.dependents:
            yield _Row(dependent.unknown, ZERO, dependent.stored)
        for implied in found.implied:
            yield _Row(None, implied.residual, answers=implied.unknown)
        for struck in found.struck:
            yield _Row(struck.unknown, struck.law)
        for lockable in found.lockables:
            residual = where(lockable.locked, lockable.flow, lockable.unknown - lockable.law)
            yield _Row(None, residual, answers=lockable.unknown)
        for held in found.held:
            yield _Row(None, held.flow - held.prescribed, answers=held.unknown)

    def _rates(self) -> Iterator[_Row]:
        """The rates of states: stored quantities change by what their ports bring."""
        bonds = self._graph.normal.bonds
        for element in self._graph.normal.elements.values():
            storage = element.behaviour
            if not isinstance(storage, Storage):
                continue
            driver = Variable.FLOW if storage.kind is ElementKind.COMPLIANCE else Variable.EFFORT
            causality = causality_of(self._causal, element)
            derivative = set[str]() if causality is None else {port for port, _ in causality.derivative}
            for port, stored in storage.stored:
                if port not in derivative:
                    inflow = self._graph.variables.of(bonds[element.path / port], driver)
                    yield _Row(None, inflow, -stored)
        for controller in in_sequence(self._graph):
            for held, value in controller.updates:
                yield _Row(held, value, period=controller.period)
        for state in self._graph.signal_states:
            yield _Row(None, state.derivative, -state.symbol)

    def _needed(self, rows: list[_Row]) -> list[_Row]:
        """The rows without those of observables that nobody asks for."""
        defines = {row.left: row for row in rows if row.left is not None and not _is_unknown(row.left)}
        kept: dict[int, _Row] = {id(row): row for row in rows if row.left is None or _is_unknown(row.left)}
        pending = [leaf for row in kept.values() for leaf in _mentioned(row)]
        variables = self._graph.variables
        for bond in self._graph.normal.bonds.values():
            pending += [variables.of(bond, variable) for variable in Variable]
        pending += [leaf for leaf in defines if leaf.data.path in self._outputs]
        while pending:
            row = defines.get(pending.pop())
            if row is not None and id(row) not in kept:
                kept[id(row)] = row
                pending += _mentioned(row)
        return [row for row in rows if id(row) in kept]

    def _variables(self, rows: list[_Row]) -> Iterable[Expr]:
        every = dict.fromkeys(leaf for row in rows for leaf in _mentioned(row))
        updated = {held for controller in self._graph.controllers for held, _ in controller.updates}
        return [
            leaf
            for leaf in every
            if leaf.data.kind not in _GIVEN and (leaf.data.kind is not SymbolKind.DISCRETE or leaf in updated)
        ]

    # -- coefficients ----------------------------------------------------------------------------------

    def _entries(self, rows: list[_Row], columns: Mapping[Expr, int]) -> Iterator[Entry]:
        slopes = partial_derivatives([row.right for row in rows], columns)
        rates = partial_derivatives([row.stored if row.stored is not None else ZERO for row in rows], columns)
        for number, row in enumerate(rows):
            if row.left is not None:
                yield Entry(number, columns[row.left], ONE, period=row.period)
            for leaf, slope in slopes[number].items():
                yield Entry(number, columns[leaf], -slope)
            for leaf, slope in rates[number].items():
                yield Entry(number, columns[leaf], -slope, is_rate=True)

    def _laws(self, rows: list[_Row], columns: Mapping[Expr, int]) -> Iterator[Law]:
        """For every port of an energy element the row in which its law stands."""
        of = {row.answers if row.left is None else row.left: number for number, row in enumerate(rows)}
        for element in self._graph.normal.elements.values():
            if isinstance(element.behaviour, Resistive | Storage):
                for port in element.ports:
                    bond = self._graph.normal.bonds[element.path / port]
                    into = self._causal.receives_effort(bond, element)
                    answer = self._graph.variables.of(bond, Variable.FLOW if into else Variable.EFFORT)
                    row = of[answer]
                    if _is_unknown(rows[row].right):
                        row = of[rows[row].right]
                    yield Law(bond.name, row, element.path, self._own(element, rows[row].right, columns))

    def _own(self, element: Element, law: Expr, columns: Mapping[Expr, int]) -> tuple[int, ...]:
        """The columns of the element's own port variables and coordinates in a law."""
        own = {
            self._graph.variables.of(self._graph.normal.bonds[element.path / port], variable)
            for port in element.ports
            for variable in Variable
        }
        if isinstance(element.behaviour, Storage):
            own |= {state_symbol(element, coordinate) for coordinate in element.behaviour.coordinates}
        return tuple(columns[leaf] for leaf in leaves(law) if leaf in own)


def _is_unknown(expr: Expr) -> bool:
    return expr.op is Op.SYMBOL and expr.data.kind is SymbolKind.UNKNOWN


def _subject(row: _Row) -> Expr:
    """What an equation is there for."""
    found = row.answers if row.left is None else row.left
    return found if found is not None else next(leaf for leaf in _mentioned(row) if leaf.data.kind not in _GIVEN)


def _mentioned(row: _Row) -> Sequence[Expr]:
    parts = [part for part in (row.left, row.right, row.stored) if part is not None]
    return leaves(*parts)
