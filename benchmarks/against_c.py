"""Part a: the machine code of the package against the same arithmetic printed as C and compiled by GCC."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.c_machine import SETTINGS, CMachine, compiler
from benchmarks.chain import chain_model
from benchmarks.measure import Json, cpu_seconds, interleaved, ratios, spread
from benchmarks.part import Part, paragraph, shown, table
from propermodel.codegen.build import Backend, best_lanes
from propermodel.codegen.machine import Machine, Memory, Method, Request
from propermodel.codegen.native import NativeMachine
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import parse_path
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.ensemble import designs
from propermodel.simulation.side_by_side import joined
from propermodel.simulation.start import parameter_values, start_of

OURS = "propermodel"
METHODS = (Method.EULER, Method.SEMI_IMPLICIT)
STEP = 2e-4  # s
REPEATS = 9


@dataclass(frozen=True)
class Subject:
    """A model with a scenario, and a parameter in which designs side by side differ."""

    name: str
    compiled: CompiledModel
    scenario: Scenario
    varied: str


def _subjects(window: float) -> tuple[Subject, ...]:
    truck = compile_model(elaborate(HybridTruck()))
    chain = compile_model(elaborate(chain_model(57)))
    return (
        Subject("hybrid truck", truck, mission("fmtv_mixed", until=window), "sprung_mass"),
        Subject("chain of 57 sections", chain, Scenario(stop=window, inputs={"left.flow": 0.1}), "last.mass"),
    )


def measure(is_quick: bool) -> Json:
    """Nanoseconds a step and lane, compile times, and how far the answers are apart."""
    lanes = best_lanes(Backend.NATIVE)
    repeats = 3 if is_quick else REPEATS
    cases = [
        _measure(subject, method, lanes, repeats)
        for subject in _subjects(2.0 if is_quick else 20.0)
        for method in METHODS
    ]
    return {"step": STEP, "lanes": lanes, "repeats": repeats, "has_gcc": compiler() is not None, "cases": cases}


def _measure(subject: Subject, method: Method, lanes: int, repeats: int) -> Json:
    window = subject.scenario.stop - subject.scenario.start
    tasks: dict[str, Callable[[], float]] = {}
    answers: dict[str, Callable[[], Memory]] = {}
    compile_s: dict[str, float] = {}
    memories = {1: _memory(subject, 1), lanes: _memory(subject, lanes)}
    for width, memory in memories.items():
        program = subject.compiled.lowered.program
        made: list[NativeMachine] = []
        compile_s[f"{OURS} {width}"] = cpu_seconds(
            lambda p=program, w=width, to=made: to.append(NativeMachine(p, method, w, long_run=0))
        )
        machine = made[0]
        tasks[f"{OURS} {width}"] = lambda m=machine, start=memory: _timed(m, start, subject.scenario.stop)
        answers[f"{OURS} {width}"] = lambda m=machine, start=memory: _run(m, start, subject.scenario.stop)
        for setting in SETTINGS if compiler() else ():
            peer = CMachine(program, method, width, setting.flags)
            name = f"{setting.name} {width}"
            compile_s[name] = peer.compile_s
            tasks[name] = lambda m=peer, start=memory: m.run(start.copy(), subject.scenario.stop, STEP)
            answers[name] = lambda m=peer, start=memory: _run_peer(m, start, subject.scenario.stop)
    times = interleaved(tasks, repeats)
    steps = window / STEP
    per_lane = {name: [t / steps / int(name.split()[-1]) for t in values] for name, values in times.items()}
    reference = per_lane.get(f"{SETTINGS[0].name} 1")
    return {
        "model": subject.name,
        "method": method.value,
        "window": window,
        "seconds_per_step": {name: spread(values).json() for name, values in per_lane.items()},
        "speed": {} if reference is None else {name: ratios(reference, v).json() for name, v in per_lane.items()},
        "compile_s": compile_s,
        "difference": _differences(answers),
    }


def _memory(subject: Subject, lanes: int) -> Memory:
    """The start of designs that differ by up to 5 % in a parameter."""
    parameter = subject.compiled.graph.parameters[parse_path(subject.varied)]
    usual = parameter_values(subject.compiled, {})[parameter.symbol]
    values = usual * np.linspace(0.95, 1.05, lanes) if lanes > 1 else np.array([usual])
    starts = [start_of(subject.compiled, design) for design in designs(subject.scenario, {subject.varied: values})]
    shared = starts[0].memory.tables
    return joined([replace(start.memory, tables=shared) for start in starts], lanes)


def _run(machine: Machine, start: Memory, until: float) -> Memory:
    memory = start.copy()
    machine.run(memory, Request(until=until, step=STEP, most_ticks=10**9))
    return memory


def _timed(machine: Machine, start: Memory, until: float) -> float:
    return cpu_seconds(lambda: _run(machine, start, until))


def _run_peer(machine: CMachine, start: Memory, until: float) -> Memory:
    memory = start.copy()
    machine.run(memory, until, STEP)
    return memory


def _differences(answers: Mapping[str, Callable[[], Memory]]) -> dict[str, float]:
    """The largest difference of a share of the activity from that of the package in as many lanes."""
    found: dict[str, float] = {}
    memories = {name: answer() for name, answer in answers.items()}
    for name, memory in memories.items():
        ours = memories[f"{OURS} {name.split()[-1]}"]
        total = ours.activity.sum(axis=0)
        found[name] = float(np.max(np.abs(memory.activity - ours.activity) / total))
    return found


def write(data: Json, _: Path) -> list[str]:
    """The table."""
    lanes = data["lanes"]
    text = [
        paragraph(
            f"The whole loop of fixed steps of {1e3 * data['step']:g} ms with all integrals of power,",
            "tables and implicit",
            "blocks, without recorded rows. A printer in `benchmarks/` writes the same program as",
            "plain C++, with the same",
            "hoisting of what does not change and the same look-ups; vectors are those of GCC. Its flags are",
            f"`{' '.join(SETTINGS[0].flags)}` and `{' '.join(SETTINGS[1].flags)}`. GCC fuses",
            "multiplications and additions,",
            "which `propermodel` does not: its numbers are the same on every machine. Speed is",
            "against scalar `gcc -O2`,",
            "for each lane, from processor times; designs side by side differ by up to 5 % in a mass.",
        )
    ]
    if not data["has_gcc"]:
        text.append("`g++` is not installed: not measured against GCC.")
    rows = []
    for case in data["cases"]:
        for name, seconds in case["seconds_per_step"].items():
            program, width = name.rsplit(" ", 1)
            speed = shown(case["speed"][name]) if case["speed"] else "-"
            rows.append(
                [
                    f"{case['model']}, {case['method']}",
                    program,
                    width,
                    shown(seconds, 1e9),
                    speed,
                    f"{case['compile_s'][name]:.2f}",
                    f"{case['difference'][name]:.0e}" if program != OURS else "",
                ]
            )
    head = ["model, method", "code", "lanes", "ns a step and lane", "speed", "compile s", "activity differs by"]
    text += table(head, rows, numbers_from=2)
    text.append(
        paragraph(
            f"Median and quartiles of {data['repeats']} interleaved rounds; {lanes} numbers fit into",
            "a vector register.",
            "Compile times are processor seconds for the package, seconds for GCC; the last column is the largest",
            "difference of the activity of a bond, as a share of all activity.",
        )
    )
    return text


PART = Part("a", "Generated code against C", measure, write)
