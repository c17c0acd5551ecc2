"""The numbers of tables as arrays: converted and checked once, however many runs share them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from propermodel.codegen.lower import is_uniform
from propermodel.codegen.machine import FloatArray, TableData
from propermodel.modelling.model import TableValues


@dataclass(frozen=True, eq=False)
class StoredTable:
    """A table as arrays, and what is true of its numbers."""

    values: TableValues
    data: TableData
    is_uniform: bool
    wrong: tuple[float, ...]  # numbers that are not finite, the values first


@dataclass(frozen=True)
class TableStore:
    """The tables of some runs; two that are one object are converted once."""

    _kept: dict[int, StoredTable] = field(default_factory=dict[int, StoredTable])
    _constants: dict[tuple[float, float, float], TableValues] = field(
        default_factory=dict[tuple[float, float, float], TableValues]
    )

    def get(self, values: TableValues) -> StoredTable:
        """The arrays of a table."""
        # The table is kept with its arrays, so that no other object can get its identity.
        found = self._kept.get(id(values))
        if found is None:
            data = TableData(tuple(np.array(grid) for grid in values.grids), np.array(values.values))
            wrong = _wrong(data)
            found = StoredTable(values, data, not wrong and is_uniform(data.grids), wrong)
            self._kept[id(values)] = found
        return found

    def constant(self, value: float, start: float, stop: float) -> TableValues:
        """A table over time that has one value; equal ones are one object."""
        key = (start, stop, value)
        if key not in self._constants:
            self._constants[key] = TableValues(((start, stop),), (value, value))
        return self._constants[key]


def _wrong(data: TableData) -> tuple[float, ...]:
    arrays: list[FloatArray] = [*data.grids, data.values]
    return tuple(float(x) for array in arrays for x in array[~np.isfinite(array)])
