"""What is listed, and what is told of a model and a scenario."""

from __future__ import annotations

from pathlib import Path

import pytest

from propermodel.catalogue.finding import load_subject
from propermodel.cli.faults import CommandError
from propermodel.cli.studio import served
from propermodel.compiler import compile_model
from propermodel.drawing.depict import depict
from propermodel.modelling.limits import LIMITS
from propermodel.studio.faults import StudioError
from propermodel.studio.folder import Folder, Trust
from propermodel.studio.listing import Listing
from propermodel.studio.server import listening
from tests.studio.client import Client, Running


def test_models_of_the_library_and_of_the_folder_are_listed(studio: Client):
    start = studio.get("/api/start").json
    assert start["trusted"] is True
    listed = {entry["id"]: entry for entry in start["models"]}
    assert listed["half-car"]["scenarios"] == ["rough_road"]
    assert listed["car.py:QuarterCar"] == {
        "id": "car.py:QuarterCar",
        "name": "QuarterCar",
        "kind": "python",
        "file": "car.py",
        "scenarios": ["waves", "bouncing"],
        "note": "Body on a suspension on a wheel on a tyre; the road moves the tyre.",
    }
    assert listed["inner/car.json"]["kind"] == "document"
    assert listed["inner/car.json"]["scenarios"] == ["inner/waves.json"]
    assert not any("way_out" in name or "secret" in name or "notes" in name for name in listed)
    assert "car.py:SpringDamper" not in listed  # a part of another one


def test_listing_runs_nothing(tmp_path: Path):
    text = 'import propermodel as pm\nraise SystemExit("run")\n\nclass Rig(pm.Component):\n    connections = ()\n'
    (tmp_path / "rig.py").write_text(text, encoding="utf-8")
    (tmp_path / "deep.py").write_text("import propermodel\nx = " + "(" * 5000, encoding="utf-8")
    (tmp_path / "chain.py").write_text(f"import propermodel\ndef f() -> {'a.' * 20000}b: ...", encoding="utf-8")
    found = [entry.id for entry in Listing(tmp_path).entries() if entry.kind == "python"]
    assert found == ["rig.py:Rig"]


def test_a_file_that_changes_is_read_again(tmp_path: Path):
    listing = Listing(tmp_path)
    file = tmp_path / "rig.py"
    for name in ("First", "Second_"):
        file.write_text(f"import propermodel\n\nclass {name}:\n    connections = ()\n", encoding="utf-8")
        assert f"rig.py:{name}" in [entry.id for entry in listing.entries()]


def test_a_sheet_tells_what_the_model_is(studio: Client, folder: Path):
    sheet = studio.get("/api/model?id=car.py:QuarterCar").json
    compiled = compile_model(load_subject(f"{folder / 'car.py'}:QuarterCar").model)
    assert sheet["picture"] == depict(compiled).document()
    counts = {item["name"]: item["count"] for item in sheet["counts"]}
    assert counts["states"] == len(compiled.system.states) == 4
    assert counts["inertias"] == counts["compliances"] == counts["resistances"] == 2
    assert set(sheet["elements"]) >= {str(path) for path in compiled.graph.normal.elements}
    spring = sheet["elements"]["suspension.spring"]
    assert spring["laws"] == ["port.effort = stiffness*displacement", "energy = stiffness*displacement*displacement/2"]
    assert spring["equations"] == ["port.effort = stiffness*displacement", "d/dt displacement = port.flow"]
    assert spring["bonds"] == [{"name": "suspension.spring.port", "effort": "N", "flow": "m/s"}]
    assert spring["place"].startswith("car.py:")
    body = next(row for row in sheet["parameters"] if row["path"] == "body_mass")
    expected = {"path": "body_mass", "value": "1200", "unit": "kg", "status": "estimated", "source": "a weighbridge"}
    assert body == expected
    assert "d/dt" not in str(sheet["counts"])
    assert sheet["method"] in sheet["methods"]
    lines = studio.get("/api/equations?model=car.py:QuarterCar").json["lines"]
    assert lines[0] == "quarter_car: 4 states"


def test_a_document_is_opened_without_agreement(folder: Path, tmp_path: Path):
    (tmp_path / "car.json").write_bytes((folder / "inner" / "car.json").read_bytes())
    (tmp_path / "rig.py").write_text("raise SystemExit", encoding="utf-8")
    with Running(tmp_path, tmp_path / "trust.json") as client:
        assert client.get("/api/start").json["trusted"] is False
        assert client.get("/api/model?id=car.json").json["name"] == "car"
        for path in ("model?id=rig.py:Rig", "model?id=rig.py", "scenario?model=car.json&scenario=rig.py:x"):
            refused = client.get(f"/api/{path}")
            assert (refused.status, refused.code) == (403, "studio/untrusted")
        order = {"model": "car.json", "scenario": "rig.py:x"}
        assert client.post("/api/runs", order).code == "studio/untrusted"


