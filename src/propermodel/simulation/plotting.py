"""Recorded columns as a figure, one diagram for each, in the units of readers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from propermodel.diagnostics import Path, SimulationError
from propermodel.expressions.core import Expr
from propermodel.simulation.display_units import display_of
from propermodel.simulation.export import Recorded
from propermodel.simulation.observables import observable_path

HEIGHT = 1.7  # of a diagram, inches
WIDTH = 8.0


def plot(run: Recorded, observables: Iterable[Expr | Path | str], axes: Sequence[Any] | None = None) -> list[Any]:
    """Draw observables of a run over time, one above the other.

    Args:
        run: The run.
        observables: What to draw.
        axes: Matplotlib axes to draw into, one for each, for instance those of another run; new ones by default.

    Returns:
        The axes.

    Raises:
        SimulationError: an observable was not recorded, or there are not as many axes as observables.
    """
    paths = [observable_path(observable) for observable in observables]
    columns = [run[path] for path in paths]
    if axes is None:
        import matplotlib.pyplot as plt

        if not paths:
            raise SimulationError.of(
                "simulation/nothing-to-plot",
                "no observables were given",
                help='name some: run.plot(["body.flange.flow"])',
            )
        figure, grid = plt.subplots(
            len(paths), 1, sharex=True, squeeze=False, figsize=(WIDTH, HEIGHT * len(paths) + 0.5), layout="constrained"
        )
        axes = list(grid[:, 0])
        figure.supxlabel("time, s")
    if len(axes) != len(paths):
        raise SimulationError.of(
            "simulation/nothing-to-plot",
            f"{len(paths)} observables need as many axes; {len(axes)} were given",
            help="give the axes that another plot of as many observables returned",
        )
    for one, path, values in zip(axes, paths, columns, strict=True):
        finite = values[np.isfinite(values)]
        shown = display_of(run.unit(path), finite)
        one.plot(run.time, values * shown.factor)
        one.set_title(str(path), loc="left", fontsize="medium")
        one.set_ylabel(shown.unit or "1")
        one.grid(visible=True, alpha=0.3)
    return list(axes)
