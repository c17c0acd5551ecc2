"""`python -m benchmarks.truck_search`: searches for smaller trucks beside MORA and backward elimination, on a window.

Three sets of tolerances share the results of their runs. The smallest models are run again at half the step and on a
second mission: what comes after the window, on a road of other waves. Backward elimination measures every row that is
left, each time anew, which takes an hour and more; it is done on demand.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory

import numpy as np

import propermodel as pm
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, parse_path
from propermodel.library.vehicle import mission as missions
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.model import Removal, Scenario, TableValues
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.freezing import signals_to_freeze
from propermodel.reduction.prediction import Replacement
from propermodel.simulation.trajectory import Trajectory

FUEL, PRESSURE, SPEED = "engine.fuel_meter.mass", "hydraulics.accumulator_pressure", "chassis.speed"
TOLERANCES: Mapping[str, Mapping[str, float]] = {
    "tight": {FUEL: 0.002, PRESSURE: 0.02, SPEED: 0.01},
    "middle": {FUEL: 0.005, PRESSURE: 0.02, SPEED: 0.01},
    "wide": {FUEL: 0.01, PRESSURE: 0.05, SPEED: 0.02},
}
THRESHOLDS = (0.95, 0.97, 0.98, 0.99, 0.995, 0.998, 0.999, 0.9995, 0.9999)
STEP = 2e-4


def main() -> None:
    """Measure, print, and write JSON."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--window", type=float, default=200.0, help="simulated seconds (default: 200)")
    options.add_argument("--backward", action="store_true", help="also backward elimination by measured error")
    options.add_argument("--out", type=FilePath, default=FilePath("out/truck_search.json"))
    given = options.parse_args()
    scenario = missions.mission("fmtv_mixed", until=given.window)
    model = pm.elaborate(HybridTruck())
    judge = Judge(model, scenario, STEP)
    second = Judge(model, second_mission(scenario), STEP)
    half = Judge(model, scenario, STEP / 2.0)
    report: dict[str, object] = {"window_s": given.window, "cores": os.cpu_count()}
    with TemporaryDirectory() as folder:
        for name, tolerances in TOLERANCES.items():
            begin, work = time.perf_counter(), time.process_time()
            found = pm.find_proper_model(
                model, scenario, tolerances, step=STEP, results=FilePath(folder) / "results.jsonl"
            )
            best = found.best
            removals = () if best is None else best.removals
            measured: dict[str, object] = {
                "rows": found.rows - (0 if best is None else len(best.rows)),
                "states": found.states if best is None else best.states,
                "error_over_tolerance": None if best is None else best.score,
                "simulations": found.simulations,
                "models_tried": len(found.candidates),
                "wall_s": time.perf_counter() - begin,
                "processor_s": time.process_time() - work,
                "at_half_the_step": half.score(removals, tolerances),
                "on_the_second_mission": second.score(removals, tolerances),
                "mora_rows": judge.smallest_by_activity(tolerances),
            }
            if given.backward:
                measured["backward_rows"], measured["backward_simulations"] = judge.backward(tolerances)
            report[name] = measured
            print(name, json.dumps(measured, indent=2), flush=True)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


class Judge:
    """The full model on one scenario, and what becomes of its outputs without some elements."""

    def __init__(self, model: pm.Model, scenario: Scenario, step: float) -> None:
        self.full = compile_quietly(model)
        self.scenario = scenario
        self.step = step
        self.run: Trajectory = pm.simulate(
            self.full, scenario, step=step, record_every=scenario.stop / 2000.0, integrals_every=scenario.stop
        )

    def score(self, removals: tuple[Removal, ...], tolerances: Mapping[str, float]) -> float | None:
        """The largest error over its tolerance; None where no model is left, or its run fails."""
        try:
            return self._score_of(compile_quietly(self.full.model.without(removals)), tolerances)
        except ProperModelError:
            return None

    def _score_of(self, reduced: CompiledModel, tolerances: Mapping[str, float]) -> float | None:
        if any(parse_path(path) not in reduced.lowered.observables for path in tolerances):
            return None
        run = pm.simulate(
            reduced,
            self.scenario,
            step=self.step,
            record=list(tolerances),
            record_every=self.scenario.stop / 2000.0,
            integrals_every=self.scenario.stop,
        )
        if not run.ending.is_complete:
            return None
        return max(error.rms / tolerances[str(error.path)] for error in pm.compare(self.run, run, tolerances).outputs)

    def smallest_by_activity(self, tolerances: Mapping[str, float]) -> int:
        """The rows of the smallest model within the tolerances that thresholds of activity give."""
        ranking = pm.rank_activity(self.run)
        smallest = len(self.full.system.rows)
        for threshold in THRESHOLDS:
            plan = pm.plan_reduction(self.full, self.run, ranking, threshold=threshold, protected=tolerances)
            score = self.score(plan.removals, tolerances)
            if score is not None and score <= 1.0:
                smallest = min(smallest, len(compile_quietly(self.full.model.without(plan.removals)).system.rows))
        return smallest

    def backward(self, tolerances: Mapping[str, float]) -> tuple[int, int]:
        """Rows left, and simulations, where the row whose removal costs least by simulation goes, again and again.

        Each row by the replacement that is predicted to cost least alone.
        """
        evidence = RunEvidence.of(self.full, self.run)
        prediction = pm.predict_errors(self.run, tolerances)
        ways = {row.row: row.best.removals for row in prediction.rows() if row.best is not None}
        gone: dict[Path, tuple[Replacement, ...]] = {}
        simulations = 0
        while True:
            scores: dict[Path, float] = {}
            for row, way in ways.items():
                if row not in gone:
                    chosen = tuple(removal for each in (*gone.values(), way) for removal in each)
                    simulations += 1
                    try:
                        frozen = signals_to_freeze(evidence, chosen)
                    except ProperModelError:
                        continue
                    score = self.score((*chosen, *frozen), tolerances)
                    if score is not None and score <= 1.0:
                        scores[row] = score
            if not scores:
                return len(self.full.system.rows) - len(gone), simulations
            row = min(scores, key=lambda path: scores[path])
            gone[row] = ways[row]


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
