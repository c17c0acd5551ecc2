"""What the studio shows of a scenario before a run: how long it lasts, and what its inputs do."""

from __future__ import annotations

from typing import Any

import numpy as np

from propermodel.bondgraph.flatten import flatten
from propermodel.catalogue.subject import Subject
from propermodel.modelling.model import TableValues
from propermodel.report.buckets import extremes

Json = Any

INTERVALS = 150


def scenario_sheet(subject: Subject) -> Json:
    """The scenario of a subject, its inputs over time in few points."""
    scenario = subject.scenario
    tables = flatten(subject.model).tables
    inputs: list[Json] = []
    for path, value in {**scenario.inputs, **scenario.tables}.items():
        table = tables.get(path)
        unit = "" if table is None else table.spec.unit
        if not isinstance(value, TableValues):
            times, values = [scenario.start, scenario.stop], [float(value), float(value)]
        elif len(value.grids) == 1:
            times, values = _preview(np.array(value.grids[0]), np.array(value.values), scenario.start, scenario.stop)
        else:
            continue  # a map, which is no course over time
        inputs.append({"path": str(path), "unit": unit, "times": times, "values": values})
    return {
        "name": scenario.name,
        "duration": scenario.stop - scenario.start,
        "start": scenario.start,
        "description": scenario.description,
        "inputs": inputs,
    }


def _preview(
    grid: np.ndarray[Any, np.dtype[np.float64]],
    values: np.ndarray[Any, np.dtype[np.float64]],
    start: float,
    stop: float,
) -> tuple[list[float], list[float]]:
    """A course between two instants: all of its points if they are few, else the extremes of intervals."""
    inside = (grid >= start) & (grid <= stop)
    if np.count_nonzero(inside) <= 2 * INTERVALS or not stop > start:
        times = np.unique(np.concatenate([[start], grid[inside], [stop]]))
        return times.tolist(), np.interp(times, grid, values).tolist()
    edges = np.linspace(start, stop, INTERVALS + 1)
    times = np.column_stack([edges[:-1], 0.5 * (edges[:-1] + edges[1:])]).ravel()
    return times.tolist(), extremes(grid, values, edges).tolist()
