"""How long new processes take to import the package, and to reach the first step of the truck."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from benchmarks.measure import Json, interleaved, spread
from benchmarks.part import Part, paragraph, shown, table
from propermodel.codegen.object_cache import OFF, VARIABLE

REPEATS = 11

# Seconds of processor time that a new process spends on this.
TIMED = """
import time
begin = time.process_time()
{}
print(time.process_time() - begin)
"""
IMPORT = "import propermodel"
FIRST_STEP = """
from propermodel import Method, compile_model, elaborate
from propermodel.library.vehicle.truck import HybridTruck
compile_model(elaborate(HybridTruck())).machine(Method.SEMI_IMPLICIT)
"""


def measure(is_quick: bool) -> Json:
    """Processor seconds of new processes."""
    with tempfile.TemporaryDirectory() as folder:
        # As a user has it: the byte code of Python is kept, too.
        usual = os.environ | {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        without, kept = usual | {VARIABLE: OFF}, usual | {VARIABLE: folder}
        _seconds(FIRST_STEP, kept)
        tasks = {
            "`import numpy`, for comparison": lambda: _seconds("import numpy", without),
            "`import propermodel`": lambda: _seconds(IMPORT, without),
            "truck, from source to machine code": lambda: _seconds(FIRST_STEP, without),
            "the same, code kept by an earlier process": lambda: _seconds(FIRST_STEP, kept),
        }
        times = interleaved(tasks, 3 if is_quick else REPEATS)
    return {name: spread(values).json() for name, values in times.items()}


def _seconds(code: str, environment: Mapping[str, str]) -> float:
    command = [sys.executable, "-c", TIMED.format(code)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout)


def write(data: Json, _: Path) -> list[str]:
    """The table."""
    return [
        paragraph("Processor time that a new process spends."),
        *table(["start", "s"], [[name, shown(seconds)] for name, seconds in data.items()]),
    ]


PART = Part("s", "Starts", measure, write)
