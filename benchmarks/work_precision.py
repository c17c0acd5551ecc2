"""Part b: what a mission of the truck costs for an error, against solvers of others on the same equations."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path as FilePath
from time import process_time

import numpy as np

from benchmarks.alone import Alone
from benchmarks.hybrid import Hybrid, Outcome, scales
from benchmarks.measure import Json, interleaved, spread
from benchmarks.part import Part, paragraph, rounded, shown, table
from benchmarks.solver_peers import NO_CODE, fixed_step_peers, peers
from propermodel.codegen.machine import QUADRATURE, FloatArray, Memory, Method
from propermodel.compiler import CompiledModel, compile_model
from propermodel.diagnostics import Path, parse_path
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate

FUEL = parse_path("engine.fuel_meter.mass")
OURS: Mapping[tuple[Method, int], tuple[float, ...]] = {
    (Method.SEMI_IMPLICIT, 1): (4e-4, 2e-4, 1e-4, 5e-5),
    (Method.RK4, 1): (4e-4, 2e-4),
    (Method.ROS2, 1): (1e-2, 5e-3, 2e-3, 1e-3, 5e-4),
    (Method.ROS2, 2): (5e-3,),
    (Method.ROS2, 4): (2e-3, 1e-3, 5e-4),
    (Method.RODAS, 1): (1e-2, 1e-3, 1e-4, 1e-5, 1e-6),
    (Method.DOPRI5, 1): (1e-3, 1e-5),
}
STAGES = 6  # of the methods that choose their steps
PEER_STEPS = (2e-4, 1e-4)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
REFERENCE_STEP = 2.5e-5
REPEATS = 3


@dataclass(frozen=True)
class Answer:
    """Fuel in kg, and activities of all rows, J."""

    fuel: float
    activities: Mapping[Path, float]

    @property
    def total(self) -> float:
        """The activity of all rows."""
        return sum(self.activities.values())


@dataclass(frozen=True)
class Setting:
    """A way to run the mission."""

    name: str
    setting: str
    run: Callable[[], Outcome]


def measure(is_quick: bool) -> Json:
    """Processor time, evaluations and errors of every solver and setting."""
    truck = compile_model(elaborate(HybridTruck()))
    scenario = mission("fmtv_mixed", until=5.0 if is_quick else 20.0)
    hybrid = Hybrid(truck, scenario)
    scale = _scale(truck, scenario, hybrid)
    exact = _answer(truck, Alone(truck, scenario, Method.ROS2).run(REFERENCE_STEP))
    settings, missing = _settings(truck, scenario, hybrid, scale)
    rows: list[Json] = []
    tasks: dict[str, Callable[[], float]] = {}
    for setting in settings:
        try:
            outcome = setting.run()
        except ArithmeticError as error:
            rows.append({"name": setting.name, "setting": setting.setting, "failed": str(error)})
            continue
        found = _answer(truck, outcome.memory)
        if not math.isfinite(found.total):
            rows.append({"name": setting.name, "setting": setting.setting, "failed": "no finite answer"})
            continue
        tasks[str(len(rows))] = lambda run=setting.run: _timed(run)
        rows.append(
            {
                "name": setting.name,
                "setting": setting.setting,
                "steps": outcome.steps,
                "evaluations": outcome.evaluations,
                "fuel": abs(found.fuel / exact.fuel - 1.0),
                "total": abs(found.total / exact.total - 1.0),
                "index": _largest_change(found, exact),
            }
        )
    for number, times in interleaved(tasks, 1 if is_quick else REPEATS).items():
        rows[int(number)]["seconds"] = spread(times).json()
    return {"window": scenario.stop, "rows": rows, "missing": missing, "reference": REFERENCE_STEP}


def _timed(run: Callable[[], object]) -> float:
    begin = process_time()
    run()
    return process_time() - begin


def _settings(
    truck: CompiledModel, scenario: Scenario, hybrid: Hybrid, scale: FloatArray
) -> tuple[list[Setting], dict[str, str]]:
    found: list[Setting] = []
    alone = {method: Alone(truck, scenario, method) for method, _ in OURS}
    for (method, every), values in OURS.items():
        name = f"propermodel {method}" + (f", LU kept {every} steps" if every > 1 else "")
        for value in values:
            text = f"{value:.0e}" if method.is_adaptive else f"{1e3 * value:g} ms"
            found.append(Setting(name, text, _ours(alone[method], method, value, every)))
    missing = dict(NO_CODE)
    adaptive = [(name, run, TOLERANCES) for name, run in peers(hybrid, scale).items()]
    fixed = [(name, run, PEER_STEPS) for name, run in fixed_step_peers(truck, scenario).items()]
    for name, run, values in (*fixed, *adaptive):
        if isinstance(run, str):
            missing[name] = run
            continue
        for value in values:
            text = f"{1e3 * value:g} ms" if values is PEER_STEPS else f"{value:.0e}"
            found.append(Setting(name, text, partial(run, value)))
    return found, missing


def _ours(alone: Alone, method: Method, value: float, jacobian_every: int = 1) -> Callable[[], Outcome]:
    stages = STAGES if method.is_adaptive else len(QUADRATURE[method])

    def run() -> Outcome:
        memory = alone.run(value, jacobian_every)
        return Outcome(memory, memory.steps_taken, (memory.steps_taken + memory.steps_rejected) * stages)

    return run


def _scale(truck: CompiledModel, scenario: Scenario, hybrid: Hybrid) -> FloatArray:
    """Greatest magnitudes of states, in the order in which peers have them."""
    paths = [state.path for state in truck.system.states]
    run = simulate(truck, scenario, method=Method.ROS2, step=2e-3, record=paths, record_every=0.02)
    found = np.empty(len(paths))
    found[hybrid.printer.states] = scales(np.column_stack([run[path] for path in paths]))
    return found


def _answer(truck: CompiledModel, memory: Memory) -> Answer:
    signals = truck.machine(Method.SEMI_IMPLICIT).observe(memory)
    places = truck.lowered.power_places
    activities = {
        row.path: float(memory.activity[places[row.path if len(row.bonds) > 1 else next(iter(row.bonds))]])
        for row in truck.system.rows
    }
    return Answer(float(signals[truck.lowered.observables[FUEL].index]), activities)


def _largest_change(found: Answer, exact: Answer) -> float:
    """The largest error of an activity index, in points."""
    return max(
        abs(100.0 * (found.activities[path] / found.total - value / exact.total))
        for path, value in exact.activities.items()
    )


def write(data: Json, pictures: FilePath) -> list[str]:
    """The table and the diagram."""
    rows = []
    for row in data["rows"]:
        if "failed" in row:
            rows.append([row["name"], row["setting"], "-", "-", "-", "-", "-", row["failed"]])
            continue
        rows.append(
            [
                row["name"],
                row["setting"],
                shown(row["seconds"]),
                str(row["steps"]),
                str(row["evaluations"]),
                rounded(100.0 * row["fuel"], 2),
                rounded(100.0 * row["total"], 2),
                rounded(row["index"], 2),
            ]
        )
    rows += [[name, "-", "-", "-", "-", "-", "-", f"not measured: {why}"] for name, why in data["missing"].items()]
    _draw(data["rows"], pictures / "performance_work_precision.png")
    head = ["solver", "step or tolerance", "s", "steps", "evaluations", "fuel %", "activity %", "index, points"]
    return [
        paragraph(
            f"The first {data['window']:g} s of the truck's mission, processor seconds of the run",
            "alone. Controllers are",
            "sampled every 10 ms, and there every solver begins anew. Peers have the right-hand side",
            "and the exact Jacobian",
            "of the same model, printed as C and compiled by `gcc -O2`; their tolerance is relative,",
            "and absolute against the",
            "greatest magnitude of each state. Their activities are trapezoids over their own steps,",
            "`propermodel` has its",
            f"own. Errors are against ROS2 in steps of {1e3 * data['reference']:g} ms: of fuel, of",
            "the total activity, and the",
            "largest of an activity index. Evaluations are those of the right-hand side that a solver asks for.",
        ),
        *table(head, rows, numbers_from=2),
        "![Errors against time and evaluations](images/performance_work_precision.png)",
    ]


def _draw(rows: Sequence[Json], file: FilePath) -> None:
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    colours = colormaps["tab20"].colors[::2] + colormaps["tab20b"].colors[::4]  # no two lines share one
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    axes = figure.subplots(2, 2, sharey="row", sharex="col")
    names = list(dict.fromkeys(row["name"] for row in rows if "failed" not in row))
    for name, colour in zip(names, itertools.cycle(colours), strict=False):
        good = [row for row in rows if row["name"] == name and "failed" not in row]
        is_ours = name.startswith("propermodel")
        style = {
            "marker": "o" if is_ours else "s",
            "linestyle": "-" if is_ours else "--",
            "color": colour,
            "label": name,
            "markersize": 4,
        }
        for column, cost in enumerate((lambda row: row["seconds"]["median"], lambda row: row["evaluations"])):
            for line, error in enumerate(("fuel", "index")):
                points = sorted((cost(row), max(row[error], 1e-12)) for row in good)
                axes[line][column].loglog(*zip(*points, strict=True), **style)
    axes[0][0].set(ylabel="error in fuel, a share")
    axes[1][0].set(ylabel="largest error of an index, points", xlabel="processor time, s")
    axes[1][1].set(xlabel="evaluations of the right-hand side")
    for each in axes.flat:
        each.grid(alpha=0.3)
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    figure.savefig(file, dpi=120)


PART = Part("b", "One mission: work and precision", measure, write)
