"""Every fault of the tables is met through the public interface, and its text tells what, where and the cure."""

from __future__ import annotations

import re

import pytest

from tests.faults import (
    activity_cases,
    document_cases,
    drawing_cases,
    linear_cases,
    mechanism_cases,
    model_cases,
    reduction_cases,
    simulation_cases,
    structure_cases,
    studio_cases,
    vector_port_cases,
)
from tests.faults.case import Case

CASES = (
    *model_cases.CASES,
    *structure_cases.CASES,
    *simulation_cases.CASES,
    *activity_cases.CASES,
    *reduction_cases.CASES,
    *document_cases.CASES,
    *drawing_cases.CASES,
    *linear_cases.CASES,
    *mechanism_cases.CASES,
    *studio_cases.CASES,
    *vector_port_cases.CASES,
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.code)
def test_a_fault_is_explained_to_the_person_who_can_fix_it(case: Case):
    text = case.text()
    assert re.search(rf"^(error|warning)\[{case.code}\]: ", text, re.MULTILINE)
    for name in case.names:
        assert name in text
    help = text.partition("\n  help: ")[2]
    assert case.cure
    assert case.cure in help
    if case.at:
        assert any(case.at in line for line in case.lines_pointed_at(text)), text
