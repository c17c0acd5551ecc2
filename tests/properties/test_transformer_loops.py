"""Rings of two-ports: refused where dense linear algebra finds them singular, and locked where it does not."""

from __future__ import annotations

from random import Random

import pytest

from propermodel.compiler import CompiledModel
from propermodel.diagnostics import ProperModelError
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.properties.answers import Outcome, answer_to, compile_or_refuse
from tests.properties.graphs import DOMAINS, Coupler, Graph, Knot, Modulus, OnePort
from tests.properties.reference import Verdict

STORAGE = {JunctionKind.ONE: ElementKind.INERTIA, JunctionKind.ZERO: ElementKind.COMPLIANCE}
SEEDS = range(40)


def ring(random: Random, product: float) -> Graph:
    """Junctions that hold a storage each, joined in a ring by two-ports whose moduli multiply to a product."""
    count = random.randint(2, 5)
    knots = tuple(Knot(random.choice(list(JunctionKind)), random.choice(DOMAINS).name) for _ in range(count))
    ratio = 1.0  # of the common variable of a junction to that of the first
    couplers: list[Coupler] = []
    for number in range(count):
        a, b = knots[number], knots[(number + 1) % count]
        step = random.uniform(0.5, 2.0) if number < count - 1 else product / ratio
        ratio *= step
        kind = ElementKind.TRANSFORMER if a.kind is b.kind else ElementKind.GYRATOR
        # f_b = m f_a and e_a = m e_b; e_b = r f_a and e_a = r f_b.
        modulus = step if a.kind is JunctionKind.ONE else 1.0 / step
        couplers.append(Coupler(kind, (number, (number + 1) % count), Modulus(modulus)))
    ones = tuple(OnePort(STORAGE[knot.kind], number, random.uniform(0.5, 2.0)) for number, knot in enumerate(knots))
    return Graph(knots, (), ones, tuple(couplers))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_ring_of_product_one_is_refused_and_singular(seed: int):
    graph = ring(Random(seed), 1.0)
    error = compile_or_refuse(graph)
    assert isinstance(error, ProperModelError)
    assert [d.code for d in error.diagnostics] == ["causality/transformer-loop"]
    assert {item.path for item in error.diagnostics[0].involved} == {f"t{n}" for n in range(len(graph.couplers))}
    assert answer_to(graph, error, seed).outcome is Outcome.REFUSED


@pytest.mark.parametrize("seed", SEEDS)
def test_a_ring_of_another_product_stands_still(seed: int):
    graph = ring(Random(seed), 1.5)
    model = compile_or_refuse(graph)
    assert isinstance(model, CompiledModel)
    (warning,) = model.warnings
    assert warning.code == "causality/transformer-lock"
    assert "of the ratio 1.5," in warning.message or "of the ratio 0.666667," in warning.message
    answer = answer_to(graph, model, seed)
    assert (answer.outcome, answer.verdict) == (Outcome.AGREES, Verdict.REGULAR)
    assert model.system.states == ()
