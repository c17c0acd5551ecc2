"""The page on performance is written from plain data."""

import json
from pathlib import Path

import pytest

from benchmarks.__main__ import PARTS
from benchmarks.conditions import conditions
from benchmarks.document import write_document
from benchmarks.measure import interleaved, ratios, spread
from benchmarks.part import Part, paragraph, shown, table


def test_spreads_are_medians_with_quartiles():
    found = spread([5.0, 1.0, 2.0, 4.0, 3.0])
    assert (found.median, found.low, found.high, found.count) == (3.0, 2.0, 4.0, 5)
    assert shown(found.json(), 1000.0) == "3000 (2000 to 4000)"
    assert ratios([2.0, 6.0], [1.0, 2.0]).median == 2.5


def test_tasks_take_turns_after_a_round_that_does_not_count():
    order: list[str] = []

    def task(name: str) -> float:
        order.append(name)
        return float(len(order))

    found = interleaved({"a": lambda: task("a"), "b": lambda: task("b")}, 2)
    assert order == ["a", "b"] * 3
    assert found == {"a": [3.0, 5.0], "b": [4.0, 6.0]}


def test_a_part_that_was_not_measured_says_so(tmp_path: Path):
    parts = (
        Part(
            "x", "Some part", lambda _: {}, lambda data, _: [paragraph("It is", data["what"]), *table(["a"], [["1"]])]
        ),
        Part("y", "Another part", lambda _: {}, lambda _, __: []),
    )
    found = {
        "command": "python -m benchmarks --only x",
        "is_quick": True,
        "conditions": conditions(),
        "load": [0.5, 1.25],
        "data": {"what": "fast."},
    }
    write_document(parts, {"x": json.loads(json.dumps(found))}, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text()
    assert "## Some part\n\nIt is fast.\n\n| a |\n| --- |\n| 1 |\n" in text
    assert "`python -m benchmarks --only x`" in text
    assert "quick" in text
    assert "0.5 programs wanted to run before and 1.2 after" in text
    assert "Not measured; `python -m benchmarks --only y` does it." in text


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.letter)
def test_every_part_has_a_letter_and_a_title_of_its_own(part: Part):
    assert [(p.letter, p.title) for p in PARTS if p.letter == part.letter or p.title == part.title] == [
        (part.letter, part.title)
    ]
