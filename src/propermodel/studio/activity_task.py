"""What one recorded run says of its elements, and what two say of each other; made in a worker."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.analysis.activity import bond_activities, rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.analysis.comparison import OutputError, compare_columns
from propermodel.diagnostics import Path, SimulationError, parse_path
from propermodel.drawing.depict import depict
from propermodel.report.page_data import output_data
from propermodel.report.run_data import USUAL_THRESHOLD, balance_data, ranking_data, windows_data
from propermodel.simulation.reopening import reopened
from propermodel.simulation.storage import load_trajectory
from propermodel.simulation.trajectory import Trajectory
from propermodel.studio.run_task import main_signals
from propermodel.studio.worker import Control

Json = Any


def activity(arguments: Json, _: Control) -> Json:
    """The activity of a run, until where it was recorded.

    Raises:
        ProperModelError: the file cannot be read, or nothing in it can be ranked.
    """
    stored = load_trajectory(arguments["file"])
    run = reopened(stored)
    ranking = rank_activity(run)
    balance = energy_balance(run)
    system = run.compiled.system
    notes = [*ranking.notes, *run.notes, *(f"datum of {datum}" for datum in ranking.datums)]
    if not stored.ending.is_complete:
        notes.insert(0, f"{stored.ending.message}; ranked until {run.scenario.stop:.6g} s")
    facts = [
        ("energy elements", str(len(ranking.rows)), "that store or dissipate"),
        ("states", str(len(system.states)), "of the equations"),
        ("steps", str(run.statistics.steps), run.method.value),
        ("energy unaccounted", f"{balance.relative_residual:.0e}", "of the work of sources"),
    ]
    sheet = {
        "model": run.compiled.model.name,
        "scenario": run.scenario.name,
        "window": list(ranking.window),
        "threshold": USUAL_THRESHOLD,
        "facts": [{"name": name, "value": value, "note": note} for name, value, note in facts],
        "picture": depict(run.compiled, ranking, bond_activities(run)).document(),
        "rows": ranking_data(ranking, {}),
        "totalActivity": ranking.total,
        "notes": notes,
        "balances": {"full": balance_data(balance)},
        "windows": windows_data(run),
        "bonds": {str(row.path): [str(bond) for bond in row.bonds] for row in system.rows},
    }
    return {"sheet": sheet, "files": []}


def compare(arguments: Json, _: Control) -> Json:
    """Two runs side by side, where both are: the second against the first.

    Raises:
        ProperModelError: a file cannot be read, or the runs have nothing in common.
    """
    a, b = (reopened(load_trajectory(FilePath(arguments[name]))) for name in ("a", "b"))
    begin = max(float(a.time[0]), float(b.time[0]))
    end = min(float(a.time[-1]), float(b.time[-1]))
    if not end > begin:
        raise SimulationError.of(
            "studio/nothing-common",
            f"the runs have no time in common: one ends at {end:g} s, the other begins at {begin:g} s",
            help="compare runs of one scenario",
        )
    wanted = [parse_path(text) for text in arguments["outputs"]] or [*main_signals(a.compiled)]
    outputs = [path for path in dict.fromkeys(wanted) if path in a and path in b]
    balances = energy_balance(a), energy_balance(b)
    facts = [
        ("energy elements", _pair(len(run.compiled.system.rows) for run in (a, b)), "that store or dissipate"),
        ("states", _pair(len(run.compiled.system.states) for run in (a, b)), "of the equations"),
        ("steps", _pair(run.statistics.steps for run in (a, b)), ", ".join({run.method.value for run in (a, b)})),
        ("wall time", _pair(f"{run.statistics.wall_s:.2f} s" for run in (a, b)), "of single runs, on a shared machine"),
        ("energy unaccounted", _pair(f"{balance.relative_residual:.0e}" for balance in balances), "of source work"),
    ]
    if (begin, end) != (float(a.time[0]), float(a.time[-1])):
        facts.append(("compared", f"{begin:g} to {end:g} s", "where both runs are"))
    sheet = {
        "outputs": [output_data(_difference(a, b, path, begin, end)) for path in outputs],
        "balances": {"full": balance_data(balances[0]), "reduced": balance_data(balances[1])},
        "facts": [{"name": name, "value": value, "note": note} for name, value, note in facts],
        "pictures": {name: depict(run.compiled).document() for name, run in (("a", a), ("b", b))},
    }
    return {"sheet": sheet, "files": []}


def _pair(values: Any) -> str:
    """Two numbers, or one that is the same of both."""
    texts = [str(value) for value in values]
    return texts[0] if texts[0] == texts[1] else " → ".join(texts)


def _difference(a: Trajectory, b: Trajectory, path: Path, begin: float, end: float) -> OutputError:
    inside = (a.time >= begin) & (a.time <= end)
    time = a.time[inside]
    return compare_columns(path, a.unit(path), time, a[path][inside], np.interp(time, b.time, b[path]))
