"""Backward elimination by measured error: again and again the single removal that costs least.

The plain way to use simulation alone. It needs about as many runs as the square of the number of elements.
"""

from __future__ import annotations

import numpy as np

from propermodel.equations.system import Row
from propermodel.modelling.model import BondRemoval, ZeroEffort, ZeroFlow
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.workbench import SizedModel, Workbench

MOST_SIMULATIONS = 400
USELESS = 0.5  # error at which nobody would go on


def by_measured_error(bench: Workbench) -> Curve:
    """The models on the way down."""
    gone: tuple[BondRemoval, ...] = ()
    models = [bench.measure(gone)]
    left = list(bench.rows)
    notes: tuple[str, ...] = ()
    while left and models[-1].error <= USELESS:
        if bench.simulations >= MOST_SIMULATIONS:
            notes = (f"stopped after {MOST_SIMULATIONS} simulations",)
            break
        tries = [(bench.measure((*gone, *way)), way, row) for row in left for way in _ways(row)]
        best, way, row = min(tries, key=lambda found: (found[0].error, found[0].states))
        if not np.isfinite(best.error):
            break
        gone = (*gone, *way)
        models.append(best)
        left = [other for other in _left(bench, left, best) if other is not row]
    return Curve(
        method="backward elimination",
        source="by measured error",
        models=tuple(models),
        simulations=bench.simulations,
        notes=notes,
    )


def _ways(row: Row) -> list[tuple[BondRemoval, ...]]:
    return [tuple(map(ZeroEffort, row.bonds)), tuple(map(ZeroFlow, row.bonds))]


def _left(bench: Workbench, rows: list[Row], model: SizedModel) -> list[Row]:
    """The rows that the model still has: others may have become idle."""
    paths = {row.path for row in bench.compiled(model.removals).system.rows}
    return [row for row in rows if row.path in paths]
