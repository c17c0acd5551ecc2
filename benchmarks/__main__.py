"""`python -m benchmarks`: measures how fast everything is, beside others, and writes `docs/performance.md`.

What is measured is kept as JSON in `out/bench`, one file for each part; the page is written from all that is there.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

from benchmarks import against_c, ensembles, growth, lanes, reduced, starts, work_precision
from benchmarks.conditions import conditions, load
from benchmarks.document import write_document
from benchmarks.measure import Json
from benchmarks.part import COMMAND, Part
from propermodel.codegen.object_cache import OFF, VARIABLE

PARTS: tuple[Part, ...] = (
    starts.PART,
    against_c.PART,
    work_precision.PART,
    ensembles.PART,
    growth.PART,
    lanes.PART,
    reduced.PART,
)
DATA = Path("out/bench")
PAGE = Path("docs/performance.md")


def main() -> None:
    """Measure the parts that are asked for, then write the page."""
    letters = [part.letter for part in PARTS]
    options = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    options.add_argument("--only", nargs="*", choices=letters, default=letters, help="parts to measure (default: all)")
    options.add_argument("--quick", action="store_true", help="fewer repeats of shorter runs")
    options.add_argument("--page", type=Path, default=PAGE, help=f"the page to write (default: {PAGE})")
    asked = options.parse_args()
    os.environ[VARIABLE] = OFF  # compiling is measured, not reading what an earlier run has left
    DATA.mkdir(parents=True, exist_ok=True)
    for part in PARTS:
        if part.letter in asked.only:
            print(f"{part.letter}: {part.title}", file=sys.stderr, flush=True)
            (DATA / f"{part.letter}.json").write_text(json.dumps(_measured(part, asked.quick), indent=1))
    found = {letter: json.loads(file.read_text()) for letter in letters if (file := DATA / f"{letter}.json").exists()}
    write_document(PARTS, found, asked.page)


def _measured(part: Part, is_quick: bool) -> Json:
    before = load()
    data = part.measure(is_quick)
    return {
        "command": f"{COMMAND} --only {part.letter}{' --quick' if is_quick else ''}",
        "is_quick": is_quick,
        "conditions": conditions(),
        "load": [before, load()],
        "data": data,
    }


if __name__ == "__main__":
    main()
