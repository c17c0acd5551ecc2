"""What every causal stroke means: each effort, flow and signal defined by others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from propermodel.bondgraph.graph import Bond, Element, Variables
from propermodel.causality.causal import CausalGraph
from propermodel.causality.fields import Mixed
from propermodel.causality.implicit import pair
from propermodel.diagnostics import Path
from propermodel.equations.at_places import bond_at, held_when_locked, sign_at, sum_of_others
from propermodel.equations.fields import causality_of, decide
from propermodel.equations.observables import define_observables
from propermodel.equations.switching import other_way
from propermodel.equations.system import BlockKind
from propermodel.expressions.core import ZERO, Expr, SymbolKind, divide, leaves, symbol
from propermodel.modelling.model import (
    Coordinate,
    ElementKind,
    JunctionKind,
    PowerSource,
    Resistive,
    Result,
    Storage,
    TwoPort,
    Variable,
)


@dataclass(frozen=True, slots=True)
class Dependent:
    """Storage in derivative causality: its stored quantity, whose rate is the unknown it answers with."""

    element: Element
    coordinate: Coordinate  # what its author declared a start for
    unknown: Expr
    stored: Expr  # the stored quantity, whose rate the unknown is
    kind: BlockKind = BlockKind.DEPENDENT


@dataclass(frozen=True, slots=True)
class Implied:
    """A variable that a law gives without being solved for it: the unknown that makes the residual vanish."""

    element: Element
    unknown: Expr
    residual: Expr
    kind: BlockKind = BlockKind.LOOP
    other: Expr = ZERO  # of an ideal switch: what the residual would be if it were the other way


@dataclass(frozen=True, slots=True)
class Lockable:
    """A resistance that can lock: while it does, the rate of its flow is held instead of its law."""

    element: Element
    unknown: Expr
    law: Expr
    flow: Expr
    locked: Expr


@dataclass(frozen=True, slots=True)
class Struck:
    """A resistance through which impulses act: its effort is an unknown, so that its impulse has a symbol too."""

    element: Element
    unknown: Expr
    law: Expr
    flow: Expr


@dataclass(frozen=True, slots=True)
class Held:
    """A flow source that closes a kinematic loop: its effort is the unknown that keeps its flow."""

    element: Element
    unknown: Expr
    flow: Expr
    prescribed: Expr


@dataclass
class Definitions:
    """Symbols and what they are, before anything is sorted or solved."""

    values: dict[Expr, Expr] = field(default_factory=dict[Expr, Expr])
    dependents: list[Dependent] = field(default_factory=list[Dependent])
    implied: list[Implied] = field(default_factory=list[Implied])
    lockables: list[Lockable] = field(default_factory=list[Lockable])
    struck: list[Struck] = field(default_factory=list[Struck])
    held: list[Held] = field(default_factory=list[Held])
    laws: list[Expr] = field(default_factory=list[Expr])  # results of resistance laws: candidates for tearing


def define(causal: CausalGraph) -> Definitions:
    """The definition of every effort, flow, stored quantity and signal."""
    found = _define_normal(causal)
    define_observables(found.values, causal.graph)
    return found


def define_needed(causal: CausalGraph, observables: Mapping[Expr, Expr]) -> Definitions:
    """The same, without what can only be observed; for those who ask what depends on what.

    Args:
        causal: A causal graph.
        observables: What `observables_of` gives for this or another causal graph of the same bond graph.
    """
    found = _define_normal(causal)
    pending = list(leaves(*found.values.values(), *_residuals(found)))
    while pending:
        leaf = pending.pop()
        if leaf in observables and leaf not in found.values:
            found.values[leaf] = observables[leaf]
            pending += leaves(observables[leaf])
    return found


def observables_of(causal: CausalGraph) -> dict[Expr, Expr]:
    """What can be observed beyond the graph in normal form, by its other variables; strokes do not change it."""
    normal = _define_normal(causal).values
    found = dict(normal)
    define_observables(found, causal.graph)
    return {leaf: value for leaf, value in found.items() if leaf not in normal}


def _residuals(found: Definitions) -> Iterator[Expr]:
    """What unknowns follow from."""
    yield from (dependent.stored for dependent in found.dependents)
    yield from (implied.residual for implied in found.implied)
    for lockable in found.lockables:
        yield from (lockable.law, lockable.flow, lockable.locked)
    yield from (struck.law for struck in found.struck)
    for held in found.held:
        yield from (held.flow, held.prescribed)


def _define_normal(causal: CausalGraph) -> Definitions:
    """What the graph in normal form and the signals define."""
    graph = causal.graph
    found = Definitions()
    variables = graph.variables
    at = graph.normal.at()
    for path, junction in graph.normal.junctions.items():
        _define_junction(found, causal, variables, path, junction.kind, at[path])
    for element in graph.normal.elements.values():
        _define_element(found, causal, variables, element, at[element.path])
    found.values.update(graph.signals)
    return found


def _define_junction(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    path: Path,
    kind: JunctionKind,
    bonds: list[Bond],
) -> None:
    wants = kind is JunctionKind.ZERO
    strong = next(b for b in bonds if (causal.strokes[b.name].effort_into == path) is wants)
    common, summed = kind.common, kind.common.other
    for bond in bonds:
        if bond is not strong:
            found.values[variables.of(bond, common)] = variables.of(strong, common)
    others = [(variables.of(b, summed), sign_at(b, path)) for b in bonds if b is not strong]
    found.values[variables.of(strong, summed)] = sum_of_others(others, sign_at(strong, path))


def _define_element(
    found: Definitions, causal: CausalGraph, variables: Variables, element: Element, bonds: list[Bond]
) -> None:
    behaviour = element.behaviour
    ports = {port: bond_at(bonds, element, port) for port in element.ports}
    # The laws are written in the element's own port variables; a bond may have another name only for internal ports.
    match behaviour:
        case PowerSource():
            (bond,) = bonds
            if element.path in causal.constraints:
                _define_held(found, variables, element, behaviour, bond)
                return
            variable = Variable.EFFORT if behaviour.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
            found.values[variables.of(bond, variable)] = behaviour.value
        case TwoPort():
            _define_two_port(found, causal, variables, element, behaviour, ports)
        case Resistive():
            _define_resistance(found, causal, variables, element, behaviour, ports)
        case Storage():
            _define_storage(found, causal, variables, element, behaviour, ports)


def _define_held(
    found: Definitions, variables: Variables, element: Element, behaviour: PowerSource, bond: Bond
) -> None:
    target = variables.of(bond, Variable.EFFORT)
    unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
    found.values[target] = unknown
    found.held.append(Held(element, unknown, variables.of(bond, Variable.FLOW), behaviour.value))


def _define_two_port(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    element: Element,
    behaviour: TwoPort,
    ports: dict[str, Bond | None],
) -> None:
    a, b = ports["a"], ports["b"]
    assert a is not None
    assert b is not None
    m = behaviour.modulus
    e_a, f_a = variables.of(a, Variable.EFFORT), variables.of(a, Variable.FLOW)
    e_b, f_b = variables.of(b, Variable.EFFORT), variables.of(b, Variable.FLOW)
    into_a = causal.receives_effort(a, element)
    if behaviour.kind is ElementKind.TRANSFORMER:
        if into_a:
            found.values[e_b], found.values[f_a] = divide(e_a, m), divide(f_b, m)
        else:
            found.values[e_a], found.values[f_b] = m * e_b, m * f_a
    elif into_a:
        found.values[f_b], found.values[f_a] = divide(e_a, m), divide(e_b, m)
    else:
        found.values[e_a], found.values[e_b] = m * f_b, m * f_a


def _define_resistance(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    element: Element,
    behaviour: Resistive,
    ports: dict[str, Bond | None],
) -> None:
    def fits(result: Result) -> bool:
        bond = ports[result.port]
        return bond is None or causal.receives_effort(bond, element) is (result.variable is Variable.FLOW)

    if not any(all(map(fits, law.results)) for law in behaviour.laws) and behaviour.implicit:
        _define_implicit(found, causal, variables, element, behaviour, ports)
        return
    law = max(behaviour.laws, key=lambda law: sum(map(fits, law.results)))
    for result in law.results:
        bond = ports[result.port]
        if bond is None:
            continue
        target = variables.of(bond, result.variable)
        if not fits(result):
            answer = variables.of(bond, result.variable.other)
            unknown = symbol(SymbolKind.UNKNOWN, answer.data.path, answer.data.unit)
            found.implied.append(Implied(element, unknown, target - result.value))
            found.values[answer] = unknown
        elif behaviour.locked is not None and result.variable is Variable.EFFORT:
            flow = variables.of(bond, Variable.FLOW)
            unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
            found.lockables.append(Lockable(element, unknown, result.value, flow, behaviour.locked))
            found.values[target] = unknown
        elif result.variable is Variable.EFFORT and _has_impulses(causal, element):
            flow = variables.of(bond, Variable.FLOW)
            unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
            found.struck.append(Struck(element, unknown, result.value, flow))
            found.values[target] = unknown
        else:
            found.values[target] = held_when_locked(behaviour, result)
            found.laws.append(target)


def _has_impulses(causal: CausalGraph, element: Element) -> bool:
    return any(event.element == element.path and event.restitution is not None for event in causal.graph.events)


def _define_implicit(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    element: Element,
    behaviour: Resistive,
    ports: dict[str, Bond | None],
) -> None:
    """Let the implicit law of a resistance give what its strokes ask for."""
    given: list[tuple[str, Variable]] = []
    targets: list[Expr] = []
    for port in element.ports:
        bond = ports[port]
        assert bond is not None
        variable = Variable.FLOW if causal.receives_effort(bond, element) else Variable.EFFORT
        given.append((port, variable))
        targets.append(variables.of(bond, variable))
    residuals = pair(element, behaviour, tuple(given))
    if residuals is None:
        raise AssertionError(f"no law of {element.path} fits its strokes")
    for target, residual in zip(targets, residuals, strict=True):
        unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
        found.values[target] = unknown
        other = _other_way(causal, variables, element, ports, residual)
        kind = BlockKind.IMPLICIT if other is None else BlockKind.SWITCH
        found.implied.append(Implied(element, unknown, residual, kind, ZERO if other is None else other))


def _other_way(
    causal: CausalGraph, variables: Variables, element: Element, ports: dict[str, Bond | None], residual: Expr
) -> Expr | None:
    """What an ideal switch with one port says when it is the other way; None for what is none."""
    bond = next(iter(ports.values()))
    if len(ports) != 1 or bond is None or all(event.element != element.path for event in causal.graph.events):
        return None
    effort, flow = (variables.of(bond, variable) for variable in (Variable.EFFORT, Variable.FLOW))
    return other_way(residual, element.path, effort, flow)


def _define_storage(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    element: Element,
    behaviour: Storage,
    ports: dict[str, Bond | None],
) -> None:
    is_c = behaviour.kind is ElementKind.COMPLIANCE
    output = Variable.EFFORT if is_c else Variable.FLOW
    kind = SymbolKind.DISPLACEMENT if is_c else SymbolKind.MOMENTUM
    stored = dict(behaviour.stored)
    domain_unit = {"displacement": "displacement_unit", "momentum": "momentum_unit"}[kind.value]
    causality = causality_of(causal, element)
    decided = set[str]() if causality is None else {port for port, _ in causality.derivative}
    if causality is not None and behaviour.inverse is not None:
        ((port, _),) = stored.items()
        bond = ports[port]
        assert bond is not None
        (coordinate,) = behaviour.coordinates
        target = variables.of(bond, output.other)
        unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
        state = symbol(SymbolKind.STATE, element.path / coordinate.name, coordinate.unit)
        found.values[target] = unknown
        found.values[state] = behaviour.inverse
        found.dependents.append(Dependent(element, coordinate, unknown, state))
    elif causality is not None:
        _define_decided(found, causal, variables, element, behaviour, causality)
    for port, law in behaviour.outputs:
        bond = ports[port]
        if bond is not None and port not in decided:
            found.values[variables.of(bond, output)] = law
    for port, expr in stored.items():
        bond = ports[port]
        if bond is not None:
            unit = getattr(causal.graph.domains[bond.domain], domain_unit)
            found.values[symbol(kind, element.path / port / kind.value, unit)] = expr


def _define_decided(
    found: Definitions,
    causal: CausalGraph,
    variables: Variables,
    element: Element,
    behaviour: Storage,
    causality: Mixed,
) -> None:
    """Let what is given at ports in derivative causality decide coordinates, whose rates are the answer there."""
    output = Variable.EFFORT if behaviour.kind is ElementKind.COMPLIANCE else Variable.FLOW
    bonds = {port: causal.graph.normal.bonds[element.path / port] for port, _ in causality.derivative}
    given = {port: variables.of(bond, output) for port, bond in bonds.items()}
    decided = decide(element, behaviour, causality, given)
    found.values.update(decided.values)
    found.implied.extend(Implied(element, unknown, residual) for unknown, residual in decided.unknowns)
    stored = dict(behaviour.stored)
    for port, coordinate in causality.derivative:
        target = variables.of(bonds[port], output.other)
        unknown = symbol(SymbolKind.UNKNOWN, target.data.path, target.data.unit)
        found.values[target] = unknown
        found.dependents.append(Dependent(element, coordinate, unknown, stored[port]))
