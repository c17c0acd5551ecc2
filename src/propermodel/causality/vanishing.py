"""Two-ports whose modulus may be zero, such as the sine of an angle: they cannot be turned round there.

With f_b = m f_a and e_a = m e_b a transformer multiplies. In the other causality it divides by m, and a run that begins
at m = 0 has no solution although the model has one. Where strokes leave a choice, such a two-port should multiply.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.bondgraph.parameters import parameter_values
from propermodel.causality.causal import CausalGraph
from propermodel.expressions.core import Expr, Op, SymbolKind, leaves, postorder, substitute
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import ElementKind, TwoPort

# What states, efforts, flows and time are set to, all together: rest comes first.
_SAMPLES = (0.0, 0.1, -0.1, 1.0, -1.0, 3.0, -3.0)


def vanishing_two_ports(graph: BondGraph) -> list[Element]:
    """The two-ports whose modulus is zero at rest, then those whose modulus changes its sign as far as samples show."""
    found: list[tuple[int, Element]] = []
    parameters: Mapping[Expr, float] | None = None
    for element in graph.normal.elements.values():
        if not isinstance(element.behaviour, TwoPort) or element.behaviour.modulus.op is Op.CONSTANT:
            continue
        modulus = without_signals(element.behaviour.modulus, graph)
        inside = leaves(modulus)
        if all(leaf.data.kind is SymbolKind.PARAMETER for leaf in inside):
            continue
        if parameters is None:
            parameters = parameter_values(graph.parameters)
        turn = _turn(modulus, tuple((leaf, parameters[leaf]) for leaf in inside if leaf in parameters))
        if turn is not None:
            found.append((turn, element))
    return [element for _, element in sorted(found, key=lambda item: item[0])]


@lru_cache(maxsize=1024)
def _turn(modulus: Expr, parameters: tuple[tuple[Expr, float], ...]) -> int | None:
    """0 where a modulus is zero at rest, 1 where it changes its sign, None where it does neither.

    Kept, since states are chosen among many strokes of one graph.
    """
    at_rest, *values = (_value(modulus, dict(parameters), sample) for sample in _SAMPLES)
    if at_rest == 0.0:
        return 0
    return 1 if any(value < 0.0 for value in values) and any(value > 0.0 for value in values) else None


def ports_that_receive_effort(element: Element) -> Mapping[str, bool]:
    """By port of a two-port that multiplies with its modulus: whether it receives the effort there."""
    return {"a": False, "b": element.kind is ElementKind.TRANSFORMER}


def dividing_two_ports(causal: CausalGraph) -> list[Element]:
    """The two-ports that divide by a modulus which changes along a run, so that it may be zero there."""
    structure = causal.graph.normal
    found: list[Element] = []
    for element in structure.elements.values():
        if isinstance(element.behaviour, TwoPort) and _may_vanish(element.behaviour.modulus):
            bond = structure.bonds.get(element.path / "a")
            # e_a = m e_b, f_b = m f_a and e_a = r f_b, e_b = r f_a do not divide; their inverses do.
            if bond is not None and causal.receives_effort(bond, element):
                found.append(element)
    return found


def _may_vanish(modulus: Expr) -> bool:
    if modulus.op is Op.DIVIDE:
        return _may_vanish(modulus.args[0])
    return any(leaf.data.kind is not SymbolKind.PARAMETER for leaf in leaves(modulus))


def without_signals(expr: Expr, graph: BondGraph) -> Expr:
    """An expression in terms of what the signals in it are made of."""
    while signals := {leaf: graph.signals[leaf] for leaf in leaves(expr) if leaf in graph.signals}:
        expr = substitute(expr, signals)
    return expr


def _value(modulus: Expr, parameters: dict[Expr, float], sample: float) -> float:
    given = dict(parameters)
    for node in _open_ends(modulus):
        # The values of tables come with a run; they are taken as not zero.
        given.setdefault(node, 1.0 if node.op in (Op.LOOKUP, Op.SLOPE) else sample)
    return interpret(modulus, given)


def _open_ends(expr: Expr) -> Iterable[Expr]:
    return (node for node in postorder([expr]) if node.op in (Op.SYMBOL, Op.LOOKUP, Op.SLOPE))
