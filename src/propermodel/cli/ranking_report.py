"""Rankings for other programs: as JSON and as CSV."""

from __future__ import annotations

import csv
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from propermodel.analysis.ranking import ActivityRanking, ActivityRow, RankedPart
    from propermodel.reduction.prediction import Prediction


def ranking_report(ranking: ActivityRanking) -> dict[str, object]:
    """A ranking as plain data."""
    check = ranking.discretisation
    return {
        "scenario": ranking.scenario,
        "window_s": list(ranking.window),
        "total_activity_J": ranking.total,
        "datums": list(ranking.datums),
        "discretisation_check": None if check is None else check.comparison,
        "discretisation_check_points": None if check is None else check.largest_change_points,
        "elements": [_element(row, ranking.parts) for row in ranking.rows],
        "components": [
            {"path": str(c.path), "activity_J": c.activity, "index": c.index, "rows": c.rows}
            for c in ranking.components()
        ],
        "parts": [
            {
                "name": part.name,
                "scenario": part.scenario,
                "window_s": list(part.window),
                "total_activity_J": part.total,
                "is_idle": part.is_idle,
            }
            for part in ranking.parts
        ],
        "notes": list(ranking.notes),
    }


def _element(row: ActivityRow, parts: tuple[RankedPart, ...]) -> dict[str, object]:
    return {
        "path": str(row.path),
        "kind": row.kind,
        "activity_J": row.activity,
        "index": row.index,
        "cumulative": row.cumulative,
        "change_points": row.change_points,
        "largest_index": row.largest_index,
        "largest_in": row.largest_in or None,
        "ports_J": {str(port): activity for port, activity in row.ports},
        "sum_over_ports_J": row.sum_over_ports,
        "parts": [
            {"index": part.index(row.path), "change_points": part.changes.get(row.path), "name": part.name}
            for part in parts
        ],
    }


def write_ranking_csv(ranking: ActivityRanking) -> None:
    """Print a ranking as CSV: a line for each row, with its index in every part."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    head = ["rank", "path", "kind", "activity_J", "index", "cumulative", "change_points", "largest_index", "largest_in"]
    writer.writerow([*head, *(f"index in {part.name}" for part in ranking.parts)])
    for number, row in enumerate(ranking.rows, 1):
        change = "" if row.change_points is None else row.change_points
        cells = [number, row.path, row.kind, row.activity, row.index, row.cumulative, change]
        cells += [row.largest_index, row.largest_in, *(part.index(row.path) for part in ranking.parts)]
        writer.writerow(cells)


def prediction_report(prediction: Prediction) -> list[dict[str, object]]:
    """Predicted errors as plain data."""
    from propermodel.report.summary import removal_text

    return [
        {
            "path": str(row.row),
            "ways": [
                {
                    "removals": [removal_text(removal) for removal in way.removals],
                    "rms_over_range": {str(path): error for path, error in way.errors.items()},
                }
                for way in row.ways
            ],
        }
        for row in prediction.rows()
    ]
