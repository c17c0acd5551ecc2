"""Loops of two-ports, round which a variable must be a fixed multiple of itself.

Junctions pass a variable on, transformers and gyrators multiply it. Where that closes, the moduli must multiply to 1:
any other product only lets the variable be zero. With the product 1 one two-port repeats what the others say, so that
nothing decides how they share what they transmit.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from propermodel.bondgraph.graph import BondGraph, Structure
from propermodel.diagnostics import Diagnostic, Involved, Path, Severity
from propermodel.expressions.core import MINUS_ONE, ONE, Expr, SymbolKind, divide, is_zero, leaves
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import ElementKind, TwoPort, Variable

Values = Mapping[Expr, float]
Signal = tuple[Path, Variable]  # the effort or flow of a bond

# A product that differs from 1 by less is 1.
AGREEMENT = 1e-9


@dataclass(frozen=True, slots=True)
class TransformerLoop:
    """Two-ports in a ring, and the product of their moduli: the multiple of itself that a variable must be."""

    elements: tuple[Path, ...]
    product: Expr
    bond: Path
    variable: Variable


@dataclass(frozen=True, slots=True)
class _Ratio:
    """What a junction or two-port says: the second variable is `factor` times the first."""

    ends: tuple[Signal, Signal]
    factor: Expr
    element: Path | None


def transformer_loops(structure: Structure) -> tuple[TransformerLoop, ...]:
    """The independent loops whose moduli are made of parameters alone."""
    if not any(isinstance(element.behaviour, TwoPort) for element in structure.elements.values()):
        return ()
    ratios = list(_ratios(structure))
    at: dict[Signal, list[int]] = {}
    for number, ratio in enumerate(ratios):
        for end in ratio.ends:
            at.setdefault(end, []).append(number)
    came_by: dict[Signal, int | None] = {}
    closing: list[int] = []
    used: set[int] = set()
    for start in at:
        if start in came_by:
            continue
        came_by[start] = None
        pending = deque([start])
        while pending:
            here = pending.popleft()
            for number in at[here]:
                if number in used:
                    continue
                used.add(number)
                there = _other(ratios[number], here)
                if there in came_by:
                    closing.append(number)
                else:
                    came_by[there] = number
                    pending.append(there)
    return tuple(_loop(ratios, came_by, number) for number in closing)


def _ratios(structure: Structure) -> Iterator[_Ratio]:
    """What every junction and every two-port with a constant modulus says."""
    at = structure.at()
    for path, junction in structure.junctions.items():
        common = junction.kind.common
        for first, second in pairwise(at[path]):
            yield _Ratio(((first.name, common), (second.name, common)), ONE, None)
        if len(at[path]) == 2:
            first, second = at[path]
            opposed = (first.head.owner == path) is (second.head.owner == path)
            ends = (first.name, common.other), (second.name, common.other)
            yield _Ratio(ends, MINUS_ONE if opposed else ONE, None)
    for element in structure.elements.values():
        behaviour = element.behaviour
        if not isinstance(behaviour, TwoPort) or not _is_constant(behaviour.modulus):
            continue
        ports = {
            end.port: bond for bond in at[element.path] for end in (bond.tail, bond.head) if end.owner == element.path
        }
        if len(ports) < 2:
            continue
        a, b = ports["a"].name, ports["b"].name
        # e_a = m e_b and f_b = m f_a, or e_a = r f_b and e_b = r f_a.
        ways = (
            (
                ((b, Variable.EFFORT), (a, Variable.EFFORT)),
                ((a, Variable.FLOW), (b, Variable.FLOW)),
            )
            if element.kind is ElementKind.TRANSFORMER
            else (
                ((b, Variable.FLOW), (a, Variable.EFFORT)),
                ((a, Variable.FLOW), (b, Variable.EFFORT)),
            )
        )
        for ends in ways:
            yield _Ratio(ends, behaviour.modulus, element.path)


def _is_constant(modulus: Expr) -> bool:
    return not is_zero(modulus) and all(leaf.data.kind is SymbolKind.PARAMETER for leaf in leaves(modulus))


def _other(ratio: _Ratio, end: Signal) -> Signal:
    first, second = ratio.ends
    return second if end == first else first


def _loop(ratios: list[_Ratio], came_by: Mapping[Signal, int | None], closing: int) -> TransformerLoop:
    """The loop that a ratio closes: through it, and back on the ways by which its ends were reached."""
    start, end = ratios[closing].ends
    down, back = _way(ratios, came_by, start), _way(ratios, came_by, end)
    while down and back and down[-1] == back[-1]:
        del down[-1], back[-1]
    here, product = start, ONE
    elements: dict[Path, None] = {}
    for number in (closing, *back, *reversed(down)):
        ratio = ratios[number]
        product = product * ratio.factor if here == ratio.ends[0] else divide(product, ratio.factor)
        here = _other(ratio, here)
        if ratio.element is not None:
            elements[ratio.element] = None
    return TransformerLoop(tuple(elements), product, *start)


def _way(ratios: list[_Ratio], came_by: Mapping[Signal, int | None], signal: Signal) -> list[int]:
    """The ratios from a variable back to where the search began."""
    way: list[int] = []
    while (number := came_by[signal]) is not None:
        way.append(number)
        signal = _other(ratios[number], signal)
    return way


# -- faults --------------------------------------------------------------------------------------------------


def redundant_loops(graph: BondGraph, loops: Iterable[TransformerLoop], values: Values) -> list[Diagnostic]:
    """A fault for each loop whose moduli multiply to 1 at these values of parameters."""
    return [
        _diagnostic(
            graph,
            loop,
            values,
            "causality/transformer-loop",
            f"of the ratio 1: nothing decides how they share the {_word(graph, loop, loop.variable.other)}",
            f"leave one of them out, since it repeats what the others say, or put {_between(loop)} into the loop",
            Severity.ERROR,
        )
        for loop in loops
        if _is_one(_value(loop, values))
    ]


def locked_loops(graph: BondGraph, loops: Iterable[TransformerLoop], values: Values) -> tuple[Diagnostic, ...]:
    """A warning for each loop whose moduli multiply to another number than 1: all that it joins is held at zero."""
    return tuple(
        _diagnostic(
            graph,
            loop,
            values,
            "causality/transformer-lock",
            f"of the ratio {_value(loop, values):.6g}, not 1: the {_word(graph, loop, loop.variable)} can only be 0",
            f"correct the moduli, which should multiply to 1 around the loop, or put {_between(loop)} into it",
            Severity.WARNING,
        )
        for loop in loops
        if not _is_one(_value(loop, values))
    )


def _diagnostic(
    graph: BondGraph, loop: TransformerLoop, values: Values, code: str, fault: str, cure: str, severity: Severity
) -> Diagnostic:
    elements = [element for path, element in graph.normal.elements.items() if path in loop.elements]
    names = " and ".join(filter(None, (", ".join(str(e.path) for e in elements[:-1]), str(elements[-1].path))))
    involved = [
        Involved(
            str(element.path), f"has the modulus {interpret(element.behaviour.modulus, values):.6g}", element.source
        )
        for element in elements
        if isinstance(element.behaviour, TwoPort)
    ]
    return Diagnostic(
        code,
        f"{names} close{'s' if len(elements) == 1 else ''} a loop {fault}",
        where=str(loop.bond),
        source=elements[0].source,
        involved=tuple(involved),
        help=cure,
        severity=severity,
    )


def _value(loop: TransformerLoop, values: Values) -> float:
    return interpret(loop.product, values)


def _is_one(product: float) -> bool:
    return abs(product - 1.0) <= AGREEMENT


def _word(graph: BondGraph, loop: TransformerLoop, variable: Variable) -> str:
    return graph.word(graph.normal.bonds[loop.bond], variable)


def _between(loop: TransformerLoop) -> str:
    """What takes up a difference of the variable that runs round."""
    return "a compliance" if loop.variable is Variable.FLOW else "an inertia"
