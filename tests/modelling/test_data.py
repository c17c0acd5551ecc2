"""Measured data become inputs, in SI, whatever they come from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings

from propermodel.diagnostics import ModelError, ProperModelError
from propermodel.modelling import Limits, measured
from tests.strangers import damaged_bytes


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


def refused(file: Path, **options: Any) -> str:
    with pytest.raises(ProperModelError) as caught:
        measured(file, **options)
    assert file.name[:100] in str(caught.value)
    assert "\n  help: " in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "fewer than two rows"),
        (b"\n\n\n", "fewer than two rows"),
        (b"t,v\n0,1\n", "fewer than two rows"),
        (b"t,v\n0,1\n1\n", "log.csv:3"),
        (b"t,v\n0,1\n1\n", "has nothing in column 'v'"),
        (b"t,v\n0,1\n1,nan\n2,1\n", "line 3 of 'log.csv' has 'nan' in column 'v', where a number is due"),
        (b"t,v\n0,1\n-Infinity,2\n2,1\n", "line 3 of 'log.csv' has '-Infinity' in column 't'"),
        (b"t,v\n0,1\n1,\x1b[2J\n2,1\n", r"has '\x1b[2J' in column 'v'"),
        (b"t,v\n0,1\n1,2\n1,3\n", "the time 1 in line 4 of 'log.csv' does not follow 1"),
        (b't,v\n0,1\n1,"2\n2,3\n', "error[data/csv]: line 3 cannot be read: unexpected end of data"),
        (b"t,v\n0,1\n1,2\x00\n2,3\n", r"has '2\x00' in column 'v'"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "error[data/csv]"),
        (b"t [m],v\n0,1\n1,2\n", "the column of times has the unit m, which is none of time"),
        (b"t,v [furlong2x]\n0,1\n1,2\n", "is not a unit"),
        (b"t,v [km]\n0,1\n1,1e308\n", "needs 2 finite values"),
        (b"a,b,c\n0,1,2\n1,2,3\n", "there are several columns: 'a', 'b', 'c'"),
    ],
)
def test_broken_files_are_refused_with_line_and_column(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes(content)
    assert message in refused(file)


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    assert "error[document/file]: the file cannot be read: No such file" in refused(tmp_path / "nothing.csv")
    assert "error[document/file]: the file cannot be read: it is a folder" in refused(tmp_path)
    assert "it is a pipe or a device" in refused(Path("/dev/zero"))


def test_files_beyond_the_limits_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,v\n" + "".join(f"{n},1\n" for n in range(120)), encoding="utf-8")
    assert len(measured(file).values) == 120
    assert "error[document/size]: the file has 614 bytes; at most 500" in refused(file, limits=Limits(file_bytes=500))
    assert "error[document/limit]: more than 50 rows" in refused(file, limits=Limits(table_points=50))
    file.write_text("t,v\n0,1\n1," + "," * 200_000, encoding="utf-8")
    assert "error[document/limit]: line 3 has more than 100000 characters" in refused(file)


def test_blank_lines_and_a_byte_order_mark_do_no_harm(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes(b"\xef\xbb\xbft, v\r\n0, 1\r\n\r\n1, 2\r\n\r\n")
    assert measured(file, "v").values == (1.0, 2.0)


def test_what_is_no_number_in_tables_is_refused() -> None:
    with pytest.raises(ModelError, match=r"row 1 of 'p' has high \(str\), where a number is due"):
        measured(pd.DataFrame({"p": [1.0, "high"]}), "p")
    times = pd.date_range("2024-01-01", periods=2)
    with pytest.raises(ModelError, match=r"row 0 of 't' has .*, where a number is due"):
        measured(xr.DataArray(["a", "b"], dims="t", coords={"t": times}))


@given(damaged_bytes(b"time [s],speed [km/h]\n" + b"".join(b"%d,%d\n" % (n, n * n) for n in range(20))))
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_bytes_are_refused_or_make_a_table(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes(content)
    try:
        found = measured(file)
    except ProperModelError:
        return
    assert len(found.values) >= 2
