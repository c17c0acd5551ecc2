"""`python -m benchmarks.truck_search`: searches for smaller trucks beside MORA and backward elimination, on a window.

Three sets of tolerances share the results of their runs where a file is given for them. The smallest models are run
again at half the step and on a second mission: what comes after the window, on a road of other waves. Backward
elimination takes hundreds of runs, so it is done on demand. Linear algebra of many small matrices is quickest in one
thread, above all on a busy machine (`OPENBLAS_NUM_THREADS=1`).
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

import propermodel as pm
from benchmarks.conditions import conditions
from benchmarks.judged_removals import Judge, Tolerances
from benchmarks.measure import Json
from propermodel.library.vehicle import mission as missions
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.model import Scenario, TableValues
from propermodel.reduction.results_file import key_of

FUEL, PRESSURE, SPEED = "engine.fuel_meter.mass", "hydraulics.accumulator_pressure", "chassis.speed"
TOLERANCES: Mapping[str, Tolerances] = {
    "wide": {FUEL: 0.01, PRESSURE: 0.05, SPEED: 0.02},
    "middle": {FUEL: 0.005, PRESSURE: 0.02, SPEED: 0.01},
    "tight": {FUEL: 0.002, PRESSURE: 0.02, SPEED: 0.01},
}
OUTPUTS = (FUEL, PRESSURE, SPEED)
STEP = 2e-4


def main() -> None:
    """Measure, print, and write JSON after every step."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--window", type=float, default=200.0, help="simulated seconds (default: 200)")
    options.add_argument("--sets", nargs="+", choices=list(TOLERANCES), default=list(TOLERANCES))
    options.add_argument("--both", action="store_true", help="let the second mission take part in the search")
    options.add_argument("--backward", action="store_true", help="also backward elimination by measured error")
    options.add_argument("--results", type=FilePath, help="keep runs of candidates in this file, and use what it holds")
    options.add_argument("--out", type=FilePath, default=FilePath("out/truck_search.json"))
    given = options.parse_args()
    first = missions.mission("fmtv_mixed", until=given.window)
    second = second_mission(first)
    model = pm.elaborate(HybridTruck())
    report = _Report(given.out, {"window_s": given.window, "with_both": given.both, "conditions": conditions()})
    found = {
        name: _searched(model, (first, second) if given.both else (first,), name, given.results, report)
        for name in given.sets
    }
    judge = Judge(model, first, STEP, OUTPUTS)
    half = Judge(model, first, STEP / 2.0, OUTPUTS)
    elsewhere = Judge(model, second, STEP, OUTPUTS)
    for name, search in found.items():
        for kind, candidate in (("smallest", search.best), ("recommended", search.recommended)):
            if candidate is not None:
                scores = {
                    "at_half_the_step": half.score(candidate.removals, TOLERANCES[name]),
                    "on_the_second_mission": elsewhere.score(candidate.removals, TOLERANCES[name]),
                }
                report.add(name, {f"{kind}_{key}": value for key, value in scores.items()})
    for name in found:
        report.add(name, {"mora_rows": judge.smallest_by_activity(TOLERANCES[name])})
    for name in found if given.backward else ():
        before, begin = judge.simulations, time.perf_counter()
        rows = judge.backward(TOLERANCES[name])
        runs, wall_s = judge.simulations - before, time.perf_counter() - begin
        report.add(name, {"backward_rows": rows, "backward_simulations": runs, "backward_s": wall_s})


def _searched(
    model: pm.Model, scenarios: tuple[Scenario, ...], name: str, results: FilePath | None, report: _Report
) -> pm.ProperModelSearch:
    begin, work = time.perf_counter(), time.process_time()
    found = pm.find_proper_model(model, scenarios, TOLERANCES[name], step=STEP, results=results)
    report.add(
        name,
        {
            "simulations": found.simulations,
            "models_tried": len(found.candidates),
            "wall_s": time.perf_counter() - begin,
            "processor_s": time.process_time() - work,
        },
    )
    for kind, candidate in (("smallest", found.best), ("recommended", found.recommended)):
        if candidate is not None:
            report.add(
                name,
                {
                    f"{kind}_rows": found.rows - len(candidate.rows),
                    f"{kind}_states": candidate.states,
                    f"{kind}_error_over_tolerance": candidate.score,
                    f"{kind}_removals": key_of(candidate.removals),
                },
            )
    return found


class _Report:
    """What has been measured so far, told and written at once."""

    def __init__(self, file: FilePath, head: Mapping[str, Json]) -> None:
        self._file = file
        self._data: dict[str, Json] = {**head, "sets": {}}

    def add(self, name: str, measured: Mapping[str, Json]) -> None:
        """Add what was measured with one set of tolerances."""
        self._data["sets"].setdefault(name, {}).update(measured)
        print(name, json.dumps(measured), flush=True)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        self._file.write_text(json.dumps(self._data, indent=2) + "\n", encoding="utf-8")


def second_mission(first: Scenario) -> Scenario:
    """As long as the first, from the next standstill on, on a road with other random phases."""
    record = missions.read_record("fmtv_mixed")
    later = int(np.flatnonzero((record.time >= first.stop) & (record.speed == 0.0))[0])
    road = replace(missions.rough_road(record, None), seed=1)
    whole = missions.mission("fmtv_mixed")
    tables = {
        path: _moved(values, float(record.time[later] if path == missions.SPEED_PROFILE else record.distance[later]))
        for path, values in {
            **whole.tables,
            missions.ROUGHNESS: missions.roughness_table(road, float(record.distance[-1])),
        }.items()
    }
    return replace(first, name="second mission", tables=tables)


def _moved(values: TableValues, by: float) -> TableValues:
    return replace(values, grids=(tuple(place - by for place in values.grids[0]), *values.grids[1:]))


if __name__ == "__main__":
    main()
