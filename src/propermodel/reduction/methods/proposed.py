"""The method of this package, for comparison: prediction proposes, simulation decides, at several tolerances."""

from __future__ import annotations

import numpy as np

from propermodel.modelling.model import Freeze
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.workbench import SizedModel, Workbench
from propermodel.reduction.search import find_proper_model

STEPS = (0.1, 0.3, 1.0, 3.0, 10.0)  # times the tolerance that is asked for


def by_prediction(bench: Workbench) -> Curve:
    """The smallest models at tolerances around the one that is asked for."""
    stepping = bench.run.stepping
    models = {len(bench.rows): bench.measure(())}
    chosen: SizedModel | None = None
    simulations = 0
    for factor in STEPS:
        tolerance = factor * bench.tolerance
        found = find_proper_model(
            bench.full.model,
            bench.scenario,
            dict.fromkeys(bench.outputs, tolerance),
            method=stepping.method,
            step=stepping.step,
            jacobian_every=stepping.jacobian_every,
            step_tolerance=stepping.tolerance,
            record_every=bench.record_every,
        )
        simulations += found.simulations if factor == 1.0 else 0
        for candidate in found.candidates:
            if not np.isfinite(candidate.score):
                continue
            model = SizedModel(
                rows=found.rows - len(candidate.rows),
                states=candidate.states,
                error=candidate.score * tolerance,
                removals=tuple(r for r in candidate.removals if not isinstance(r, Freeze)),
            )
            known = models.get(found.rows - len(candidate.rows))
            if known is None or model.error < known.error:
                models[found.rows - len(candidate.rows)] = model
        if factor == 1.0 and found.best is not None:
            chosen = models[found.rows - len(found.best.rows)]
    return Curve(
        method="predicted and verified",
        source="this package",
        models=tuple(models[size] for size in sorted(models, reverse=True)),
        chosen=chosen,
        rule=f"the smallest within {bench.tolerance:.3g}, verified by simulation",
        simulations=simulations,
        notes=("simulations are those of the search at the tolerance itself",),
    )
