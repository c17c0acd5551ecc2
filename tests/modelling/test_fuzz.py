"""Documents that strangers have changed: each is refused with a diagnostic, or makes a model, in bounded time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.bondgraph.flatten import flatten
from propermodel.causality.assign import assign_causality
from propermodel.diagnostics import DocumentError, ProperModelError
from propermodel.equations.formulate import formulate
from propermodel.modelling.documents import (
    from_document,
    from_scenario_document,
    to_document,
    to_scenario_document,
)
from tests.examples.runs import module, subject
from tests.modelling.test_documents import BUMP, REMOVALS, VEHICLE, through_json
from tests.strangers import changed_documents

EXAMPLES = (
    "bouncing_ball",  # events and impulses
    "coupled_coils",  # a field
    "cruise_control",  # signals
    "four_bar_linkage",  # positions
    "heater",  # true and pseudo bonds
    "hydraulic_servo",
    "slider_crank_chain",  # closed loops
)
MODELS = [VEHICLE.without(REMOVALS[:1]), *(subject(name).model for name in EXAMPLES)]
T = TypeVar("T")
SECONDS = 5.0  # each, of CPU; most take some milliseconds


def opened(document: Any, read: Callable[[Any], T]) -> T | None:
    """What a document holds; what is refused is explained in some lines."""
    try:
        return read(document)
    except DocumentError as error:
        refused = error
    for fault in refused.diagnostics:
        assert fault.code
        assert fault.message
        assert fault.help
    assert len(str(refused)) < 10_000
    return None


def refused_or_equal(document: Any) -> None:
    model = opened(document, from_document)
    if model is None:
        return
    assert from_document(through_json(to_document(model))) == model
    try:
        formulate(assign_causality(flatten(model)))
    except ProperModelError:
        return


@given(st.sampled_from([through_json(to_document(model)) for model in MODELS]).flatmap(changed_documents))
@settings(max_examples=200)
def test_changed_documents_are_refused_or_make_a_model(document: Any):
    started = time.process_time()
    refused_or_equal(document)
    assert time.process_time() - started < SECONDS


@given(
    st.sampled_from(
        [through_json(to_scenario_document(s)) for s in (BUMP, module("hydraulic_servo").scenario())]
    ).flatmap(changed_documents)
)
@settings(max_examples=200)
def test_changed_scenarios_are_refused_or_make_a_scenario(document: Any):
    started = time.process_time()
    scenario = opened(document, from_scenario_document)
    if scenario is not None:
        assert from_scenario_document(through_json(to_scenario_document(scenario))) == scenario
    assert time.process_time() - started < SECONDS


@given(st.recursive(st.one_of(st.none(), st.integers(), st.floats(), st.text(), st.binary()), st.lists))
@settings(max_examples=50)
def test_anything_else_is_refused(document: Any):
    for read in (from_document, from_scenario_document):
        with pytest.raises(DocumentError):
            read(document)


def test_a_path_of_many_names_is_not_told_in_full():
    document = through_json(to_document(subject("hydraulic_servo").model))
    definition = next(d for d in document["definitions"] if d["type_name"] == "PositionServo")
    link = next(c for c in definition["connections"] if "ports" in c)
    link["ports"][0] = ".".join([link["ports"][0]] * 1000)
    refused_or_equal(document)
