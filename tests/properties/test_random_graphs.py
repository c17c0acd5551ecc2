"""Whatever is drawn: it is answered as dense linear algebra answers it, or refused because it has no one answer."""

from __future__ import annotations

import json
from collections import Counter
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from propermodel.modelling.documents import from_document, to_document
from tests.properties.answers import Answer, Outcome, answer_to, compile_or_refuse, compiled, drawn
from tests.properties.generate import random_graph
from tests.properties.graphs import model_of

SEEDS = range(520)


@pytest.fixture(scope="module")
def answers() -> dict[int, Answer]:
    """The answers to all graphs; `pytest -s` shows how many there are of each kind."""
    found = {seed: answer_to(drawn(seed), compiled(seed), seed) for seed in SEEDS}
    for (outcome, code), count in Counter((a.outcome, a.code) for a in found.values()).most_common():
        print(f"{count:5} {outcome}{f' ({code})' if code else ''}")
    return found


def seeds_of(answers: dict[int, Answer], outcome: Outcome) -> list[int]:
    return [seed for seed, answer in answers.items() if answer.outcome is outcome]


def test_most_graphs_are_accepted(answers: dict[int, Answer]):
    refused = seeds_of(answers, Outcome.REFUSED) + seeds_of(answers, Outcome.WRONGLY_REFUSED)
    assert len(answers) >= 500
    assert len(refused) <= 0.2 * len(answers)


def test_what_is_refused_is_singular(answers: dict[int, Answer]):
    assert seeds_of(answers, Outcome.WRONGLY_REFUSED) == []
    assert len(seeds_of(answers, Outcome.REFUSED)) >= 10  # the graphs include what must be refused


def test_efforts_flows_and_rates_are_those_of_the_reference(answers: dict[int, Answer]):
    assert seeds_of(answers, Outcome.DIFFERS) == []
    assert len(seeds_of(answers, Outcome.UNSOLVED)) <= 0.01 * len(answers)


@settings(max_examples=30, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(random=st.randoms(use_true_random=False))
def test_graphs_at_the_edges_of_chance_are_answered_as_well(random: Random):
    """Hypothesis draws extremes and repetitions that chance rarely gives, and shrinks what fails."""
    graph = random_graph(random)
    outcome = answer_to(graph, compile_or_refuse(graph), 0).outcome
    assert outcome in (Outcome.AGREES, Outcome.REFUSED)


def test_graphs_are_the_same_models_as_documents():
    for seed in range(100):
        model = model_of(drawn(seed))
        assert from_document(json.loads(json.dumps(to_document(model)))) == model


def test_almost_all_that_is_determined_is_given(answers: dict[int, Answer]):
    """A law that is given one way only says nothing at an element that simplification leaves idle."""
    regular = [a for a in answers.values() if a.outcome is Outcome.AGREES and a.verdict != "singular"]
    assert sum(a.undetermined > 0 for a in regular) <= 0.01 * len(regular)


def test_graphs_are_webs_of_many_kinds():
    graphs = [drawn(seed) for seed in SEEDS]
    loops = [len(g.wires) + len(g.couplers) - len(g.knots) + 1 for g in graphs]
    assert sum(n > 0 for n in loops) > 200
    assert sum(len({k.domain for k in g.knots}) > 1 for g in graphs) > 200
    assert sum(bool(g.fields) for g in graphs) > 80
    assert sum(any(two.modulus.depth for two in g.couplers) for g in graphs) > 80
    models = [m for m in map(compiled, SEEDS) if not isinstance(m, Exception)]
    assert sum(bool(m.system.dependents) for m in models) > 150
    assert sum(bool(m.system.blocks or m.system.solved) for m in models) > 200