def test_agreement_is_kept_for_the_folder_alone(tmp_path: Path):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    one, other = Folder(tmp_path / "one"), Folder(tmp_path / "other")
    Trust(tmp_path / "trust.json").add(one)
    again = Trust(tmp_path / "trust.json")
    assert again.covers(one)
    assert not again.covers(other)
    (tmp_path / "trust.json").write_text('{"broken"', encoding="utf-8")
    assert not again.covers(one)


def test_a_scenario_is_shown_before_it_is_run(studio: Client):
    sheet = studio.get("/api/scenario?model=car.py:QuarterCar&scenario=waves").json
    assert (sheet["name"], sheet["duration"]) == ("waves", 10.0)
    (road,) = sheet["inputs"]
    assert (road["path"], road["unit"]) == ("road.flow", "m/s")
    assert len(road["times"]) == len(road["values"]) <= 300
    assert max(road["values"]) == pytest.approx(0.2, rel=1e-3)


def test_what_is_wrong_with_a_model_is_told_with_its_elements(studio: Client):
    answer = studio.get("/api/model?id=car.py:Unfinished")
    assert answer.status == 422
    error = answer.json["error"]
    assert error["place"].startswith("car.py:")
    assert error["help"]


def test_an_exception_in_a_model_is_told_with_its_line(studio: Client):
    answer = studio.get("/api/model?id=trouble.py:Crash")
    assert answer.status == 500
    error = answer.json["error"]
    assert (error["code"], error["message"]) == ("studio/failed", "ValueError: no such thing")
    assert error["place"].startswith("trouble.py:")


@pytest.mark.parametrize(
    ("text", "status", "code"),
    [
        ("nothing", 404, "studio/model"),
        ("car.txt", 404, "studio/model"),
        ("gone.py:Rig", 404, "studio/file"),
        ("../secret.py", 403, "studio/outside"),
        ("../secret.py:x", 403, "studio/outside"),
        ("inner/../../secret.py", 403, "studio/outside"),
        ("/etc/passwd.json", 403, "studio/outside"),
        ("way_out.py", 403, "studio/outside"),
        ("way_out/secret.py", 403, "studio/outside"),
        ("..\\secret.py", 403, "studio/outside"),
        ("C:\\secret.py", 403, "studio/outside"),
        ("car.py\0", 404, "studio/model"),
        ("inner", 404, "studio/model"),
        ("", 400, "studio/request"),
    ],
)
def test_no_name_leads_out_of_the_folder(studio: Client, text: str, status: int, code: str):
    from urllib.parse import quote

    answer = studio.get(f"/api/model?id={quote(text)}")
    assert (answer.status, answer.code) == (status, code)
    order = studio.post("/api/runs", {"model": text or "gone.py"})
    assert order.status in (status, 400, 404)


def test_broken_and_oversized_documents_are_refused(studio: Client, folder: Path):
    whole = (folder / "inner" / "car.json").read_text(encoding="utf-8")
    broken = {
        "cut.json": whole[: len(whole) // 2].encode(),
        "deep.json": whole[:60].encode() + b"[" * 100_000,
    }
    for name, content in broken.items():
        (folder / "inner" / name).write_bytes(content)
    with (folder / "inner" / "large.json").open("wb") as stream:
        stream.write(whole[:200].encode())
        stream.truncate(LIMITS.file_bytes + 1)
    assert "inner/large.json" in [entry["id"] for entry in studio.get("/api/start").json["models"]]
    statuses = {name: studio.get(f"/api/model?id=inner/{name}") for name in (*broken, "large.json")}
    assert {name: answer.status for name, answer in statuses.items()} == {
        **dict.fromkeys(broken, 422),
        "deep.json": 413,
        "large.json": 413,
    }
    for name, answer in statuses.items():
        error = answer.json["error"]
        assert error["code"].startswith("document/")
        assert error["place"] == f"inner/{name}"
        assert error["help"]
    for name in statuses:
        (folder / "inner" / name).unlink()
    assert studio.get("/api/start").status == 200


def test_a_folder_of_runs_that_leads_elsewhere_is_refused(tmp_path: Path):
    (tmp_path / "served").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "served" / "propermodel-runs").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(StudioError, match="is no folder of its own"), listening(tmp_path / "served"):
        pass


def test_the_command_serves_the_folder_of_a_model(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.chdir(folder)
    assert served("car.py:QuarterCar") == (folder.resolve(), "car.py:QuarterCar")
    assert served("inner/car.json") == (folder.resolve(), "inner/car.json")
    assert served("inner") == ((folder / "inner").resolve(), "")
    assert served("half-car") == (folder.resolve(), "half-car")
    monkeypatch.chdir(tmp_path)
    assert served(f"{folder / 'car.py'}:QuarterCar") == (folder.resolve(), "car.py:QuarterCar")
    (tmp_path / "run.npz").write_bytes(b"")
    with pytest.raises(CommandError, match="is no folder and no model"):
        served("run.npz")
