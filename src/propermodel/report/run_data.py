"""What pages show of one run, as plain data: its ranking, energy balance, windows and the histories of its rows."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from propermodel.analysis.balance import EnergyBalance
from propermodel.analysis.ranking import ActivityRanking
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path
from propermodel.report.buckets import Intervals, exactly_packed, packed
from propermodel.simulation.trajectory import Trajectory

USUAL_THRESHOLD = 0.99  # where none was used
WINDOWS = 220  # instants between which activities can be ranked anew

Json = Any


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a row: kept, removed or refused; what stands in its place; and why."""

    verdict: str
    meaning: str
    reason: str


KEPT = Fate("kept", "", "")


class Columns(Protocol):
    """Recorded columns over time."""

    def __getitem__(self, observable: Path, /) -> FloatArray: ...

    def unit(self, observable: Path, /) -> str: ...


def ranking_data(ranking: ActivityRanking, fates: Mapping[Path, Fate]) -> Json:
    """The rows of a ranking in order, each with what became of it; one of which nothing is said is kept."""
    rows: list[Json] = []
    for row in ranking.rows:
        fate = fates.get(row.path, KEPT)
        rows.append(
            {
                "path": str(row.path),
                "kind": row.kind,
                "activity": row.activity,
                "index": row.index,
                "cumulative": row.cumulative,
                "verdict": fate.verdict,
                "meaning": fate.meaning,
                "reason": fate.reason,
            }
        )
    return rows


def balance_data(balance: EnergyBalance) -> Json:
    """Where energy came from and went, J."""
    return {
        "supplied": balance.supplied,
        "stored": balance.stored,
        "dissipated": balance.dissipated,
        "residual": balance.relative_residual,
        "sources": [{"path": str(path), "work": work} for path, work in balance.sources],
    }


def windows_data(run: Trajectory) -> Json:
    """The activity of every row since the start, at some instants at which it was kept, J."""
    count = len(run.integral_times)
    places = np.unique(np.linspace(0, count - 1, min(count, WINDOWS + 1)).round().astype(int))
    return {
        "times": exactly_packed(run.integral_times[places]),
        "rows": {
            str(row.path): exactly_packed(run.kept_activity(_entry(row.path, row.bonds))[places])
            for row in run.compiled.system.rows
        },
    }


def _entry(row: Path, bonds: Collection[Path]) -> Path:
    """Under which path the power of a row is integrated: a group and a field have an integral of their own."""
    return row if len(bonds) > 1 else next(iter(bonds))


def instants(start: float, stop: float, intervals: int) -> tuple[FloatArray, FloatArray]:
    """Edges between intervals, and the instants of what is drawn: edge and middle of each interval in turn."""
    edges = np.linspace(start, stop, intervals + 1)
    return edges, np.column_stack([edges[:-1], 0.5 * (edges[:-1] + edges[1:])]).ravel()


def history_data(run: Columns, bonds: Collection[Path], intervals: Intervals) -> list[Json]:
    """Effort, flow and power at some bonds, in intervals of the run's time."""
    found: list[Json] = []
    for bond in bonds:
        effort, flow = run[bond / "effort"], run[bond / "flow"]
        found.append(
            {
                "bond": str(bond),
                "units": [run.unit(bond / "effort"), run.unit(bond / "flow")],
                "effort": packed(intervals.extremes(effort)),
                "flow": packed(intervals.extremes(flow)),
                "power": packed(intervals.extremes(effort * flow)),
            }
        )
    return found
