"""Columns of numbers from CSV, Parquet and netCDF files of other tools, with their units."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import ReductionError
from propermodel.modelling.files import FileName

_NAME = re.compile(r"\s*(.*?)\s*(?:\[([^\]]*)\])?\s*")  # force [kN]


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns by the names that they have in the file, with their units; an empty unit is not known."""

    values: Mapping[str, FloatArray]
    units: Mapping[str, str]

    @classmethod
    def of(cls, columns: Mapping[str, Any], units: Mapping[str, str] | None = None) -> Columns:
        """Columns whose names may hold units (`force [kN]`)."""
        found = {name: (units or {}).get(name) or _unit_in(name) for name in columns}
        return cls({name: np.asarray(values, dtype=np.float64) for name, values in columns.items()}, found)

    def find(self, name: str) -> str | None:
        """The column of a name, with or without the unit behind it."""
        if name in self.values:
            return name
        return next((column for column in self.values if _bare(column) == name), None)


def _bare(name: str) -> str:
    match = _NAME.fullmatch(name)
    return match[1] if match else name


def _unit_in(name: str) -> str:
    match = _NAME.fullmatch(name)
    return (match[2] or "") if match else ""


def read_columns(file: FileName) -> Columns:
    """The columns of a file, by its ending: `.csv`, `.parquet`, `.nc`.

    Raises:
        ReductionError: it has another ending, cannot be read, or what reads it is not installed.
    """
    readers = {".csv": _read_csv, ".parquet": _read_parquet, ".nc": _read_netcdf}
    ending = FilePath(file).suffix.lower()
    if ending not in readers:
        raise _fault(file, f"no file of samples ends in '{ending}'", "give a .csv, .parquet or .nc file")
    try:
        return readers[ending](FilePath(file))
    except ImportError as error:
        needed = "pip install 'propermodel[parquet]'" if ending == ".parquet" else "pip install 'propermodel[data]'"
        raise _fault(file, f"what reads it is not installed: {str(error).splitlines()[0]}", needed) from error
    except (OSError, ValueError) as error:
        raise _fault(
            file, str(error).splitlines()[0], "give a file with a column of numbers for each variable"
        ) from error


def _fault(file: FileName, message: str, cure: str) -> ReductionError:
    return ReductionError.of("activity/reader", f"'{file}' cannot be read: {message}", help=cure)


def _read_csv(file: FilePath) -> Columns:
    with file.open(encoding="utf-8", newline="") as stream:
        rows = csv.reader(stream)
        names = next(rows, [])
        numbers = [[float(cell or "nan") for cell in row] for row in rows if row]
    if not names or any(len(row) != len(names) for row in numbers):
        raise ValueError("its rows are not as long as its first one, which names the columns")
    table = np.array(numbers, dtype=np.float64).reshape(-1, len(names))
    return Columns.of({name.strip(): table[:, k] for k, name in enumerate(names)})


def _read_parquet(file: FilePath) -> Columns:
    import pandas as pd

    frame: Any = pd.read_parquet(file)
    if frame.index.name is not None:
        frame = frame.reset_index()
    return Columns.of({str(name): frame[name].to_numpy() for name in frame.columns})


def _read_netcdf(file: FilePath) -> Columns:
    import xarray as xr

    # Units of time are read as units, not as dates since an origin.
    with xr.open_dataset(file, decode_times=False) as data:
        held = {str(name): array for name, array in data.variables.items() if array.ndim == 1}
        units = {name: str(array.attrs.get("units", "")) for name, array in held.items()}
        return Columns.of({name: array.values for name, array in held.items()}, units)
