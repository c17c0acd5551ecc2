"""Measured data become inputs, in SI, whatever they come from."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
import xarray as xr

from propermodel.diagnostics import ModelError
from propermodel.modelling import measured


def test_a_csv_column_with_its_unit_in_the_header(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t [ms],speed [km/h],gear\n0,0,1\n500,36,1\n1000,72,2\n", encoding="utf-8")
    values = measured(file, "speed")
    assert values.grids == ((0.0, 0.5, 1.0),)
    assert values.values == pytest.approx((0.0, 10.0, 20.0))


def test_pandas_columns_and_series() -> None:
    frame = pd.DataFrame({"time": [0.0, 1.0, 2.0], "p": [1.0, 2.0, 3.0]})
    assert measured(frame, "p", time="time", unit="bar").values == pytest.approx((1e5, 2e5, 3e5))
    assert measured(pd.Series([4.0, 5.0], index=[0.0, 1.0])).values == (4.0, 5.0)


def test_xarray_units_are_read() -> None:
    array = xr.DataArray([0.0, 60.0], dims="t", coords={"t": [0.0, 1.0]}, attrs={"units": "rpm"})
    assert measured(array).values == pytest.approx((0.0, 6.283185307))
    assert measured(array.to_dataset(name="speed"), "speed").values == pytest.approx((0.0, 6.283185307))


def test_a_misspelt_column_is_answered_with_the_nearest(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,speed,gear\n0,0,1\n1,1,1\n", encoding="utf-8")
    with pytest.raises(ModelError, match="did you mean 'speed'"):
        measured(file, "sped")


def test_a_hole_in_the_data_names_its_line(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,speed\n0,0\n1,\n2,1\n", encoding="utf-8")
    with pytest.raises(ModelError, match=r"line 3 of 'log.csv'"):
        measured(file)
