"""What a line of a panel shows: an observable of a run, or an input of its scenario."""

from __future__ import annotations

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import parse_path
from propermodel.modelling.model import TableValues
from propermodel.report.panels import Series
from propermodel.simulation.trajectory import Trajectory


def column_of(run: Trajectory, series: Series) -> tuple[FloatArray, FloatArray, str]:
    """Times, values and unit of a line."""
    path = parse_path(series.path)
    given = run.scenario.inputs.get(path, run.scenario.tables.get(path))
    if path not in run and isinstance(given, TableValues) and len(given.grids) == 1:
        unit = run.compiled.graph.tables[path].spec.unit
        return run.time, np.interp(run.time, given.grids[0], given.values), unit
    return run.time, run[path], run.unit(path)
