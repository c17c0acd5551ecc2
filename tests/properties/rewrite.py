"""One physics drawn in other ways: what changes is the drawing, and at most the sign of an element's variables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random

from propermodel.modelling.domains import Shared
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.properties.graphs import Coupler, Field, Graph, Knot, Modulus, OnePort, Wire


@dataclass(frozen=True)
class Redrawn:
    """A graph drawn in another way; `signs` says by port where effort, flow and stored quantity changed sign."""

    graph: Graph
    signs: dict[str, float]


def with_arrows_reversed(graph: Graph, random: Random) -> Redrawn:
    """The half arrows between some junctions and all others point the other way, and those at some elements.

    Reversing all bonds of a junction but those of its elements changes the sign of their variables; sources and moduli
    take the sign as well. An element whose arrow points away from it meets the junction at a node of its domain's kind:
    where the junction is of that kind nothing changes for it, otherwise its variables change their sign.
    """
    of_knot = [random.choice((1.0, -1.0)) for _ in graph.knots]
    wires = tuple(Wire(w.head, w.tail) if of_knot[w.tail] != of_knot[w.head] else w for w in graph.wires)
    ones: list[OnePort] = []
    signs: dict[str, float] = {}
    for number, one in enumerate(graph.one_ports):
        sign = of_knot[one.knot]
        if one.kind in (ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE):
            ones.append(replace(one, size=sign * one.size, swing=sign * one.swing))
        elif random.random() < 0.5:
            shares_flow = graph.domain(one.knot).shared is Shared.FLOW
            sign *= 1.0 if (graph.knots[one.knot].kind is JunctionKind.ONE) is shares_flow else -1.0
            ones.append(replace(one, turned=not one.turned))
        else:
            ones.append(one)
        signs[f"e{number}.port"] = sign
    couplers: list[Coupler] = []
    for number, two in enumerate(graph.couplers):
        a, b = (of_knot[knot] for knot in two.knots)
        m = two.modulus
        argument = signs[f"e{m.storage}.port"] if m.storage is not None else 1.0
        couplers.append(replace(two, modulus=replace(m, size=a * b * m.size, depth=argument * m.depth)))
        signs |= {f"t{number}.a": a, f"t{number}.b": b}
    fields: list[Field] = []
    for number, many in enumerate(graph.fields):
        along = [of_knot[knot] for knot in many.knots]
        matrix = tuple(
            tuple(si * sj * x for sj, x in zip(along, row, strict=True))
            for si, row in zip(along, many.matrix, strict=True)
        )
        fields.append(replace(many, matrix=matrix))
        signs |= {f"m{number}.{port}": sign for port, sign in zip(many.ports, along, strict=True)}
    return Redrawn(Graph(graph.knots, wires, tuple(ones), tuple(couplers), tuple(fields)), signs)


def with_two_ports_inserted(graph: Graph, random: Random) -> Redrawn:
    """Some elements hang behind a transformer of 1, others behind two gyrators of one modulus."""
    knots, couplers, ones = list(graph.knots), list(graph.couplers), []
    for one in graph.one_ports:
        draw = random.random()
        knot = one.knot
        # What a half arrow away from an element means depends on the kind of junction that it points to.
        kind = graph.knots[knot].kind if one.turned else random.choice(list(JunctionKind))
        if draw < 0.3:
            knots.append(Knot(kind, graph.knots[knot].domain))
            couplers.append(Coupler(ElementKind.TRANSFORMER, (knot, len(knots) - 1), Modulus(1.0)))
        elif draw < 0.5:
            size = random.uniform(0.5, 2.0)
            # A gyrator and its inverse: e_a = r f_m and e_m = r f_a; then e_m = r f_b and e_b = r f_m.
            knots.append(Knot(random.choice(list(JunctionKind)), "electrical"))
            knots.append(Knot(kind, graph.knots[knot].domain))
            couplers.append(Coupler(ElementKind.GYRATOR, (knot, len(knots) - 2), Modulus(size)))
            couplers.append(Coupler(ElementKind.GYRATOR, (len(knots) - 2, len(knots) - 1), Modulus(size)))
        ones.append(one if knot == one.knot and draw >= 0.5 else replace(one, knot=len(knots) - 1))
    return Redrawn(replace(graph, knots=tuple(knots), couplers=tuple(couplers), one_ports=tuple(ones)), {})


def with_junctions_split(graph: Graph, random: Random) -> Redrawn:
    """Junctions become two that a bond joins, and share what hung on them."""
    knots, wires, ones = list(graph.knots), list(graph.wires), list(graph.one_ports)
    for number in range(len(graph.knots)):
        if random.random() < 0.5:
            continue
        knots.append(graph.knots[number])
        wires.append(Wire(*random.sample((number, len(knots) - 1), 2)))
        moved = [n for n, one in enumerate(ones) if one.knot == number and random.random() < 0.5]
        for n in moved:
            ones[n] = replace(ones[n], knot=len(knots) - 1)
    return Redrawn(replace(graph, knots=tuple(knots), wires=tuple(wires), one_ports=tuple(ones)), {})


def with_stiff_couplings(graph: Graph, storages: set[int], stiffness: float) -> Graph:
    """Each of these one-port storages moves on its own, on a stiff and damped coupling to where it hung."""
    knots, wires, ones = list(graph.knots), list(graph.wires), list(graph.one_ports)
    for number in sorted(storages):
        one = graph.one_ports[number]
        domain = graph.knots[one.knot].domain
        is_inertia = one.kind is ElementKind.INERTIA
        # An inertia keeps its flow: a compliance takes the difference of flows. The dual for a compliance.
        own, between = (JunctionKind.ONE, JunctionKind.ZERO) if is_inertia else (JunctionKind.ZERO, JunctionKind.ONE)
        start = one.knot
        if graph.knots[start].kind is not own:
            knots.append(Knot(own, domain))
            wires.append(Wire(start, len(knots) - 1))
            start = len(knots) - 1
        knots.extend((Knot(between, domain), Knot(own, domain), Knot(own, domain)))
        middle, side, end = len(knots) - 3, len(knots) - 2, len(knots) - 1
        wires.extend((Wire(start, middle), Wire(middle, side), Wire(middle, end)))
        kind = ElementKind.COMPLIANCE if is_inertia else ElementKind.INERTIA
        ones[number] = replace(one, knot=end)
        ones.append(OnePort(kind, side, stiffness))
        loss = stiffness**0.5 if is_inertia else stiffness**-0.5
        ones.append(OnePort(ElementKind.RESISTANCE, side, loss))
    return replace(graph, knots=tuple(knots), wires=tuple(wires), one_ports=tuple(ones))
