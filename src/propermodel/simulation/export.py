"""Recorded columns for other programs: pandas, xarray, CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path as FilePath
from typing import Any, Protocol

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr
from propermodel.modelling.files import FileName
from propermodel.simulation.observables import observable_path
from propermodel.simulation.series import Series

Observables = Iterable[Expr | Path | str] | None


class Recorded(Protocol):
    """A run with its recorded columns."""

    @property
    def time(self) -> FloatArray: ...

    @property
    def paths(self) -> tuple[Path, ...]: ...

    @property
    def signals(self) -> Series: ...

    def __contains__(self, observable: Expr | Path | str) -> bool: ...

    def __getitem__(self, observable: Expr | Path | str) -> FloatArray: ...

    def unit(self, observable: Expr | Path | str) -> str: ...

    def column_of(self, path: Path) -> int: ...


def to_pandas(run: Recorded, only: Observables = None) -> Any:
    """Columns as a pandas DataFrame over time."""
    import pandas as pd

    columns = {str(path): run[path] for path in _chosen(run, only)}
    return pd.DataFrame(columns, index=pd.Index(run.time, name="time_s"))


def frames(run: Recorded, only: Observables = None) -> Iterator[Any]:
    """Columns as pandas DataFrames over time, some rows at a time."""
    import pandas as pd

    paths = _chosen(run, only)
    for times, columns in _pieces(run, paths):
        yield pd.DataFrame(dict(zip(map(str, paths), columns, strict=True)), index=pd.Index(times, name="time_s"))


def to_xarray(run: Recorded, only: Observables = None) -> Any:
    """Columns as an xarray Dataset over time, with units."""
    import xarray as xr

    data = {str(path): ("time", run[path], {"units": run.unit(path)}) for path in _chosen(run, only)}
    return xr.Dataset(data, coords={"time": ("time", run.time, {"units": "s"})})


def to_csv(run: Recorded, file: FileName, only: Observables = None) -> None:
    """Write columns over time as CSV, in SI, some rows at a time."""
    paths = _chosen(run, only)
    with FilePath(file).open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["time_s", *(f"{path} [{run.unit(path)}]" for path in paths)])
        for times, columns in _pieces(run, paths):
            rows = np.column_stack([times, *columns]).tolist()
            writer.writerows([f"{value:.9g}" for value in row] for row in rows)


def _chosen(run: Recorded, only: Observables) -> tuple[Path, ...]:
    if only is None:
        return run.paths
    return tuple(map(observable_path, only))


def _pieces(run: Recorded, paths: tuple[Path, ...]) -> Iterator[tuple[FloatArray, list[FloatArray]]]:
    """Times and the columns of these observables, some rows at a time."""
    # What is made from other columns is made once: it may need all rows.
    made = {path: run[path] for path in paths if path not in run}
    begin = 0
    for times, rows in run.signals.pieces():
        here = slice(begin, begin + len(times))
        yield times, [made[path][here] if path in made else rows[:, run.column_of(path)] for path in paths]
        begin += len(times)
