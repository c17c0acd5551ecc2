"""Part d: how compiling, stepping and memory grow with the size of a model, beside the equations of other tools."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from benchmarks.equation_peers import measure_peers
from benchmarks.measure import Json, spread
from benchmarks.part import Part, paragraph, rounded, shown, table

SIZES = (10, 57, 200, 500, 1000, 2000, 5000)
GROWS_FROM = 57
REPEATS = 5

# A process of its own for each chain: memory is that of this model alone, and nothing is known from an earlier one.
CHAIN = """
import json, resource, sys, time
from benchmarks.chain import chain_model
from propermodel.codegen.machine import Method, Request
from propermodel.codegen.native import NativeMachine
from propermodel.compiler import compile_model
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import start_of
size, steps = int(sys.argv[1]), int(sys.argv[2])
compile_model(elaborate(chain_model(3))).machine(Method.SEMI_IMPLICIT)
marks = [time.process_time()]
compiled = compile_model(elaborate(chain_model(size)))
marks.append(time.process_time())
machine = NativeMachine(compiled.lowered.program, Method.SEMI_IMPLICIT, long_run=0)
memory = start_of(compiled, Scenario(stop=1e9)).memory
machine.run(memory, Request(until=1e-4, step=1e-4))
marks.append(time.process_time())
per_step = []
for _ in range(5):
    begin, before = time.process_time(), memory.steps_taken
    machine.run(memory, Request(until=memory.time + steps * 1e-4, step=1e-4, most_ticks=10**9))
    per_step.append((time.process_time() - begin) / (memory.steps_taken - before))
unit = 2**20 if sys.platform == "darwin" else 2**10
print(json.dumps({
    "equations": marks[1] - marks[0],
    "native": marks[2] - marks[1],
    "per_step": per_step,
    "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit,
}))
"""


def measure(is_quick: bool) -> Json:
    """Processor seconds, nanoseconds a step and megabytes for growing chains."""
    sizes = SIZES[:5] if is_quick else SIZES
    rows: list[Json] = []
    for size in sizes:
        repeats = 1 if is_quick or size > 500 else REPEATS
        found = [_chain(size, steps=max(2000, 400_000 // size)) for _ in range(repeats)]
        rows.append(
            {
                "size": size,
                "equations": spread(one["equations"] for one in found).json(),
                "native": spread(one["native"] for one in found).json(),
                "total": spread(one["equations"] + one["native"] for one in found).json(),
                "per_step": spread(value for one in found for value in one["per_step"]).json(),
                "memory_mb": median(one["memory_mb"] for one in found),
            }
        )
    peers = [] if is_quick else [{"peer": p.peer, "text": str(p).strip()} for p in measure_peers()]
    return {"rows": rows, "peers": peers}


def _chain(size: int, steps: int) -> Json:
    command = [sys.executable, "-c", CHAIN, str(size), str(steps)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def slope(rows: Sequence[Json], key: str) -> float:
    """The exponent of a power law through the medians of larger sizes, by least squares of the logarithms."""
    large = [row for row in rows if row["size"] >= GROWS_FROM]
    x = [math.log(row["size"]) for row in large]
    y = [math.log(row[key]["median"]) for row in large]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / sum((a - mean_x) ** 2 for a in x)


def write(data: Json, pictures: Path) -> list[str]:
    """The table, the exponents and a picture."""
    rows = data["rows"]
    text = [
        paragraph(
            "A chain of N masses, springs and dampers, from its classes to machine code compiled",
            "thoroughly, semi-implicit",
            "Euler with the integrals of power of all bonds. Each N has processes of its own; times",
            "are processor seconds.",
        ),
        *table(
            ["N", "equations s", "machine code s", "both s", "ns a step", "ns a step and N", "memory MB"],
            [
                [
                    str(row["size"]),
                    shown(row["equations"]),
                    shown(row["native"]),
                    shown(row["total"]),
                    shown(row["per_step"], 1e9),
                    rounded(1e9 * row["per_step"]["median"] / row["size"]),
                    f"{row['memory_mb']:.0f}",
                ]
                for row in rows
            ],
            numbers_from=0,
        ),
        paragraph(
            f"From N = {GROWS_FROM}, time to machine code grows as N to the",
            f"{slope(rows, 'total'):.2f}, and the time of a step",
            f"as N to the {slope(rows, 'per_step'):.2f}.",
        ),
    ]
    if data["peers"]:
        text += ["", "Other tools, from the same chain to its equations:", ""]
        text += [f"- {peer['text']}" for peer in data["peers"]]
    _draw(rows, pictures / "performance_growth.png")
    return [*text, "", "![Growth with the size of a model](images/performance_growth.png)"]


def _draw(rows: Sequence[Json], file: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots(1, 2)
    sizes = [row["size"] for row in rows]
    for key, label in (("equations", "equations"), ("native", "machine code"), ("total", "both")):
        axes[0].loglog(sizes, [row[key]["median"] for row in rows], marker="o", label=label)
    axes[0].set(xlabel="sections", ylabel="processor time, s")
    axes[0].legend()
    axes[1].loglog(sizes, [1e6 * row["per_step"]["median"] for row in rows], marker="o")
    axes[1].set(xlabel="sections", ylabel="a step, µs")
    for each in axes:
        each.grid(alpha=0.3)
    figure.savefig(file, dpi=120)


PART = Part("d", "Growth with the size of a model", measure, write)
