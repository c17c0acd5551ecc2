"""What is made of a run: activity, histories, reductions, comparisons, and the Python for all that."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propermodel as pm
from propermodel.analysis.activity import bond_activities
from propermodel.analysis.comparison import Feature
from propermodel.drawing.depict import depict
from propermodel.reduction.certificate_files import read_certificate
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.reopening import reopened
from propermodel.studio.store import RUN_FILE
from tests.studio.client import Client
from tests.studio.conftest import ROOT
from tests.studio.typescript import misfits, types_in

Json = dict[str, Any]


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind)


@pytest.fixture(scope="module")
def full(studio: Client) -> Json:
    """A complete run of the full model."""
    order = {"model": "car.py:QuarterCar", "step": 1e-3, "outputs": ["body.flange.flow"]}
    job = studio.wait_until_over(studio.post("/api/runs", order).json["id"])
    assert job["state"] == "complete"
    return job


@pytest.fixture(scope="module")
def reduction(studio: Client, full: Json) -> Json:
    """A reduction of it in which one row is locked."""
    order = {"run": full["id"], "threshold": 0.9, "from": 1.03, "to": 9.0, "keep": ["wheel"]}
    answer = studio.post("/api/reductions", order)
    assert answer.status == 201
    job = studio.wait_until_over(answer.json["id"])
    assert job["state"] == "complete", job
    assert (job["kind"], job["run"]) == ("reduction", full["id"])
    return job


@pytest.fixture(scope="module")
def run(folder: Path, full: Json) -> pm.Trajectory:
    return reopened(pm.load_trajectory(folder / "propermodel-runs" / full["id"] / RUN_FILE))


def test_answers_have_the_shape_that_the_pages_declare(studio: Client, full: Json, reduction: Json):
    web = ROOT / "web" / "src"
    known = types_in(web / "graph" / "picture.ts", web / "views" / "data.ts", web / "studio" / "api.ts")
    a, b = full["id"], reduction["id"]
    answers = {
        "/api/start": "Start",
        "/api/model?id=car.py:QuarterCar": "ModelSheet",
        "/api/scenario?model=car.py:QuarterCar&scenario=waves": "ScenarioSheet",
        f"/api/jobs/{a}": "Job",
        f"/api/jobs/{b}": "Job",
        f"/api/runs/{a}/activity": "ActivityData",
        f"/api/runs/{a}/history?row=wheel": "RowHistory",
        f"/api/reductions/{b}": "ReductionData",
        f"/api/compare?a={a}&b={b}": "ComparisonData",
    }
    for path, name in answers.items():
        assert misfits(studio.get(path).json, ("name", name, ()), known, path) == []
    (first, *_) = studio.get(f"/api/runs/{a}/signals").json
    assert misfits(first, ("name", "SignalEntry", ()), known) == []
    assert misfits(studio.get("/api/jobs/99").json["error"], ("name", "Fault", ()), known) == []
    assert misfits({**first, "unit": 3}, ("name", "SignalEntry", ()), known) == [".unit: 3 is no string"]
    assert misfits({"path": "x", "unit": ""}, ("name", "SignalEntry", ()), known) == [": there is no 'display'"]


def test_activity_is_that_of_the_ranking(studio: Client, full: Json, run: pm.Trajectory):
    found = studio.get(f"/api/runs/{full['id']}/activity").json
    ranking = pm.rank_activity(run)
    assert [row["path"] for row in found["rows"]] == [str(row.path) for row in ranking.rows]
    assert [row["activity"] for row in found["rows"]] == [row.activity for row in ranking.rows]
    assert {row["verdict"] for row in found["rows"]} == {"kept"}
    assert found["totalActivity"] == ranking.total
    assert found["picture"] == depict(run.compiled, ranking, bond_activities(run)).document()
    assert found["balances"]["full"]["residual"] == pm.energy_balance(run).relative_residual
    times = numbers(found["windows"]["times"], "<f8")
    begin, end = len(times) // 4, len(times) // 2
    window = pm.rank_activity(run, window=(float(times[begin]), float(times[end])))
    for row in window.rows:
        column = numbers(found["windows"]["rows"][str(row.path)], "<f8")
        assert column[end] - column[begin] == pytest.approx(row.activity, rel=1e-9)


def test_a_history_adds_up_to_the_activity(studio: Client, full: Json, run: pm.Trajectory):
    found = studio.get(f"/api/runs/{full['id']}/history?row=suspension.spring").json
    (item,) = found["items"]
    assert (item["bond"], item["units"]) == ("suspension.spring.port", ["N", "m/s"])
    times, power = numbers(found["times"], "<f4"), numbers(item["power"], "<f4")
    assert len(times) == len(power)
    activity = np.trapezoid(np.abs(power), times)
    assert activity == pytest.approx(run.activity("suspension.spring.port"), rel=0.02)
    assert studio.get(f"/api/runs/{full['id']}/history?row=nothing").code == "studio/row"


def test_a_reduction_is_that_of_the_command_line(studio: Client, folder: Path, reduction: Json, run: pm.Trajectory):
    page = studio.get(f"/api/reductions/{reduction['id']}").json
    times = run.integral_times
    begin = float(times[np.argmin(np.abs(times - 1.03))])
    ranking = pm.rank_activity(run, window=(begin, 9.0))
    plan = plan_reduction(run.compiled, run, ranking, threshold=0.9, protected=["body.flange.flow"], keep=["wheel"])
    assert {row["path"]: row["verdict"] for row in page["rows"]} == {
        str(d.row.path): d.verdict.value for d in plan.decisions
    }
    assert plan.removed
    wheel = next(row for row in page["rows"] if row["path"] == "wheel")
    assert (wheel["verdict"], wheel["reason"]) == ("kept", "locked: it was to be kept")
    certified = read_certificate(folder / "propermodel-runs" / reduction["id"] / "certificate.json")
    assert certified.certificate.removals == plan.removals
    assert f"between {begin:g} and 9 s" in certified.certificate.method
    error = certified.certificate.scenarios[0].outputs[0]
    (output,) = page["outputs"]
    assert output["path"] == "body.flange.flow"
    assert output["rms"] == pytest.approx(error.errors[Feature.RMS], rel=1e-9)
    assert reduction["summary"][0]["value"] == f"{len(plan.removed)} of {len(plan.decisions)}"
    assert studio.get(f"/api/runs/{reduction['id']}/series?signal=body.flange.flow&count=10").status == 200


def test_a_report_can_be_taken_along(studio: Client, reduction: Json):
    answer = studio.get(f"/api/reductions/{reduction['id']}/report.html")
    assert answer.headers["content-disposition"] == f'attachment; filename="reduction_{reduction["id"]}.html"'
    assert answer.body.startswith(b"<!doctype html>")
    assert b"quarter_car" in answer.body


def test_two_runs_are_compared(studio: Client, full: Json, reduction: Json):
    found = studio.get(f"/api/compare?a={full['id']}&b={reduction['id']}").json
    page = studio.get(f"/api/reductions/{reduction['id']}").json
    assert [row["path"] for row in found["outputs"]] == ["body.flange.flow"]
    assert found["outputs"][0]["rms"] == pytest.approx(page["outputs"][0]["rms"], rel=1e-9)
    assert found["balances"]["reduced"]["supplied"] == pytest.approx(page["balances"]["reduced"]["supplied"], rel=1e-9)
    facts = {fact["name"]: fact["value"] for fact in found["facts"]}
    assert "→" in facts["energy elements"]
    gone = [node["path"] for node in found["pictures"]["b"]["nodes"] if "gone" in node]
    assert gone
    assert not [node for node in found["pictures"]["a"]["nodes"] if "gone" in node]
    difference = f"/api/compare/series?a={full['id']}&b={reduction['id']}&signal=body.flange.flow&count=20"
    columns = np.frombuffer(studio.get(difference).body, "<f4", offset=320)
    assert 0.0 < np.abs(columns).max() < 0.1
    same = studio.get(f"/api/compare/series?a={full['id']}&b={full['id']}&signal=body.flange.flow&count=20")
    assert not np.frombuffer(same.body, "<f4", offset=320).any()


def test_the_python_for_a_reduction_does_the_same(
    studio: Client, folder: Path, reduction: Json, monkeypatch: pytest.MonkeyPatch
):
    text = studio.get(f"/api/python?job={reduction['id']}").body.decode()
    monkeypatch.chdir(folder)
    script = folder.parent / "script.py"
    script.write_text(text, encoding="utf-8")
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        made = runpy.run_path(str(script))
    assert "body.flange.flow" in printed.getvalue()
    certificate = json.loads(
        (folder / "propermodel-runs" / reduction["id"] / "certificate.json").read_text(encoding="utf-8")
    )
    assert len(made["reduction"].removals) == len(certificate["removals"])
    page = studio.get(f"/api/reductions/{reduction['id']}").json
    found = pm.compare(made["run"], made["again"], ["body.flange.flow"]).outputs[0]
    assert found.rms == pytest.approx(page["outputs"][0]["rms"], rel=1e-9)


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("signal=body.flange.flow&signal=wheel.flange.flow", ["run.plot(['body.flange.flow', 'wheel.flange.flow'])"]),
        ("activity=yes&threshold=0.9", ["pm.rank_activity(run)", "ranking.kept_by(0.9)"]),
    ],
)
def test_the_python_for_what_a_page_shows_of_a_run(studio: Client, full: Json, query: str, words: list[str]):
    text = studio.get(f"/api/python?job={full['id']}&{query}").body.decode()
    compile(text, "script", "exec")
    for word in words:
        assert word in text


def test_the_python_for_a_run_that_is_about_to_be_ordered(studio: Client):
    words = "scenario=waves&until=5&method=rk4&step=0.001&set=body_mass=1.3 t&set=wheel.mass=70 kg"
    text = studio.get(f"/api/python?model=car.py:QuarterCar&{words}".replace(" ", "%20")).body.decode()
    assert "subject = load_subject('car.py:QuarterCar', 'waves')" in text
    assert "stop=5.0, parameters={**scenario.parameters, 'body_mass': 1300.0, 'wheel.mass': 70.0}" in text
    assert "method=pm.Method.RK4" in text
    assert studio.get("/api/python?model=car.py:QuarterCar&until=x").code == "studio/request"


@pytest.mark.parametrize(
    ("query", "words", "prints"),
    [
        ("model=half-car", ["from propermodel.library.vehicle.half_car import HalfCar", "rough_road()"], "states"),
        (
            "model=inner/car.json&scenario=inner/waves.json",
            ["pm.read_model('inner/car.json')", "pm.read_scenario("],
            "completed to 10 s",
        ),
    ],
)
def test_the_python_that_opens_a_model(
    studio: Client, folder: Path, monkeypatch: pytest.MonkeyPatch, query: str, words: list[str], prints: str
):
    text = studio.get(f"/api/python?{query}").body.decode()
    for word in words:
        assert word in text
    monkeypatch.chdir(folder)
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(text, "script", "exec"), {})
    assert prints in printed.getvalue()


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"run": "99"}, "studio/job"),
        ({"threshold": "much"}, "document/content"),
        ({"keep": "wheel"}, "document/content"),
    ],
)
def test_reductions_that_cannot_be_ordered(studio: Client, full: Json, changes: Json, code: str):
    answer = studio.post("/api/reductions", {"run": full["id"], "threshold": 0.9, **changes})
    assert 400 <= answer.status < 500
    assert answer.code == code


def test_a_reduction_that_fails_says_why(studio: Client, full: Json, reduction: Json):
    order = {"run": full["id"], "threshold": 0.9, "keep": ["wheal"]}
    job = studio.wait_until_over(studio.post("/api/reductions", order).json["id"])
    assert job["state"] == "failed"
    assert "no row 'wheal' (did you mean 'wheel'?)" in job["message"]
    assert studio.get(f"/api/reductions/{job['id']}").code == "studio/no-reduction"
    again = studio.post("/api/reductions", {"run": reduction["id"], "threshold": 0.9})
    assert again.code == "studio/incomplete"
