"""Linear one-ports that share their variable, rigidly or through transformers, as one with a physical parameter.

At a 1-junction efforts add up over a common flow, so masses, springs and dampers add: c = c_1 + n^2 c_2, with n the
flow of the second for a unit flow of the first. At a 0-junction flows add up over a common effort, so what yields adds:
1 / c = 1 / c_1 + n^2 / c_2. What storage holds at the start is kept: momentum of masses, charge of compliances, force
of parallel springs.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

from propermodel.bondgraph.graph import Absorbed, Element, Structure
from propermodel.diagnostics import Path
from propermodel.expressions.core import (
    ONE,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    divide,
    is_zero,
    leaves,
    power,
    substitute,
    symbol,
)
from propermodel.expressions.derivatives import derivative
from propermodel.expressions.simplify import simplify
from propermodel.modelling.model import (
    ElementKind,
    JunctionKind,
    ResistanceLaw,
    Resistive,
    Result,
    Storage,
    TwoPort,
    Variable,
)

_PORT_VARIABLES = (SymbolKind.EFFORT, SymbolKind.FLOW)
_MARK = "_merged"


@dataclass(frozen=True, slots=True)
class LinearOnePort:
    """A one-port with a constant parameter c: F = m dv/dt, F = k x or F = r v."""

    element: Element
    junction: Path
    kind: JunctionKind  # of its junction
    coefficient: Expr


def linear_one_port(structure: Structure, path: Path) -> LinearOnePort | None:
    """An element as a linear one-port at a junction; None for all others."""
    element = structure.elements.get(path)
    if element is None or len(element.ports) != 1 or not element.kind.is_energetic:
        return None
    bond = next(bond for bond in structure.bonds.values() if path in (bond.tail.owner, bond.head.owner))
    junction = structure.junctions.get(bond.other(path).owner)
    coefficient = _coefficient(element)
    if junction is None or coefficient is None:
        return None
    return LinearOnePort(element, junction.path, junction.kind, coefficient)


def _coefficient(element: Element) -> Expr | None:
    behaviour = element.behaviour
    if isinstance(behaviour, Storage):
        return _of_storage(behaviour)
    if not isinstance(behaviour, Resistive) or behaviour.locked is not None or behaviour.converts:
        return None
    found: dict[Variable, Expr] = {}
    for law in behaviour.laws:
        (result,) = law.results
        drivers = [leaf for leaf in leaves(result.value) if leaf.data.kind in _PORT_VARIABLES]
        gain = _gain(result.value, drivers[0]) if len(drivers) == 1 else None
        if gain is None:
            return None
        found[result.variable] = gain
    if Variable.EFFORT in found:
        return found[Variable.EFFORT]
    return divide(ONE, found[Variable.FLOW]) if found else None


def _of_storage(behaviour: Storage) -> Expr | None:
    """Stiffness or inertia of linear storage in its own displacement or momentum."""
    ((_, law),) = behaviour.outputs
    ((_, stored),) = behaviour.stored
    states = [leaf for leaf in leaves(law) if leaf.data.kind is SymbolKind.STATE]
    if behaviour.inverse is None or states != [stored]:
        return None
    drivers = [leaf for leaf in leaves(behaviour.inverse) if leaf.data.kind in _PORT_VARIABLES]
    gain = _gain(law, stored)
    inverse = _gain(behaviour.inverse, drivers[0]) if len(drivers) == 1 else None
    return None if gain is None else gain if behaviour.kind is ElementKind.COMPLIANCE else inverse


def _gain(law: Expr, driver: Expr) -> Expr | None:
    """The constant factor of a law that is proportional to its driver."""
    gain = simplify(derivative(law, driver))
    constant = all(leaf.data.kind is SymbolKind.PARAMETER for leaf in leaves(gain))
    at_rest = simplify(substitute(law, {driver: ZERO}))
    return gain if constant and not is_zero(gain) and is_zero(at_rest) else None


def sharing(structure: Structure, start: LinearOnePort) -> Iterator[tuple[Path, Expr]]:
    """The junctions that share the variable of a one-port's junction, and the factor of their variable."""
    at = structure.at()
    pending = deque([(start.junction, ONE)])
    seen = {start.junction}
    while pending:
        junction, factor = pending.popleft()
        yield junction, factor
        for bond in at[junction]:
            end = bond.other(junction)
            element = structure.elements.get(end.owner)
            if element is None or element.kind is not ElementKind.TRANSFORMER:
                continue
            behaviour = element.behaviour
            assert isinstance(behaviour, TwoPort)
            if any(leaf.data.kind is not SymbolKind.PARAMETER for leaf in leaves(behaviour.modulus)):
                continue
            for beyond in at[element.path]:
                far = beyond.other(element.path).owner
                other = structure.junctions.get(far)
                if beyond is bond or other is None or other.kind is not start.kind or far in seen:
                    continue
                seen.add(far)
                # f_b = m f_a and e_a = m e_b
                grows = (end.port == "a") is (start.kind.common is Variable.FLOW)
                pending.append((far, factor * behaviour.modulus if grows else divide(factor, behaviour.modulus)))


