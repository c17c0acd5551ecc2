"""Files that are no documents: refused with the file, the reason and a cure, whatever they are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from propermodel.diagnostics import DocumentError
from propermodel.modelling import Model, Scenario, elaborate
from propermodel.modelling.documents import read_model, read_scenario, write_model
from propermodel.modelling.limits import Limits
from tests.cli.quarter_car import QuarterCar
from tests.strangers import damaged_bytes

READERS = pytest.mark.parametrize("read", [read_model, read_scenario])


def refused(read, path: object, limits: Limits | None = None) -> str:
    with pytest.raises(DocumentError) as caught:
        read(path) if limits is None else read(path, limits=limits)
    text = str(caught.value)
    assert "\n  help: " in text
    return text


@READERS
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "error[document/json]: the file is not JSON: Expecting value in line 1, column 1"),
        ("{", "error[document/json]: the file is not JSON"),
        ('{\n"format": ', "error[document/json]: the file is not JSON: Expecting value in line 2, column 11"),
        ('{"format": "x', "error[document/json]: the file is not JSON: Unterminated string"),
        ("\ufeff{}", "error[document/json]: the file is not JSON: Unexpected UTF-8 BOM"),
        ("[" * 100_000, "error[document/limit]: more than 32 lists and objects in each other in line 1"),
        ("[]\n" + '{"a":' * 100_000, "error[document/limit]: more than 32 lists and objects in each other in line 2"),
        ('{"format": NaN}', "error[document/json]: 'NaN' is not a number of JSON"),
        ('{"format": -Infinity}', "error[document/json]: '-Infinity' is not a number of JSON"),
        ('{"a": 1, "a": 2}', "error[document/json]: the entry 'a' is given twice in one object"),
        ('{"\\u001b[2J": 1, "\\u001b[2J": 2}', r"the entry '\x1b[2J' is given twice"),
        ('{"version": ' + "9" * 5000 + "}", "error[document/json]: the file is not JSON"),
        ("[]", "error[document/content]: expected an object, found a list"),
        ("{}", "its format is missing"),
    ],
)
def test_files_that_are_no_documents(read, tmp_path: Path, text: str, message: str):
    file = tmp_path / "model.json"
    file.write_text(text, encoding="utf-8")
    told = refused(read, file)
    assert message in told
    assert "--> model.json" in told


@READERS
@pytest.mark.parametrize("junk", [b"\xff\xfe\x00", b"\x7fELF\x02\x01\x01\x00\xf0", b"{}\xc3", bytes(range(256))])
def test_files_that_are_not_text(read, tmp_path: Path, junk: bytes):
    file = tmp_path / "model.json"
    file.write_bytes(junk)
    assert "error[document/json]: the file is not" in refused(read, file)


def test_brackets_in_texts_are_not_lists(tmp_path: Path):
    file = tmp_path / "model.json"
    file.write_text('{"format": "' + "[{" * 50 + '\\"' + "[" * 50 + '"}')
    assert "error[document/format]" in refused(read_model, file)


@READERS
def test_folders_devices_pipes_and_missing_files(read, tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.json")
    for path, reason in (
        (tmp_path / "nothing.json", "No such file or directory"),
        (tmp_path / "nowhere" / "model.json", "No such file or directory"),
        (tmp_path, "it is a folder"),
        (Path("/dev/zero"), "it is a pipe or a device"),
        (tmp_path / "pipe.json", "it is a pipe or a device"),
        (tmp_path / ("x" * 5000), "File name too long"),
        ("model\0.json", "embedded null"),
    ):
        told = refused(read, path)
        assert f"error[document/file]: the file cannot be read: {reason}" in told
        assert "help: check the path" in told


@READERS
def test_large_files_are_not_read(read, tmp_path: Path):
    file = tmp_path / "model.json"
    with file.open("wb") as stream:
        stream.truncate(2**40)  # without a block on the disk
    assert f"error[document/size]: the file has {2**40} bytes; at most {2**26} are read" in refused(read, file)
    assert "limits=pm.Limits(file_bytes=...)" in refused(read, file)


def test_a_file_that_is_trusted_is_read_with_greater_limits(tmp_path: Path):
    model = elaborate(QuarterCar())
    write_model(model, tmp_path / "model.json")
    small = Limits(file_bytes=1000)
    assert "at most 1000 are read" in refused(read_model, tmp_path / "model.json", small)
    assert read_model(tmp_path / "model.json", limits=Limits(file_bytes=10**12)) == model


@READERS
def test_a_document_of_another_kind_is_told_apart(read, tmp_path: Path):
    write_model(elaborate(QuarterCar()), tmp_path / "model.json")
    if read is read_scenario:
        assert "help: read it with read_model" in refused(read, tmp_path / "model.json")


@given(st.data())
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_bytes_are_refused_or_make_a_model(tmp_path: Path, data: st.DataObject):
    file = tmp_path / "model.json"
    if not file.exists():
        write_model(elaborate(QuarterCar()), file)
    damaged = tmp_path / "damaged.json"
    damaged.write_bytes(data.draw(damaged_bytes(file.read_bytes())))
    for read, kind in ((read_model, Model), (read_scenario, Scenario)):
        try:
            found = read(damaged)
        except DocumentError:
            continue
        assert isinstance(found, kind)
