"""Measured data as inputs: columns of CSV files, pandas and xarray objects, with their units."""

from __future__ import annotations

import csv
from pathlib import Path as FilePath
from typing import Any

from propermodel.diagnostics import ModelError, nearest
from propermodel.expressions.units import parse_unit
from propermodel.modelling.model import TableValues
from propermodel.modelling.tables import table_values


def measured(data: Any, column: str | None = None, *, time: str | None = None, unit: str | None = None) -> TableValues:
    """A measured column over time, for the inputs of a scenario; linear between the samples, in SI.

    Args:
        data: The path of a CSV file with a header row, a pandas DataFrame or Series (over its index in seconds, or over
            the column `time`), or an xarray DataArray or Dataset with one time dimension.
        column: The column; not needed for a Series or DataArray.
        time: The column or coordinate of time, s; by default the first column of a file, the index of a DataFrame, the
            dimension of a DataArray.
        unit: The unit of the values; by default what the data say (an attribute `units`, or a header such as
            `speed [km/h]`), else SI.

    Raises:
        ModelError: the column does not exist, is not numeric, or its time does not grow.
    """
    if isinstance(data, (str, FilePath)):
        times, values, found = _from_csv(FilePath(data), column, time)
    elif hasattr(data, "dims"):
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


def _missing(name: str | None, known: list[str]) -> ModelError:
    return ModelError.of(  # pyright: ignore[reportReturnType]
        "data/column",
        f"there is no column '{name}'; there are {', '.join(known)}",
        help=nearest(name or "", known) or "say which column: measured(file, column)",
    )


def _unit_of(header: str) -> str:
    opening, closing = header.rfind("["), header.rfind("]")
    return header[opening + 1 : closing].strip() if 0 <= opening < closing else ""


def _name_of(header: str) -> str:
    return header.split("[", maxsplit=1)[0].strip()


def _pick(headers: list[str], name: str | None, default: int | None) -> int:
    if name is None and default is not None:
        return default
    for index, header in enumerate(headers):
        if name in (header, _name_of(header)):
            return index
    raise _missing(name, headers)


def _from_csv(path: FilePath, column: str | None, time: str | None) -> tuple[list[float], list[float], str]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.reader(file))
    if len(rows) < 3:
        raise ModelError.of(
            "data/short",
            f"'{path.name}' has fewer than two rows of data",
            help="a CSV file has a line of names and two or more lines of numbers",
        )
    headers = [header.strip() for header in rows[0]]
    at_time = _pick(headers, time, 0)
    at_value = _pick(headers, column, 1 if len(headers) == 2 else None)
    times: list[float] = []
    values: list[float] = []
    for number, row in enumerate(rows[1:], 2):
        try:
            times.append(float(row[at_time]))
            values.append(float(row[at_value]))
        except (ValueError, IndexError) as error:
            wrong = headers[at_time if len(times) == len(values) else at_value]
            raise ModelError.of(
                "data/number",
                f"line {number} of '{path.name}' has no number in column '{wrong}'",
                help="correct the line, or leave it out: what is missing is interpolated",
            ) from error
    time_factor = parse_unit(_unit_of(headers[at_time]) or "s").factor
    return [t * time_factor for t in times], values, _unit_of(headers[at_value])


def _from_pandas(data: Any, column: str | None, time: str | None) -> tuple[list[float], list[float], str]:
    if not hasattr(data, "columns"):
        return [float(t) for t in data.index], [float(v) for v in data], str(data.attrs.get("units", ""))
    headers = [str(name) for name in data.columns]
    place = _pick(headers, column, 0 if len(headers) == 1 else None)
    series = data.iloc[:, place]
    times = data.index if time is None else data.iloc[:, _pick(headers, time, None)]
    unit = str(series.attrs.get("units", "")) or _unit_of(headers[place])
    return [float(t) for t in times], [float(v) for v in series], unit


def _from_xarray(data: Any, column: str | None, time: str | None) -> tuple[list[float], list[float], str]:
    array = data
    if hasattr(data, "data_vars"):
        names = [str(name) for name in data.data_vars]
        chosen = column if column is not None else names[0] if len(names) == 1 else None
        if chosen not in names:
            raise _missing(chosen, names)
        array = data[chosen]
    if len(array.dims) != 1:
        raise ModelError.of(
            "data/dimensions",
            f"an input has one dimension, time; this array has {array.dims}",
            help="select one value of every other dimension: array.sel(...)",
        )
    times = array[time or array.dims[0]]
    return [float(t) for t in times.values], [float(v) for v in array.values], str(array.attrs.get("units", ""))
