"""Measured data as inputs: columns of CSV files, pandas and xarray objects, with their units."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from propermodel.diagnostics import Diagnostic, ModelError, ProperModelError, Source, portable_file
from propermodel.expressions.units import parse_unit
from propermodel.modelling.csv_files import pick, read_columns, unit_of
from propermodel.modelling.limits import LIMITS, Limits
from propermodel.modelling.model import TableValues
from propermodel.modelling.tables import table_values


def measured(
    data: Any,
    column: str | None = None,
    *,
    time: str | None = None,
    unit: str | None = None,
    limits: Limits = LIMITS,
) -> TableValues:
    """A measured column over time, for the inputs of a scenario; linear between the samples, in SI.

    Args:
        data: The path of a CSV file with a header row, a pandas DataFrame or Series (over its index in seconds, or over
            the column `time`), or an xarray DataArray or Dataset with one time dimension.
        column: The column; not needed for a Series or DataArray.
        time: The column or coordinate of time, s; by default the first column of a file, the index of a DataFrame, the
            dimension of a DataArray.
        unit: The unit of the values; by default what the data say (an attribute `units`, or a header such as
            `speed [km/h]`), else SI.
        limits: The most that is read of a file.

    Raises:
        ModelError: the column does not exist, is not numeric, or its time does not grow.
        DocumentError: a file cannot be read, or goes beyond a limit.
    """
    if isinstance(data, (str, os.PathLike)):
        try:
            return _from_csv(data, column, time, unit, limits)
        except ProperModelError as error:
            file = Source(portable_file(os.fspath(data)), 0)
            raise type(error)([_of_file(d, file) for d in error.diagnostics]) from error
    if hasattr(data, "dims"):
        times, values, found = _from_xarray(data, column, time)
    elif hasattr(data, "index") and hasattr(data, "attrs"):
        times, values, found = _from_pandas(data, column, time)
    else:
        raise ModelError.of(
            "data/kind",
            f"measured data can be a CSV file, a pandas or an xarray object, not {type(data).__name__}",
            help="for arrays use table_values([times], values)",
        )
    factor = parse_unit(unit if unit is not None else found).factor
    return table_values([times], [value * factor for value in values])


def _of_file(diagnostic: Diagnostic, file: Source) -> Diagnostic:
    return diagnostic if diagnostic.source.file else replace(diagnostic, source=file)


def _from_csv(
    path: str | os.PathLike[str], column: str | None, time: str | None, unit: str | None, limits: Limits
) -> TableValues:
    found = read_columns(path, column, time, limits)
    seconds = parse_unit(unit_of(found.time_header) or "s")
    if seconds.dimension != parse_unit("s").dimension:
        raise ModelError.of(
            "unit/mismatch",
            f"the column of times has the unit {seconds.text}, which is none of time",
            help="say which column holds the times: measured(file, column, time=...)",
        )
    factor = parse_unit(unit if unit is not None else unit_of(found.value_header)).factor
    return table_values([[t * seconds.factor for t in found.times]], [value * factor for value in found.values])


def _numbers(values: Iterable[Any], what: str) -> list[float]:
    """What pandas and xarray hold, as numbers."""
    found: list[float] = []
    for number, value in enumerate(values):
        try:
            found.append(float(value))
        except (TypeError, ValueError) as error:
            raise ModelError.of(
                "data/number",
                f"row {number} of {what} has {value!s:.40} ({type(value).__name__}), where a number is due",
                help="give numbers; of times, seconds since the start",
            ) from error
    return found


def _from_pandas(data: Any, column: str | None, time: str | None) -> tuple[list[float], list[float], str]:
    if not hasattr(data, "columns"):
        return _numbers(data.index, "the index"), _numbers(data, "the series"), str(data.attrs.get("units", ""))
    headers = [str(name) for name in data.columns]
    place = pick(headers, column, 0 if len(headers) == 1 else None)
    series = data.iloc[:, place]
    times = data.index if time is None else data.iloc[:, pick(headers, time, None)]
    unit = str(series.attrs.get("units", "")) or unit_of(headers[place])
    return _numbers(times, f"'{time or 'index'}'"), _numbers(series, f"'{headers[place]}'"), unit


def _from_xarray(data: Any, column: str | None, time: str | None) -> tuple[list[float], list[float], str]:
    array = data
    if hasattr(data, "data_vars"):
        names = [str(name) for name in data.data_vars]
        array = data[names[pick(names, column, 0 if len(names) == 1 else None)]]
    if len(array.dims) != 1:
        raise ModelError.of(
            "data/dimensions",
            f"an input has one dimension, time; this array has {array.dims}",
            help="select one value of every other dimension: array.sel(...)",
        )
    name = time or array.dims[0]
    return (
        _numbers(array[name].values, f"'{name}'"),
        _numbers(array.values, "the array"),
        str(array.attrs.get("units", "")),
    )
