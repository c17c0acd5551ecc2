"""Tables made ready for look-up: per cell a reference point and polynomial coefficients.

A grid of n points has n + 1 cells: number k holds the coordinates from point k - 1 up to point k, the first and last
are outside. So the cell of a coordinate is the number of grid points not above it, and not-a-number is in cell 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from propermodel.codegen.machine import FloatArray, TableData
from propermodel.codegen.program import Extrapolation, Program, TableSlot


@dataclass(frozen=True, eq=False)
class Axis:
    """One grid: `pairs[k]` are the lower edge of cell k and its reference point."""

    grid: FloatArray
    pairs: FloatArray  # (n + 2, 2)
    cells_per_unit: float  # of a uniform grid


@dataclass(frozen=True, eq=False)
class PreparedTable:
    """A table with, per cell, [value, slope] or [value, slope 0, slope 1, twist] at the reference point."""

    axes: tuple[Axis, ...]
    cells: FloatArray


_prepared: WeakKeyDictionary[TableData, dict[TableSlot, PreparedTable]] = WeakKeyDictionary()


def prepare_tables(program: Program, tables: tuple[TableData, ...]) -> list[PreparedTable]:
    """The tables of a program, ready for look-up.

    Raises:
        ValueError: a table does not fit its slot.
    """
    result: list[PreparedTable] = []
    for slot, data in zip(program.layout.tables, tables, strict=True):
        known = _prepared.setdefault(data, {})
        if slot not in known:
            check_table(slot, data)
            known[slot] = _prepare(slot, data)
        result.append(known[slot])
    return result


def check_table(slot: TableSlot, data: TableData) -> None:
    """Check that data fit a table's slot.

    Raises:
        ValueError: the sizes differ, a number is not finite, a grid does not grow or is not equidistant as declared.
    """
    name = f"table '{slot.path}'"
    if len(data.grids) != slot.dimensions:
        raise ValueError(f"{name} has {slot.dimensions} coordinates, but {len(data.grids)} grids are given")
    for axis, grid in enumerate(data.grids):
        if grid.ndim != 1 or grid.size < 1:
            raise ValueError(f"{name}: grid {axis} must be a list of numbers")
        if not np.isfinite(grid).all():
            raise ValueError(f"{name}: grid {axis} has a number that is not finite")
        gaps = np.diff(grid)
        if not (gaps > 0.0).all():
            place = int(np.argmin(gaps > 0.0))
            raise ValueError(f"{name}: grid {axis} must grow, but {grid[place + 1]} follows {grid[place]}")
        if slot.is_uniform and gaps.size and not _is_uniform(grid):
            raise ValueError(f"{name}: grid {axis} must be equidistant, but its gaps are {gaps.min()} to {gaps.max()}")
    shape = tuple(grid.size for grid in data.grids)
    if data.values.size != np.prod(shape) or (data.values.ndim > 1 and data.values.shape != shape):
        raise ValueError(f"{name} needs values of shape {shape}, not {data.values.shape}")
    if not np.isfinite(data.values).all():
        raise ValueError(f"{name} has a value that is not finite")


def _is_uniform(grid: FloatArray) -> bool:
    even = np.linspace(grid[0], grid[-1], grid.size)
    return bool(np.all(np.abs(grid - even) <= 1e-6 * (even[1] - even[0])))


def _prepare(slot: TableSlot, data: TableData) -> PreparedTable:
    values = data.values.reshape(tuple(grid.size for grid in data.grids))
    at_points = [values]
    for axis, grid in enumerate(data.grids):
        # [value] becomes [value, slope], then [value, slope 0, slope 1, twist].
        at_points = [_extended(item, axis) for item in at_points] + [
            _slopes(item, grid, axis, slot.extrapolation) for item in at_points
        ]
    cells = np.ascontiguousarray(np.stack(at_points, axis=-1))
    return PreparedTable(tuple(_axis(grid) for grid in data.grids), cells)


def _axis(grid: FloatArray) -> Axis:
    pairs = np.empty((grid.size + 2, 2))
    pairs[1:-1] = grid[:, np.newaxis]
    pairs[0] = -np.inf, grid[0]
    pairs[-1] = np.inf, grid[-1]
    density = (grid.size - 1) / (grid[-1] - grid[0]) if grid.size > 1 else 0.0
    return Axis(grid, pairs, float(density))


def _extended(values: FloatArray, axis: int) -> FloatArray:
    count = values.shape[axis]
    return np.take(values, np.maximum(np.arange(count + 1) - 1, 0), axis=axis)


def _slopes(values: FloatArray, grid: FloatArray, axis: int, extrapolation: Extrapolation) -> FloatArray:
    count = grid.size
    if count == 1:
        return np.zeros_like(_extended(values, axis))
    gaps = np.diff(grid).reshape([-1 if i == axis else 1 for i in range(values.ndim)])
    inner = np.diff(values, axis=axis) / gaps
    slopes = np.take(inner, np.clip(np.arange(count + 1) - 1, 0, count - 2), axis=axis)
    if extrapolation is Extrapolation.HOLD:
        outside = [slice(None)] * values.ndim
        outside[axis] = slice(None, None, count)  # the first and the last cell
        slopes[tuple(outside)] = 0.0
    return slopes
