"""The numbers of a study as plain data: `summary.json`, the ranking and the outputs as CSV."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.analysis.comparison import OutputError
from propermodel.codegen.versions import versions
from propermodel.modelling.removal_words import removal_text
from propermodel.reduction.merges import MergedElement
from propermodel.reduction.plan import Decision, Reduction
from propermodel.report.plain import finite
from propermodel.report.speed import BestSteps, Speed, Timing
from propermodel.report.study import ReductionStudy
from propermodel.simulation.trajectory import Trajectory

FORMAT = "propermodel-summary"
VERSION = 1

Json = Any


def summarise(study: ReductionStudy) -> dict[str, Json]:
    """The summary of a study as plain data."""
    reduction, ranking = study.reduction, study.ranking
    full, reduced = study.full, study.reduced
    check = ranking.discretisation
    totals, best = _totals(study), study.best_steps
    summary: dict[str, Json] = {
        "format": FORMAT,
        "version": VERSION,
        "model": full.compiled.model.name,
        "scenario": full.scenario.name,
        "window_s": [full.scenario.start, full.scenario.stop],
        "method": full.method.value,
        "step_s": full.step,
        "jacobian_every": full.jacobian_every,
        "step_tolerance": full.tolerance if full.method.is_adaptive else None,
        "energy_elements": len(ranking.rows),
        "threshold": reduction.threshold,
        "tolerance": reduction.tolerance,
        "kept_by_threshold": reduction.kept_by_threshold,
        "kept": len(reduction.kept),
        "removed": len(reduction.removed),
        "kept_activity": reduction.kept_activity,
        "total_activity_J": ranking.total,
        "datums": list(ranking.datums),
        "states": {"full": len(full.compiled.system.states), "reduced": len(reduced.compiled.system.states)},
        "elements": [_element(decision) for decision in reduction.decisions],
        "removals": [removal_text(removal) for removal in reduction.removals],
        "merges": [_merge(merge) for merge in reduction.merges],
        "protected_outputs": [str(path) for path in reduction.protected],
        "totals": totals,
        "output_errors": {str(error.path): _output_error(error) for error in study.comparison.outputs},
        "energy_balance_residual": {
            "full": study.full_balance.relative_residual,
            "reduced": study.reduced_balance.relative_residual,
        },
        "discretisation_check_points": None if check is None else check.largest_change_points,
        "outside_tables_s": {str(use.path): use.seconds for use in full.outside_tables},
        "wall_s": {
            "full": _wall(full),
            "reduced": _wall(reduced),
        },
        "speedup": None if study.speed is None else study.speed.ratio,
        "speedup_best_steps": None if best is None or best.speed is None else best.speed.ratio,
        "speed": None if study.speed is None else _speed(study.speed),
        "speed_best_steps": None if best is None else _best_steps(best),
        "versions": versions(),
    }
    if "fuel_kg" in totals:
        summary["fuel_kg"] = {key: totals["fuel_kg"][key] for key in ("full", "reduced", "error_percent")}
    return finite(summary)


def write_summary(study: ReductionStudy, file: FilePath) -> dict[str, Json]:
    """Write `summary.json` and give its content."""
    summary = summarise(study)
    file.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return summary


def write_ranking(reduction: Reduction, file: FilePath) -> None:
    """Write the ranking with its decisions as CSV."""
    names = ["rank", "path", "kind", "activity_J", "index", "cumulative", "decision", "removal", "reason"]
    elements = (_element(decision) for decision in reduction.decisions)
    _write_csv(file, names, ([n, *(e[name] for name in names[1:])] for n, e in enumerate(elements, 1)))


def write_outputs(study: ReductionStudy, file: FilePath) -> None:
    """Write the compared outputs of both runs over time as CSV, in SI."""
    full, reduced = study.full, study.reduced
    names, columns = ["time_s"], [full.time]
    for path in study.compared:
        names += [f"{path} [{full.unit(path)}] full", f"{path} [{full.unit(path)}] reduced"]
        columns += [full[path], np.interp(full.time, reduced.time, reduced[path])]
    _write_csv(file, names, np.column_stack(columns).tolist())


def _write_csv(file: FilePath, names: list[str], rows: Iterable[Iterable[object]]) -> None:
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([f"{v:.9g}" if isinstance(v, float) else v for v in row] for row in rows)


def _element(decision: Decision) -> dict[str, Json]:
    row = decision.row
    return {
        "path": str(row.path),
        "kind": row.kind,
        "activity_J": row.activity,
        "index": row.index,
        "cumulative": row.cumulative,
        "decision": decision.verdict.value,
        "removal": decision.meaning,
        "reason": decision.reason,
        "cause": None if decision.cause is None else decision.cause.value,
        "replacements": [
            {
                "bond": str(way.removal.bond),
                "meaning": way.meaning,
                "missing": way.missing,
                "size": way.size,
                "junction": None if way.junction is None else str(way.junction),
            }
            for way in decision.ways
        ],
        "regular_twins": [str(twin) for twin in decision.twins],
    }


def _merge(merge: MergedElement) -> dict[str, Json]:
    return {
        "into": str(merge.into),
        "bonds": [str(removal.bond) for removal in merge.removals],
        "kind": merge.kind,
        "formula": merge.formula,
        "value": merge.value,
        "dependent_storage": merge.dependent,
    }


def _totals(study: ReductionStudy) -> dict[str, Json]:
    found: dict[str, Json] = {}
    for name, path in study.options.totals.items():
        full = study.full.at_end(path) - study.full.at_start(path)
        reduced = study.reduced.at_end(path) - study.reduced.at_start(path)
        error = (reduced / full - 1.0) * 100.0 if full else None
        unit = study.full.unit(path)
        found[name] = {"path": str(path), "unit": unit, "full": full, "reduced": reduced, "error_percent": error}
    return found


def _output_error(error: OutputError) -> dict[str, Json]:
    return {
        "unit": error.unit,
        "range": error.reference_range,
        "rms": error.rms,
        "mean": error.mean,
        "maximum": error.largest,
        "maximum_at_s": error.at,
        "final_full": error.reference.final,
        "final_reduced": error.other.final,
        "final": error.final_error,
    }


def _wall(run: Trajectory) -> dict[str, Json]:
    compile_s = run.compiled.compile_s + run.statistics.build_s
    return {"compile": compile_s, "run": run.statistics.wall_s, "steps": run.statistics.steps}


def _timing(timing: Timing) -> dict[str, Json]:
    return {"step_s": timing.step, "steps": timing.steps, "median_s": timing.median, "runs_s": list(timing.runs)}


def _speed(speed: Speed) -> dict[str, Json]:
    return {
        "window_s": list(speed.window),
        "full": _timing(speed.full),
        "reduced": _timing(speed.reduced),
    }


def _best_steps(best: BestSteps) -> dict[str, Json]:
    return {
        "window_s": list(best.window),
        "full_step_s": best.full_step,
        "reduced_step_s": best.reduced_step,
        "full": None if best.speed is None else _timing(best.speed.full),
        "reduced": None if best.speed is None else _timing(best.speed.reduced),
    }
