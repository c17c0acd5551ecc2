"""Writes `docs/performance.md` from measured data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.measure import Json
from benchmarks.part import COMMAND, Part, paragraph

_HEAD = (
    "Written by `make bench` from what it measures; `python -m benchmarks --only a d` measures",
    "parts, and `--quick` takes",
    "minutes in place of an hour. Figures are medians with quartiles of interleaved repeats, so ratios hold also where",
    "the machine was busy with other work, and times less so: the line below each part tells how",
    "busy it was. Peers come",
    'with `pip install -e ".[bench]" -c constraints.txt`; where one is missing its row says so.',
)


def write_document(parts: Sequence[Part], data: Mapping[str, Json], file: Path) -> None:
    """Write the page; parts without data say that they were not measured."""
    pictures = file.parent / "images"
    pictures.mkdir(parents=True, exist_ok=True)
    lines = ["# Performance", "", paragraph(*_HEAD), ""]
    for part in parts:
        lines += [f"## {part.title}", ""]
        found = data.get(part.letter)
        if found is None:
            lines += [f"Not measured; `{COMMAND} --only {part.letter}` does it.", ""]
            continue
        lines += part.write(found["data"], pictures)
        lines += ["", *_conditions(found), ""]
    file.write_text("\n".join(lines).replace("\n\n\n", "\n\n").rstrip() + "\n", encoding="utf-8")


def _conditions(found: Json) -> list[str]:
    machine, loads = found["conditions"], found["load"]
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    gcc = f", gcc {machine['gcc']}" if machine["gcc"] else ""
    busy = "" if None in loads else f"; {loads[0]:.1f} programs wanted to run before and {loads[1]:.1f} after"
    quick = ", quick" if found["is_quick"] else ""
    return [
        paragraph(
            f"*`{found['command']}`, {machine['date']}{quick}: {machine['processor']}, {machine['cores']} cores{busy};",
            f"{machine['system']}, Python {machine['python']}, {packages}{gcc}.*",
        )
    ]