def merged_coefficient(one: LinearOnePort, other: LinearOnePort, factor: Expr) -> Expr:
    """The parameter of both together, at the first."""
    if one.kind is JunctionKind.ONE:
        return one.coefficient + _squared(factor, other.coefficient)
    return divide(ONE, divide(ONE, one.coefficient) + _squared(factor, divide(ONE, other.coefficient)))


def _squared(factor: Expr, coefficient: Expr) -> Expr:
    """A coefficient times the square of a factor; ratios stay below the line."""
    if factor == ONE:
        return coefficient
    if factor.op is Op.DIVIDE:
        above, below = factor.args
        return divide(_squared(above, coefficient), power(below, 2.0))
    return power(factor, 2.0) * coefficient


def share_of(absorbed: Absorbed, total: Expr) -> Expr:
    """The part of an element in the variable that adds up, from the parameter of the one that stands for all."""
    if absorbed.kind is JunctionKind.ONE:
        return divide(absorbed.factor * absorbed.coefficient, total)
    return divide(absorbed.factor * total, absorbed.coefficient)


def merged_element(one: LinearOnePort, other: LinearOnePort, factor: Expr) -> Element:
    """The element that stands for both, beside the first; its name ends on `_merged`."""
    element, total = _renamed(one.element), merged_coefficient(one, other, factor)
    behaviour = element.behaviour
    if isinstance(behaviour, Resistive):
        return replace(element, behaviour=replace(behaviour, laws=tuple(_proportional(behaviour, total))))
    assert isinstance(behaviour, Storage)
    assert isinstance(other.element.behaviour, Storage)
    (coordinate,), (second,) = behaviour.coordinates, other.element.behaviour.coordinates
    ((port, stored),) = behaviour.stored
    is_compliance = behaviour.kind is ElementKind.COMPLIANCE
    if is_compliance is (one.kind is JunctionKind.ZERO):
        start = coordinate.start + factor * second.start
    elif is_compliance:
        start = divide(one.coefficient * coordinate.start + factor * other.coefficient * second.start, total)
    else:
        start = (divide(coordinate.start, one.coefficient) + factor * divide(second.start, other.coefficient)) * total
    assert behaviour.inverse is not None
    (driver,) = [leaf for leaf in leaves(behaviour.inverse) if leaf.data.kind in _PORT_VARIABLES]
    changed = replace(
        behaviour,
        coordinates=(replace(coordinate, start=start),),
        outputs=((port, total * stored if is_compliance else divide(stored, total)),),
        energy=0.5 * total * stored * stored if is_compliance else divide(0.5 * stored * stored, total),
        inverse=divide(driver, total) if is_compliance else total * driver,
    )
    return replace(element, behaviour=changed)


def _proportional(behaviour: Resistive, total: Expr) -> Iterator[ResistanceLaw]:
    for law in behaviour.laws:
        (result,) = law.results
        (driver,) = [leaf for leaf in leaves(result.value) if leaf.data.kind in _PORT_VARIABLES]
        value = total * driver if result.variable is Variable.EFFORT else divide(driver, total)
        yield ResistanceLaw(results=(Result(port=result.port, variable=result.variable, value=value),))


def _renamed(element: Element) -> Element:
    """The element under a name of its own, with its own variables."""
    if element.path.name.endswith(_MARK):
        return element
    path = element.path.parent / f"{element.path.name}{_MARK}"

    def moved(expr: Expr) -> Expr:
        own = [leaf for leaf in leaves(expr) if leaf.data.kind in (*_PORT_VARIABLES, SymbolKind.STATE)]
        places = {leaf: Path((*path, *leaf.data.path[len(element.path) :])) for leaf in own}
        return substitute(expr, {leaf: symbol(leaf.data.kind, at, leaf.data.unit) for leaf, at in places.items()})

    behaviour = element.behaviour
    if isinstance(behaviour, Storage):
        behaviour = replace(
            behaviour,
            stored=tuple((port, moved(value)) for port, value in behaviour.stored),
            outputs=tuple((port, moved(value)) for port, value in behaviour.outputs),
            energy=moved(behaviour.energy),
            inverse=None if behaviour.inverse is None else moved(behaviour.inverse),
        )
    elif isinstance(behaviour, Resistive):
        laws = tuple(
            ResistanceLaw(results=tuple(replace(result, value=moved(result.value)) for result in law.results))
            for law in behaviour.laws
        )
        behaviour = replace(behaviour, laws=laws)
    return replace(element, path=path, behaviour=behaviour, row=path if element.row == element.path else element.row)
