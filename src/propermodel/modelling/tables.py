"""Tables: measured curves and maps as run-time data of a component."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, Literal

from propermodel.diagnostics import ModelError
from propermodel.expressions.core import Expr, constant
from propermodel.expressions.units import dimension_text, parse_unit
from propermodel.modelling.components import Table
from propermodel.modelling.model import TableValues
from propermodel.modelling.references import call_site


def quantity(value: float, unit: str) -> Expr:
    """A number with a unit, for use in a law or as a parameter value; it becomes SI."""
    parsed = parse_unit(unit)
    text = dimension_text(parsed.dimension)
    return constant(value * parsed.factor, "" if text == "1" else text)


def table_values(grids: Sequence[Iterable[float]], values: Iterable[float]) -> TableValues:
    """The numbers of a table, checked: finite, every grid strictly growing, as many values as grid points.

    Raises:
        ModelError: otherwise.
    """
    data = TableValues(tuple(tuple(float(x) for x in grid) for grid in grids), tuple(float(v) for v in values))
    if len(data.grids) not in (1, 2):
        raise ModelError.of(
            "model/table-grid",
            f"a table has one or two grids, {len(data.grids)} were given",
            help="write what depends on more coordinates as several tables",
        )
    expected = 1
    for grid in data.grids:
        expected *= len(grid)
        if len(grid) < 2 or not all(map(math.isfinite, grid)) or any(not b > a for a, b in pairwise(grid)):
            raise ModelError.of(
                "model/table-grid",
                "the grid of a table must have two or more strictly growing, finite points",
                help="sort the points, and drop those that are there twice or are not finite",
            )
    if len(data.values) != expected or not all(map(math.isfinite, data.values)):
        raise ModelError.of(
            "model/table-values",
            f"a table on this grid needs {expected} finite values, {len(data.values)} were given",
            help="give one finite value for each point; the last coordinate varies fastest",
        )
    return data


def table(
    unit: str,
    coordinate_units: tuple[str, ...],
    grids: Sequence[Iterable[float]],
    values: Iterable[float],
    *,
    extrapolation: Literal["hold", "linear"] = "hold",
    source: str = "",
) -> Any:
    """Declare a table in a class body; in a law `self.name(x)` or `self.name(x, y)` interpolates it.

    Args:
        unit: Unit of the values; numbers are converted to SI. coordinate_units: Unit of each coordinate.
        grids: One or two strictly growing grids. values: One value per grid point, the last coordinate
        varying fastest. extrapolation: What it answers outside the grid: the nearest value, or the continued
        end cell. A run counts
            the time spent outside and reports it.
        source: Where the numbers come from.
    """
    factors = [parse_unit(u).factor for u in coordinate_units]
    scaled = [[x * f for x in grid] for grid, f in zip(grids, factors, strict=True)]
    factor = parse_unit(unit).factor
    try:
        data = table_values(scaled, [v * factor for v in values])
    except ModelError as error:
        first = error.diagnostics[0]
        raise ModelError.of(first.code, first.message, source=call_site(1), help=first.help) from error
    return Table(unit, coordinate_units, data, extrapolation, source)
