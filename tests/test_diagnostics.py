"""Paths, sources and the text of diagnostics."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from propermodel.diagnostics import (
    Diagnostic,
    Faults,
    Involved,
    ModelError,
    Path,
    ProperModelError,
    Severity,
    Source,
    nearest,
    parse_path,
    portable_file,
)


def test_path():
    path = parse_path("axles[0].hub.flange")
    assert path == Path(("axles[0]", "hub", "flange"))
    assert str(path) == "axles[0].hub.flange"
    assert path.parent / "shaft" == parse_path("axles[0].hub.shaft")
    assert path.name == "flange"
    assert path.is_below(parse_path("axles[0]"))
    assert not path.is_below(parse_path("axles"))
    assert Path().parent == Path()
    assert (Path(("a",)) + Path(("b", "c"))).parent == parse_path("a.b")
    tail = ("b",)
    assert isinstance(Path(("a",)) + tail, Path)


def test_text_of_a_diagnostic():
    diagnostic = Diagnostic(
        "causality/conflict",
        "two flow sources set the velocity of one junction",
        where="rig.wheel_hub (1-junction)",
        source=Source("models/rig.py", 41),
        involved=(
            Involved("rig.road", "prescribes its velocity", Source("models/rig.py", 33)),
            Involved("rig.shaker", "prescribes its velocity", Source("models/rig.py", 36)),
        ),
        help="put a compliance between them, or make one of them an effort source",
    )
    assert str(diagnostic) == (
        "error[causality/conflict]: two flow sources set the velocity of one junction\n"
        "  --> models/rig.py:41  rig.wheel_hub (1-junction)\n"
        "      rig.road    prescribes its velocity   models/rig.py:33\n"
        "      rig.shaker  prescribes its velocity   models/rig.py:36\n"
        "  help: put a compliance between them, or make one of them an effort source"
    )


def test_text_without_place_is_one_line():
    assert str(Diagnostic("a/b", "so", severity=Severity.WARNING)) == "warning[a/b]: so"


def test_faults_are_raised_once_with_all():
    faults = Faults(ModelError)
    faults.raise_if_any()
    faults.add(Diagnostic("a/b", "first"))
    faults.add(Diagnostic("c/d", "second"))
    with pytest.raises(ModelError) as caught:
        faults.raise_if_any()
    assert str(caught.value) == "error[a/b]: first\nerror[c/d]: second"
    assert isinstance(caught.value, ProperModelError)


def test_nearest_name():
    assert nearest("stifness", ["damping", "stiffness"]) == "did you mean 'stiffness'?"
    assert nearest("mass", ["damping", "stiffness"]) == ""


@pytest.mark.parametrize(
    ("file", "portable"),
    [
        ("models/rig.py", "models/rig.py"),
        ("./models/rig.py", "models/rig.py"),
        ("/somewhere/else/rig.py", "rig.py"),
        ("<string>", "<string>"),
        ("", ""),
    ],
)
def test_file_names_tell_nothing_of_the_machine(file, portable):
    assert portable_file(file) == portable


def test_file_below_the_working_directory_is_relative_to_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert portable_file(str(FilePath.cwd() / "models" / "rig.py")) == "models/rig.py"


def test_file_on_the_import_path_is_relative_to_it(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    assert portable_file(str(tmp_path / "package" / "parts.py")) == "package/parts.py"
