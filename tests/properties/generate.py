"""Random bond graphs: webs of junctions over several domains, with whatever hangs on them."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np

from propermodel.modelling.model import ElementKind, JunctionKind
from tests.properties.graphs import DOMAINS, Coupler, Field, Graph, Knot, Modulus, OnePort, Wire

ONE_PORTS = (ElementKind.COMPLIANCE, ElementKind.INERTIA, ElementKind.RESISTANCE)
TWO_PORTS = (ElementKind.TRANSFORMER, ElementKind.GYRATOR)


def random_graph(random: Random, most_knots: int = 8) -> Graph:
    """A graph of one or two components; most junctions carry elements, and bonds beyond a tree close loops."""
    knots: list[Knot] = []
    links: list[tuple[int, int, bool]] = []  # two junctions, and whether a two-port joins them
    for component in range(random.choice((1, 1, 1, 1, 2))):
        first = len(knots)
        for number in range(random.randint(1, most_knots if component == 0 else 3)):
            _grow(random, knots, links, first, number)
        _close_loops(random, knots, links, first)
    one_ports = _one_ports(random, knots)
    fields = _fields(random, knots)
    wires = [Wire(*random.sample((i, j), 2)) for i, j, is_two_port in links if not is_two_port]
    couplers = [_coupler(random, *random.sample((i, j), 2), one_ports) for i, j, is_two_port in links if is_two_port]
    return Graph(tuple(knots), tuple(wires), tuple(one_ports), tuple(couplers), tuple(fields))


def _size(random: Random) -> float:
    return round(random.uniform(0.4, 2.5), 3)


def _grow(random: Random, knots: list[Knot], links: list[tuple[int, int, bool]], first: int, number: int) -> None:
    """A junction that hangs on an earlier one: by a bond where kinds differ, by a two-port over domains."""
    if not number:
        knots.append(Knot(random.choice(list(JunctionKind)), random.choice(DOMAINS).name))
        return
    other = random.randrange(first, len(knots))
    if random.random() < 0.65:
        knots.append(Knot(knots[other].kind.dual, knots[other].domain))
        links.append((other, len(knots) - 1, False))
    else:
        knots.append(Knot(random.choice(list(JunctionKind)), random.choice(DOMAINS).name))
        links.append((other, len(knots) - 1, True))


def _close_loops(random: Random, knots: list[Knot], links: list[tuple[int, int, bool]], first: int) -> None:
    """Up to three links more: rings of bonds, two-ports in parallel, loops over several domains."""
    if len(knots) - first < 2:
        return
    for _ in range(random.choice((0, 0, 1, 1, 2, 3))):
        i, j = random.sample(range(first, len(knots)), 2)
        joined = any({i, j} == {a, b} and not two for a, b, two in links)
        fits = knots[i].domain == knots[j].domain and knots[i].kind is not knots[j].kind and not joined
        links.append((i, j, not (fits and random.random() < 0.8)))


def _one_ports(random: Random, knots: list[Knot]) -> list[OnePort]:
    found: list[OnePort] = []
    for number in range(len(knots)):
        for _ in range(random.choice((0, 1, 1, 1, 2))):
            found.append(_one_port(random, number))
    while not any(one.kind.is_storage for one in found):
        found.append(_one_port(random, random.randrange(len(knots))))
    for _ in range(random.choice((0, 1, 1, 2))):
        number = random.randrange(len(knots))
        # The source that leaves the junction variable to others fits anywhere; the other one claims it.
        fits = ElementKind.FLOW_SOURCE if knots[number].kind is JunctionKind.ZERO else ElementKind.EFFORT_SOURCE
        claims = ElementKind.EFFORT_SOURCE if fits is ElementKind.FLOW_SOURCE else ElementKind.FLOW_SOURCE
        swing = _size(random) if random.random() < 0.6 else 0.0
        size = 0.0 if random.random() < 0.2 else _size(random)
        kind = fits if random.random() < 0.75 else claims
        found.append(OnePort(kind, number, size, swing=swing, turned=random.random() < 0.5))
    return found


def _one_port(random: Random, knot: int) -> OnePort:
    kind = random.choice(ONE_PORTS)
    law = random.choices(("linear", "sinh", "cubic"), (0.7, 0.2, 0.1))[0]
    return OnePort(kind, knot, _size(random), law=law, turned=random.random() < 0.25)


def _coupler(random: Random, i: int, j: int, one_ports: list[OnePort]) -> Coupler:
    storages = [n for n, one in enumerate(one_ports) if one.kind.is_storage]
    modulus = Modulus(_size(random) * random.choice((1.0, 1.0, -1.0)))
    draw = random.random()
    if draw < 0.12:
        modulus = replace(modulus, depth=0.4)
    elif draw < 0.24:
        modulus = replace(modulus, depth=0.4, storage=random.choice(storages))
    turned = (random.random() < 0.2, random.random() < 0.2)
    return Coupler(random.choice(TWO_PORTS), (i, j), modulus, turned)


def _fields(random: Random, knots: list[Knot]) -> list[Field]:
    if random.random() > 0.25:
        return []
    numbers = random.sample(range(len(knots)), min(len(knots), random.choice((2, 2, 3))))
    kind = random.choice(ONE_PORTS)
    size = len(numbers)
    root = np.array([[random.uniform(-0.7, 0.7) for _ in range(size)] for _ in range(size)])
    matrix = root @ root.T + 0.6 * np.eye(size)
    if kind is ElementKind.RESISTANCE and random.random() < 0.5:
        matrix = matrix + np.triu(root, 1) - np.triu(root, 1).T  # passes power from port to port as a gyrator does
    return [Field(kind, tuple(numbers), tuple(tuple(map(float, row)) for row in np.round(matrix, 3)))]
