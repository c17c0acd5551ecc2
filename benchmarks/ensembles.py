"""Part c: many designs of the truck at once, against numba over threads and JAX over a batch."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from benchmarks.measure import Json, interleaved, ratios, spread
from benchmarks.part import Part, paragraph, shown, table
from benchmarks.python_peers import Answer, with_jax, with_numba
from propermodel.codegen.build import Backend, best_lanes
from propermodel.codegen.machine import Memory, Method, Request
from propermodel.codegen.native import NativeMachine
from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.ensemble import designs
from propermodel.simulation.side_by_side import joined, lane_of
from propermodel.simulation.start import start_of
from propermodel.simulation.table_store import TableStore

OURS = "propermodel"
STEP = 2e-4  # s
REPEATS = 5


def measure(is_quick: bool) -> Json:
    """Processor and wall time a design and step, and how far the answers are apart."""
    count = 16 if is_quick else 256
    truck = compile_model(elaborate(HybridTruck()))
    scenario = mission("fmtv_mixed", until=0.2 if is_quick else 1.0)
    memory = _designs(truck, scenario, count)
    program = truck.lowered.program
    made: dict[str, Callable[[], Answer]] = {}
    compile_s: dict[str, float] = {}
    missing: dict[str, str] = {}
    makers = {
        OURS: lambda: _ours(truck, memory, scenario.stop),
        "numba, prange": lambda: with_numba(program, memory, STEP, scenario.stop),
        "JAX, vmap": lambda: with_jax(program, memory, STEP, scenario.stop),
    }
    for name, make in makers.items():
        package = name.split(",")[0].lower()
        if name != OURS and find_spec(package) is None:
            missing[name] = f"{package} is not installed"
            continue
        begin = time.process_time()
        made[name] = make()
        if name != OURS:
            made[name]()  # compiles when it is called
        compile_s[name] = time.process_time() - begin
    answers = {name: run() for name, run in made.items()}
    per_step = count * (scenario.stop - scenario.start) / STEP
    processor = interleaved({name: lambda r=run: _timed(r, time.process_time) for name, run in made.items()}, REPEATS)
    wall = interleaved({name: lambda r=run: _timed(r, time.perf_counter) for name, run in made.items()}, REPEATS)
    return {
        "count": count,
        "window": scenario.stop,
        "cores": os.cpu_count() or 1,
        "rows": {
            name: {
                "processor": spread(value / per_step for value in processor[name]).json(),
                "wall": spread(value / per_step for value in wall[name]).json(),
                "slower": ratios(processor[name], processor[OURS]).json(),
                "slower_wall": ratios(wall[name], wall[OURS]).json(),
                "compile_s": compile_s[name],
                "difference": _difference(answers[name], answers[OURS]),
            }
            for name in made
        },
        "missing": missing,
    }


def _timed(run: Callable[[], object], clock: Callable[[], float]) -> float:
    begin = clock()
    run()
    return clock() - begin


def _designs(truck: CompiledModel, scenario: Scenario, count: int) -> Memory:
    store = TableStore()
    many = designs(scenario, {"sprung_mass": np.linspace(12_000.0, 14_000.0, count)})
    starts = [start_of(truck, design, store).memory for design in many]
    return joined([replace(start, tables=starts[0].tables) for start in starts], count)


def _ours(truck: CompiledModel, memory: Memory, stop: float) -> Callable[[], Answer]:
    lanes = best_lanes(Backend.NATIVE)
    machine = NativeMachine(truck.lowered.program, Method.SEMI_IMPLICIT, lanes, long_run=0)
    singles = [lane_of(memory, k) for k in range(memory.alive.size)]
    groups = [joined(singles[k : k + lanes], lanes) for k in range(0, len(singles), lanes)]
    request = Request(until=stop, step=STEP, most_ticks=10**9)

    def run_group(group: Memory) -> Memory:
        own = group.copy()
        machine.run(own, request)
        return own

    def run() -> Answer:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            done = list(pool.map(run_group, groups))
        states = np.concatenate([group.state.T for group in done])
        activities = np.concatenate([group.activity.T for group in done])
        return states[: len(singles)], activities[: len(singles)]

    return run


def _difference(found: Answer, ours: Answer) -> float:
    """The largest difference of the activity of a bond, as a share of all of a design."""
    return float(np.max(np.abs(found[1] - ours[1]) / ours[1].sum(axis=1, keepdims=True)))


def write(data: Json, _: Path) -> list[str]:
    """The table."""
    rows = [
        [
            name,
            shown(row["processor"], 1e9),
            shown(row["slower"]) if name != OURS else "1",
            shown(row["wall"], 1e9),
            shown(row["slower_wall"]) if name != OURS else "1",
            f"{row['compile_s']:.1f}",
            f"{row['difference']:.0e}" if name != OURS else "",
        ]
        for name, row in data["rows"].items()
    ]
    rows += [[name, "-", "-", "-", "-", "-", f"not measured: {why}"] for name, why in data["missing"].items()]
    head = ["code", "ns of processor", "times ours", "ns of wall", "times ours", "compile s", "activity differs by"]
    return [
        paragraph(
            f"{data['count']} designs of the full truck that differ in a mass, {data['window']:g} s in steps of",
            f"{1e3 * STEP:g} ms of semi-implicit Euler with all integrals of |power| and sampled controllers, without",
            "recording. numba and JAX compile the same program printed as Python, in double precision, with the plain",
            f"Newton's method. Times are nanoseconds for a design and a step, all on {data['cores']} cores.",
        ),
        *table(head, rows),
    ]


PART = Part("c", "Ensembles", measure, write)
