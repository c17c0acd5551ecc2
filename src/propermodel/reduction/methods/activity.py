"""MORA: remove what is least active (Louca, Stein, Hulbert, Sprague 1997).

Elements are sorted by activity; those that make up a threshold of the whole are kept, and the bonds of all others are
deleted by the rule of their junction: no effort at a 1-junction, no flow at a 0-junction. No test asks whether that is
small there, and nothing is simulated on the way; the errors are measured afterwards, for every size.
"""

from __future__ import annotations

from propermodel.analysis.activity import rank_activity
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.ranking import models_along
from propermodel.reduction.methods.workbench import Workbench


def by_activity(bench: Workbench) -> Curve:
    """The models of all thresholds."""
    ranking = rank_activity(bench.run)
    rows = {row.path: row for row in bench.rows}
    order = [rows[row.path] for row in reversed(ranking.rows)]
    models = models_along(bench, [bench.by_position(row) for row in order])
    kept = len(ranking.kept_by(bench.threshold))
    removals = [removal for row in order[: len(order) - kept] for removal in bench.by_position(row)]
    return Curve(
        method="activity (MORA)",
        source="Louca et al. 1997",
        models=models,
        chosen=bench.measure(removals),
        rule=f"keep {bench.threshold:.4g} of all activity",
        simulations=bench.simulations,
    )
