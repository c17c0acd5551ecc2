"""The index of error codes names codes that exist, with the first line of what is printed."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from tests.faults.case import ROOT
from tests.faults.test_cases import CASES

INDEX = (ROOT / "docs" / "errors.md").read_text(encoding="utf-8")
CODE = re.compile(r"(?!application/)[a-z]{4,}/[a-z][a-z-]+")  # not the type of a medium


def codes_in(file: Path) -> set[str]:
    """The texts of a source file that have the form of a code."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and CODE.fullmatch(node.value)
    }


def test_the_index_lists_the_codes_of_the_source():
    source = set[str]().union(*map(codes_in, (ROOT / "src").rglob("*.py")))
    listed = set(re.findall(r"^### `(.+)`$", INDEX, re.MULTILINE))
    assert source
    assert source == listed


def test_the_index_has_every_fault_of_the_tables():
    assert {case.code for case in CASES} == set(re.findall(r"^### `(.+)`$", INDEX, re.MULTILINE))


def test_the_index_shows_what_is_printed():
    for case in CASES:
        first = next(line for line in case.text().splitlines() if line.startswith(("error[", "warning[")))
        if str(ROOT) not in first:
            assert first in INDEX
