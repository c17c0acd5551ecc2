"""The README is a test: its model runs and prints what the page says."""

from __future__ import annotations

import re
from pathlib import Path

README = Path(__file__).parent.parent / "README.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


def test_the_quarter_car_prints_the_ranking_of_the_page(capsys) -> None:
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {"__name__": "readme"})
    (printed,) = blocks("text")
    assert capsys.readouterr().out.strip() == printed.strip()


def test_the_quarter_car_has_twenty_lines() -> None:
    (code,) = blocks("python")
    assert len([line for line in code.splitlines() if line.strip()]) <= 22
