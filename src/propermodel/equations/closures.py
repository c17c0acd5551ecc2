"""Closed kinematic loops: which displacement each of them keeps, and what gives way.

The flow at a closure is a sum of flows of mechanisms, whose integrals are their positions, and of flows that some
signal integrates. Where all terms have a known integral, the loop has a geometry: this sum of displacements vanishes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from propermodel.bondgraph.graph import Bond, Element
from propermodel.causality.causal import CausalGraph
from propermodel.causality.closures import closures, is_mechanism
from propermodel.equations.at_places import sign_at
from propermodel.equations.definitions import Definitions
from propermodel.equations.impulses import impulse_slopes
from propermodel.equations.loops import Resolution
from propermodel.equations.system import Closure, StateVariable
from propermodel.expressions.core import (
    TIME,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    constant,
    is_zero,
    leaves,
    multiply,
    number,
)
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.modelling.model import JunctionKind, PowerSource, TwoPort, Variable

Terms = dict[Expr, float]  # flow symbols with their factors


def closures_of(
    causal: CausalGraph, definitions: Definitions, resolution: Resolution, states: Sequence[StateVariable]
) -> tuple[Closure, ...]:
    """Every closed kinematic loop of a model."""
    normal = causal.graph.normal
    closing = closures(normal)
    if not closing:
        return ()
    held = {h.element.path: h for h in definitions.held}
    answers = {item.unknown for item in (*definitions.dependents, *definitions.lockables, *definitions.held)}
    impulses = dict(
        zip(held, impulse_slopes(states, [h.unknown for h in held.values()]), strict=True),
    )
    geometry = _Geometry(causal, definitions, resolution, states)
    found: list[Closure] = []
    for path in closing:
        element = normal.elements[path]
        flow = None
        if path in held:
            flow = resolution.complete(held[path].flow - held[path].prescribed)
            flow = None if answers.intersection(leaves(flow)) else flow
        displacement = geometry.displacement(element)
        if flow is None and displacement is None:
            continue
        domain = causal.graph.domains[geometry.bond(element).domain]
        found.append(
            Closure(
                element=path,
                flow=flow,
                flow_unit=domain.flow_unit,
                impulses=impulses[path] if flow is not None else (),
                displacement=displacement,
                displacement_unit=domain.displacement_unit,
                coordinates=() if displacement is None else geometry.coordinates(displacement),
                source=element.source,
            )
        )
    return tuple(found)


def positions_of(causal: CausalGraph, resolution: Resolution) -> frozenset[Expr]:
    """The states that the positions of mechanisms depend on: displacements, although no storage holds them."""
    behaviours = (element.behaviour for element in causal.graph.normal.elements.values() if is_mechanism(element))
    positions = (b.position for b in behaviours if isinstance(b, TwoPort) and b.position is not None)
    return frozenset(leaves(*(resolution.complete(position) for position in positions)))


class _Geometry:
    """The displacements behind flows."""

    def __init__(
        self, causal: CausalGraph, definitions: Definitions, resolution: Resolution, states: Sequence[StateVariable]
    ) -> None:
        self.structure = causal.graph.normal
        self.at = self.structure.at()
        self.variables = causal.graph.variables
        self.definitions = definitions
        self.resolution = resolution
        self.states = states
        integrators = {signal.symbol for signal in causal.graph.signal_states}
        self.integrals: Mapping[Expr, Expr] = {
            state.derivative: state.symbol
            for state in states
            if state.symbol in integrators and leaves(state.derivative)
        }
        self.positions: dict[Expr, Expr] = {}  # flow at an output transformer: position it contributes to
        for element in self.structure.elements.values():
            behaviour = element.behaviour
            if is_mechanism(element) and isinstance(behaviour, TwoPort) and behaviour.position is not None:
                out = next(b for b in self.at[element.path] if "b" in (b.tail.port, b.head.port))
                flow = self.variables.of(out, Variable.FLOW)
                self.positions[flow] = resolution.complete(behaviour.position)
        # Transformers of inputs that cannot move are gone; those that remain contribute all there is.
        self.members: dict[Expr, set[Expr]] = {}
        for flow, position in self.positions.items():
            self.members.setdefault(position, set()).add(flow)

    def bond(self, element: Element) -> Bond:
        """The bond of a source."""
        return self.at[element.path][0]

    def displacement(self, element: Element) -> Expr | None:
        """The displacement that must vanish at a source, None where its flow has no known integral."""
        behaviour = element.behaviour
        if not isinstance(behaviour, PowerSource) or not is_zero(behaviour.value):
            return None
        total = ZERO
        by_position: dict[Expr, Terms] = {}
        pending = list(self._at_source(element).items())
        while pending:
            flow, factor = pending.pop()
            value = self.resolution.values.get(flow)
            if flow in self.positions:
                terms = by_position.setdefault(self.positions[flow], {})
                terms[flow] = terms.get(flow, 0.0) + factor
            elif value is not None and value in self.integrals:
                total = total + multiply(constant(factor), self.integrals[value])
            else:
                inside = _linear(self.definitions.values.get(flow))
                if inside is None:
                    return None
                pending.extend((leaf, factor * share) for leaf, share in inside.items())
        for position, terms in by_position.items():
            factors = set(terms.values())
            if set(terms) != self.members[position] or len(factors) != 1:
                return None
            total = total + multiply(constant(factors.pop()), position)
        return total

    def coordinates(self, displacement: Expr) -> tuple[tuple[Expr, Expr], ...]:
        """The states that a displacement depends on and that may give way, with its slopes."""
        moving = [state.symbol for state in self.states if self._gives_way(state)]
        (slopes,) = partial_derivatives([displacement], moving)
        return tuple(slopes.items())

    def _gives_way(self, state: StateVariable) -> bool:
        """Whether the rate of a state comes from other states; what a source moves stays where it moves it."""
        free = (SymbolKind.STATE, SymbolKind.UNKNOWN)
        return any(leaf.data.kind in free and leaf is not TIME for leaf in leaves(state.derivative))

    def _at_source(self, element: Element) -> Terms:
        """The flow at a source in the flows of what it is bonded to."""
        bond = self.bond(element)
        place = bond.other(element.path).owner
        junction = self.structure.junctions.get(place)
        if junction is None:
            return {self.variables.of(bond, Variable.FLOW): 1.0}
        others = [b for b in self.at[place] if b is not bond]
        if junction.kind is JunctionKind.ZERO:
            into = sign_at(bond, place)
            return {self.variables.of(b, Variable.FLOW): -1.0 if sign_at(b, place) is into else 1.0 for b in others}
        return {self.variables.of(next(b for b in others if self._leads_to_output(b, place)), Variable.FLOW): 1.0}

    def _leads_to_output(self, bond: Bond, place: object) -> bool:
        end = bond.tail if bond.head.owner == place else bond.head
        return end.port == "b" or self.structure.junctions.get(end.owner) is not None


def _linear(value: Expr | None) -> Terms | None:
    """An expression as a sum of symbols with numbers as factors; None if it is anything else."""
    if value is None:
        return None
    found: Terms = {}
    pending = [(value, 1.0)]
    while pending:
        node, factor = pending.pop()
        if is_zero(node):
            continue
        match node.op:
            case Op.SYMBOL:
                found[node] = found.get(node, 0.0) + factor
            case Op.ADD:
                pending += [(node.args[0], factor), (node.args[1], factor)]
            case Op.SUBTRACT:
                pending += [(node.args[0], factor), (node.args[1], -factor)]
            case Op.NEGATE:
                pending.append((node.args[0], -factor))
            case Op.MULTIPLY if (share := number(node.args[0])) is not None:
                pending.append((node.args[1], factor * share))
            case Op.MULTIPLY if (share := number(node.args[1])) is not None:
                pending.append((node.args[0], factor * share))
            case _:
                return None
    return found
