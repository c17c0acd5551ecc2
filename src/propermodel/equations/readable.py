"""State equations that people can read: physical names, short formulas, what was left out defined once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from propermodel.bondgraph.graph import BondGraph, FlatEvent
from propermodel.diagnostics import ModelError, Path, nearest, parse_path
from propermodel.equations.names import Name, input_symbols, parameter_aliases, quantity_symbol, shortest_names
from propermodel.equations.system import EquationSystem, StateVariable
from propermodel.expressions.core import (
    ONE,
    TIME,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    divide,
    is_zero,
    leaves,
    lookup,
    multiply,
    postorder,
    substitute,
    symbol,
)
from propermodel.expressions.derivatives import derivative
from propermodel.expressions.simplify import Simplifier
from propermodel.modelling.model import ElementKind, Resistive, Storage, Variable

if TYPE_CHECKING:
    from propermodel.equations.to_sympy import SymPyEquations

# A physical quantity that is used more than once is defined by itself when its formula has more operands than this.
LONGEST_REPEATED = 12
# Any part of an equation with more operands than this is defined by itself.
LONGEST = 40


@dataclass(frozen=True, slots=True)
class ReadableState:
    """The equation of one state, `coefficient` times its rate equals `right`.

    A storage whose law divides the stored quantity by parameters is shown by its flow or effort (m v', C u'), any
    other by what it stores.
    """

    path: Path  # of the state in the equation system
    symbol: Expr  # what the equation is written in
    unit: str
    coefficient: Expr
    right: Expr
    group: Path  # the part of the model that it belongs to

    @property
    def derivative(self) -> Expr:
        """The rate of the symbol."""
        return divide(self.right, self.coefficient)


@dataclass(frozen=True, slots=True)
class Definition:
    """A quantity that equations mention by name because written out it would make them long."""

    symbol: Expr
    unit: str
    value: Expr


@dataclass(frozen=True, slots=True)
class ReadableBlock:
    """Unknowns that are solved for together; each residual is zero."""

    unknowns: tuple[Expr, ...]
    residuals: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class ReadableUpdate:
    """What a controller gives its held values when it runs."""

    controller: Path
    values: tuple[tuple[Expr, Expr], ...]


@dataclass(frozen=True, slots=True)
class ReadableEvent:
    """What becomes what at the instant at which a condition becomes true; values are those before it."""

    element: Path
    condition: Expr
    changes: tuple[tuple[Expr, Expr], ...]


@dataclass(frozen=True)
class ReadableEquations:
    """The equations of a model in names and formulas.

    `definitions` stand in an order in which they can be computed; `names` has every symbol that occurs.
    """

    title: str
    states: tuple[ReadableState, ...]
    definitions: tuple[Definition, ...]
    blocks: tuple[ReadableBlock, ...]
    outputs: tuple[Definition, ...]
    updates: tuple[ReadableUpdate, ...]
    events: tuple[ReadableEvent, ...]
    inputs: tuple[Expr, ...]
    names: Mapping[Expr, Name]

    def text(self) -> str:
        """The equations as plain text."""
        from propermodel.equations.written import text_of

        return text_of(self)

    def markdown(self) -> str:
        """The equations as Markdown with formulas in dollars and a table of symbols."""
        from propermodel.equations.written import markdown_of

        return markdown_of(self)

    def latex(self) -> str:
        """The equations as LaTeX, one `align*` for the states and one for what they mention (needs amsmath)."""
        from propermodel.equations.written import latex_of

        return latex_of(self)

    def to_sympy(self) -> SymPyEquations:
        """The equations as SymPy expressions, for which SymPy must be installed."""
        from propermodel.equations.to_sympy import sympy_equations

        return sympy_equations(self)

    def __str__(self) -> str:
        return self.text()


class HasEquations(Protocol):
    """What has an equation system, as a compiled model has."""

    @property
    def system(self) -> EquationSystem:
        """The equations."""
        ...


def state_equations(of: EquationSystem | HasEquations, outputs: Iterable[Path | str] = ()) -> ReadableEquations:
    """The state equations of a compiled model, simplified, substituted as far as it helps, and grouped by part.

    `outputs` are efforts, flows and signals to be written in the same terms. A model without states is written as
    what its elements answer with.

    A physical quantity that occurs more than once is defined by itself when it has more than `LONGEST_REPEATED`
    operands, any part of a formula when it has more than `LONGEST`.
    """
    system = of if isinstance(of, EquationSystem) else of.system
    shown = [_Shown.of(system, state) for state in system.states]
    work = _Work(system, shown)
    blocks = tuple(
        ReadableBlock(
            tuple(work.written(unknown) for unknown in block.unknowns),
            tuple(work.written(residual) for residual in system.laws_of(block)),
        )
        for block in system.blocks
    )
    states = _by_group([work.state(item) for item in shown])
    wanted = [work.quantity(path) for path in outputs] or ([] if shown else _answers(system))
    answers = tuple(
        Definition(named, leaf.data.unit, work.written(system.values[leaf]))
        for leaf, named in ((leaf, quantity_symbol(system.causal.graph, leaf)) for leaf in wanted)
    )
    updates = tuple(
        ReadableUpdate(path, tuple((work.written(held), work.written(value)) for held, value in values))
        for path, values in system.updates
    )
    events = tuple(work.event(event, shown) for event in system.causal.graph.events)
    definitions = tuple(work.definitions)
    written = [e for s in states for e in (s.symbol, s.coefficient, s.right)]
    written += [e for d in definitions for e in (d.symbol, d.value)]
    written += [e for d in answers for e in (d.symbol, d.value)]
    written += [e for b in blocks for e in (*b.unknowns, *b.residuals)]
    written += [e for u in updates for pair in u.values for e in pair]
    written += [e for v in events for e in (v.condition, *(item for pair in v.changes for item in pair))]
    symbols = leaves(*written)
    used = set(symbols)
    return ReadableEquations(
        title=system.causal.graph.model.name,
        states=states,
        definitions=definitions,
        blocks=blocks,
        outputs=answers,
        updates=updates,
        events=events,
        inputs=tuple(leaf for leaf in work.inputs if leaf in used),
        names=shortest_names(symbols),
    )


@dataclass(frozen=True, slots=True)
class _Shown:
    """A state and the variable that its equation is written in: state = inertance * symbol."""

    state: StateVariable
    symbol: Expr
    inertance: Expr

    @classmethod
    def of(cls, system: EquationSystem, state: StateVariable) -> _Shown:
        graph = system.causal.graph
        element = graph.normal.elements.get(state.path.parent)
        if element is None or not isinstance(element.behaviour, Storage) or len(element.behaviour.outputs) != 1:
            return cls(state, state.symbol, ONE)
        ((port, law),) = element.behaviour.outputs
        ((_, stored),) = element.behaviour.stored
        gain = Simplifier()(derivative(law, state.symbol))
        is_linear = all(leaf.data.kind is SymbolKind.PARAMETER for leaf in leaves(gain)) and is_zero(
            Simplifier()(substitute(law, {state.symbol: ZERO}))
        )
        if stored is not state.symbol or not is_linear or gain.op is not Op.DIVIDE:
            return cls(state, state.symbol, ONE)
        domain = graph.domains[graph.normal.bonds[element.path / port].domain]
        is_c = element.behaviour.kind is ElementKind.COMPLIANCE
        word, unit = (domain.effort, domain.effort_unit) if is_c else (domain.flow, domain.flow_unit)
        named = symbol(SymbolKind.STATE, element.path / word.replace(" ", "_"), unit)
        return cls(state, named, divide(ONE, gain))


class _Work:
    """Simplifies with the names of the reader, and collects what is defined by itself."""

    def __init__(self, system: EquationSystem, shown: list[_Shown]) -> None:
        self._graph = graph = system.causal.graph
        self.definitions: list[Definition] = []
        self._defined: set[Expr] = set()
        tables = input_symbols(graph)
        self.inputs = list(tables.values())
        known: dict[Expr, Expr] = dict(parameter_aliases(graph))
        known.update({lookup(table, TIME): named for table, named in tables.items()})
        known.update({item.state.symbol: multiply(item.inertance, item.symbol) for item in shown})
        known.update({u: quantity_symbol(graph, u) for block in system.blocks for u in block.unknowns})
        known = {leaf: value for leaf, value in known.items() if value is not leaf}
        self._aliases = parameter_aliases(graph)
        self._values = system.values
        self._quantities = _quantities(graph, system.values)
        roots = [state.derivative for state in system.states]
        roots += [residual for block in system.blocks for residual in system.laws_of(block)]
        roots += [value for _, values in system.updates for _, value in values]
        self._uses = Counter(arg for node in postorder(roots) for arg in node.args)
        self._uses.update(roots)
        self._simplify = Simplifier({k: substitute(v, self._aliases) for k, v in known.items()}, self._cut)

    def quantity(self, path: Path | str) -> Expr:
        """The effort, flow or signal of a path."""
        wanted = parse_path(path) if isinstance(path, str) else path
        found = next((leaf for leaf in self._values if leaf.data.path == wanted), None)
        if found is None:
            raise ModelError.of(
                "equations/unknown-output",
                f"'{wanted}' is no effort, flow or signal of this model",
                help=nearest(str(wanted), (str(leaf.data.path) for leaf in self._values)),
            )
        return found

    def written(self, expr: Expr) -> Expr:
        """The expression as it is shown."""
        return self._simplify(expr)

    def state(self, item: _Shown) -> ReadableState:
        """The equation of a state; storage that moves with it stands on the left where that is shorter."""
        inertance = self.written(item.inertance)
        right = self.written(item.state.derivative)
        rate = self.written(divide(right, inertance))
        if rate.op is Op.DIVIDE:
            top, bottom = rate.args
            adds = any(node.op in (Op.ADD, Op.SUBTRACT) for node in postorder([bottom]))
            fixed = all(leaf.data.kind is SymbolKind.PARAMETER for leaf in leaves(bottom))
            size = self._simplify.size
            if adds and fixed and size(top) + size(bottom) < size(right) + size(inertance):
                inertance, right = bottom, top
        unit = item.symbol.data.unit
        owner = item.state.path.parent
        return ReadableState(item.state.path, item.symbol, unit, inertance, right, Path(owner[:-1][:1]))

    def event(self, event: FlatEvent, shown: Iterable[_Shown]) -> ReadableEvent:
        """What an event changes; what a storage holds is shown as in its equation."""
        by_state = {item.state.symbol: item for item in shown}
        changes: list[tuple[Expr, Expr]] = []
        for target, value in event.changes:
            item = by_state.get(target)
            new = self._resolved(value)
            if item is None:
                changes.append((target, self.written(new)))
            else:
                changes.append((item.symbol, self.written(divide(new, item.inertance))))
        if event.restitution is not None:
            (port,) = self._graph.normal.elements[event.element].ports
            flow = self._graph.variables.of(self._graph.normal.bonds[event.element / port], Variable.FLOW)
            new = self._resolved(-(event.restitution * flow))
            changes.append((quantity_symbol(self._graph, flow), self.written(new)))
        return ReadableEvent(event.element, self.written(self._resolved(event.condition)), tuple(changes))

    def _resolved(self, expr: Expr) -> Expr:
        """An expression of a law in terms of states and unknowns."""
        return substitute(expr, {leaf: self._values[leaf] for leaf in leaves(expr) if leaf in self._values})

    def _cut(self, node: Expr, best: Expr) -> Expr | None:
        if node.op is Op.NEGATE or best.op is Op.SYMBOL:
            return None
        size = self._simplify.size(best)
        named = self._quantities.get(node)
        repeated = named is not None and self._uses[node] > 1
        if size <= (LONGEST_REPEATED if repeated else LONGEST):
            return None
        leaf = named
        if leaf is None:
            leaf = symbol(SymbolKind.SIGNAL, Path((f"v{len(self.definitions) + 1}",)), "")
        if leaf in self._defined:
            return None
        self._defined.add(leaf)
        self.definitions.append(Definition(leaf, leaf.data.unit, best))
        return leaf


def _quantities(graph: BondGraph, values: Mapping[Expr, Expr]) -> dict[Expr, Expr]:
    """The effort, flow or signal that an expression is the value of; the shortest path where it is several."""
    found: dict[Expr, Expr] = {}
    wanted = (SymbolKind.EFFORT, SymbolKind.FLOW, SymbolKind.SIGNAL)
    for leaf, value in values.items():
        if not value.args or leaf.data.kind not in wanted:
            continue
        before = found.get(value)
        if before is None or len(leaf.data.path) < len(before.data.path):
            found[value] = leaf
    return {value: quantity_symbol(graph, leaf) for value, leaf in found.items()}


def _answers(system: EquationSystem) -> list[Expr]:
    """What every element but a source gives at its ports."""
    graph = system.causal.graph
    variables = graph.variables
    return [
        variables.of(bond, Variable.FLOW if system.causal.receives_effort(bond, element) else Variable.EFFORT)
        for path, bonds in graph.normal.at().items()
        if (element := graph.normal.elements.get(path)) is not None and isinstance(element.behaviour, Resistive)
        for bond in bonds
    ]


def _by_group(states: Iterable[ReadableState]) -> tuple[ReadableState, ...]:
    """States of one part next to each other, in the order of the model."""
    groups: dict[Path, list[ReadableState]] = {}
    for state in states:
        groups.setdefault(state.group, []).append(state)
    return tuple(state for members in groups.values() for state in members)
