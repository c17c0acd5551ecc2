"""Runs: made in processes of their own, told as they go on, stopped, failed, killed, and found again."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propermodel as pm
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import compile_model
from propermodel.simulation.simulate import simulate
from propermodel.studio.job import Job, JobState
from propermodel.studio.orders import RunOrder
from propermodel.studio.queue import Queue
from propermodel.studio.store import RUN_FILE, JobStore
from propermodel.studio.workers import Worker, Workers
from tests.studio.client import Client, Running

CAR = {"model": "car.py:QuarterCar", "step": 1e-3}
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)  # where there is none, this one ends a process at once
ENDLESS = {**CAR, "scenario": "trouble.py:endless"}


@contextmanager
def events(client: Client) -> Iterator[list[dict[str, Any]]]:
    """The jobs that are told while this lasts."""
    connection = http.client.HTTPConnection("127.0.0.1", client.server.door.port, timeout=60)
    connection.request("GET", "/api/events", headers={"Cookie": client.cookie})
    response = connection.getresponse()
    assert response.headers["Content-Type"].startswith("text/event-stream")
    assert response.readline() == b": the studio\n"
    told: list[dict[str, Any]] = []

    def listen() -> None:
        try:
            while line := response.readline():
                if line.startswith(b"data: "):
                    told.append(json.loads(line[6:]))
        except (OSError, ValueError, AttributeError):
            return  # closed below

    thread = threading.Thread(target=listen, daemon=True)
    thread.start()
    try:
        yield told
    finally:
        if connection.sock is not None:
            connection.sock.shutdown(2)
        thread.join(10)
        connection.close()


@pytest.fixture(scope="module")
def done(studio: Client) -> dict[str, Any]:
    """A run that is complete."""
    order = {**CAR, "settings": {"body_mass": "1.3 t"}, "outputs": ["body.flange.flow"]}
    with events(studio) as told:
        job = studio.post("/api/runs", order)
        assert job.status == 201
        over = studio.wait_until_over(job.json["id"])
        assert over["state"] == "complete", over
        deadline = time.monotonic() + 10
        while (not told or told[-1]["state"] != "complete") and time.monotonic() < deadline:
            time.sleep(0.02)
    states = [item["state"] for item in told if item["id"] == over["id"]]
    assert states[0] == "queued"
    assert states[-1] == "complete"
    assert sorted(states, key=["queued", "running", "complete"].index) == states
    return over


def test_a_run_is_that_of_the_command_line(studio: Client, folder: Path, done: dict[str, Any]):
    assert done["window"] == [0.0, 10.0]
    assert done["scenario"] == "waves"
    assert done["message"] == "completed to 10 s"
    assert len(done["spark"]) == 60
    assert {"steps", "wall time", "energy unaccounted", "body.flange.flow"} <= {
        fact["name"] for fact in done["summary"]
    }
    subject = load_subject(f"{folder / 'car.py'}:QuarterCar")
    scenario = pm.Scenario(stop=10.0, inputs=subject.scenario.inputs, parameters={pm.Path(("body_mass",)): 1300.0})
    expected = simulate(compile_model(subject.model), scenario, step=1e-3, record_every=0.01)
    stored = pm.load_trajectory(folder / "propermodel-runs" / done["id"] / RUN_FILE)
    assert stored.time[-1] == 10.0
    np.testing.assert_allclose(stored["body.flange.flow"], expected["body.flange.flow"], rtol=1e-12, atol=1e-15)


def test_signals_of_a_run(studio: Client, done: dict[str, Any]):
    found = {item["path"]: item for item in studio.get(f"/api/runs/{done['id']}/signals").json}
    assert found["tyre.spring.displacement"]["display"] == {"unit": "mm", "factor": 1e3}
    assert found["body.flange.flow"]["unit"] == "m/s"


def test_series_have_every_extreme(studio: Client, folder: Path, done: dict[str, Any]):
    stored = pm.load_trajectory(folder / "propermodel-runs" / done["id"] / RUN_FILE)
    names = ["body.flange.flow", "suspension.spring.port.power"]
    query = "&".join(f"signal={name}" for name in names)
    answer = studio.get(f"/api/runs/{done['id']}/series?{query}&from=2&to=12&count=40")
    times = np.frombuffer(answer.body, "<f8", 80)
    columns = np.frombuffer(answer.body, "<f4", offset=640).reshape(2, 40, 2)
    np.testing.assert_allclose(times[::2], np.linspace(2.0, 11.75, 40))
    np.testing.assert_allclose(times[1::2], times[::2] + 0.125)
    assert np.isnan(columns[:, 33:]).all()  # the run ends at 10 s, the beginning of an interval
    for name, column in zip(names, columns, strict=True):
        values = stored[name]
        for number in range(32):
            begin = 2.0 + 0.25 * number
            inside = (stored.time >= begin - 1e-9) & (stored.time <= begin + 0.25 + 1e-9)
            np.testing.assert_allclose(column[number].min(), values[inside].min(), rtol=1e-6)
            np.testing.assert_allclose(column[number].max(), values[inside].max(), rtol=1e-6)


def test_values_are_those_of_the_nearest_row(studio: Client, folder: Path, done: dict[str, Any]):
    stored = pm.load_trajectory(folder / "propermodel-runs" / done["id"] / RUN_FILE)
    for time_asked in (-1.0, 0.0, 1.2345, 3.0, 99.0):
        answer = studio.get(f"/api/runs/{done['id']}/values?signal=body.flange.flow&time={time_asked}").json
        row = int(np.argmin(np.abs(stored.time - time_asked)))
        assert answer == {"time": stored.time[row], "values": {"body.flange.flow": stored["body.flange.flow"][row]}}


def test_columns_as_a_file(studio: Client, folder: Path, done: dict[str, Any]):
    answer = studio.get(f"/api/runs/{done['id']}/csv?signal=body.flange.flow")
    assert 'filename="run_' in answer.headers["content-disposition"]
    lines = answer.body.decode().splitlines()
    stored = pm.load_trajectory(folder / "propermodel-runs" / done["id"] / RUN_FILE)
    assert lines[0] == "time_s,body.flange.flow [m/s]"
    assert len(lines) == 1 + len(stored.time)


@pytest.mark.parametrize(
    ("query", "status", "code"),
    [
        ("series", 400, "studio/request"),
        ("series?signal=nothing", 404, "studio/signal"),
        ("series?signal=body.flange.flow&from=nan", 400, "studio/request"),
        ("series?signal=body.flange.flow&from=3&to=2", 400, "studio/request"),
        ("series?signal=body.flange.flow&count=1e9", 400, "studio/request"),
        ("series?signal=body.flange.flow&count=x", 400, "studio/request"),
        ("values?signal=body.flange.flow&time=inf", 400, "studio/request"),
        ("csv?signal=nothing", 404, "studio/signal"),
    ],
)
def test_what_cannot_be_read_of_a_run(studio: Client, done: dict[str, Any], query: str, status: int, code: str):
    answer = studio.get(f"/api/runs/{done['id']}/{query}")
    assert (answer.status, answer.code) == (status, code)


@pytest.mark.parametrize("number", ["0", "999", "..", "1e3", "%2e%2e%2f1", "x" * 500])
def test_jobs_have_numbers(studio: Client, number: str):
    assert studio.get(f"/api/jobs/{number}").status == 404
    assert studio.get(f"/api/runs/{number}/signals").status == 404
    assert studio.post(f"/api/jobs/{number}/cancel", {}).status == 404
    assert studio.ask("DELETE", f"/api/jobs/{number}").status == 404


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"[]",
        b"{}",
        b'{"model": 3}',
        b'{"model": "car.py:QuarterCar", "model": "truck"}',
        b'{"model": "car.py:QuarterCar", "until": NaN}',
        b'{"model": "car.py:QuarterCar", "until": 1e999}',
        b'{"model": "car.py:QuarterCar", "more": 1}',
        b'{"model": "car.py:QuarterCar", "settings": {"a": 1}}',
        b"[" * 100_000,
        b'{"model": "\xff"}',
        b'{"model": "' + b"x" * 5000 + b'"}',
    ],
)
def test_broken_orders_are_refused(studio: Client, body: bytes):
    before = len(studio.get("/api/jobs").json)
    answer = studio.ask("POST", "/api/runs", body, {"Content-Type": "application/json"})
    assert 400 <= answer.status < 500
    assert answer.json["error"]["message"]
    assert len(studio.get("/api/jobs").json) == before


def test_an_order_that_does_not_fit_the_model_fails_and_says_why(studio: Client):
    order = {**CAR, "settings": {"body_mas": "1 t"}}
    job = studio.wait_until_over(studio.post("/api/runs", order).json["id"])
    assert job["state"] == "failed"
    assert job["message"] == "the model has no parameter 'body_mas' (did you mean 'body_mass'?)"


def test_a_run_that_fails_names_the_element(studio: Client):
    order = {"model": "trouble.py:Breaking", "scenario": "hard_pull"}
    job = studio.wait_until_over(studio.post("/api/runs", order).json["id"])
    assert (job["state"], job["elements"]) == ("failed", ["mass"])
    assert "mass.momentum is no longer a finite number" in job["message"]
    assert studio.get(f"/api/runs/{job['id']}/series?signal=mass.momentum").status == 200


def test_a_run_is_seen_while_it_goes_on_and_stops_when_it_is_told_to(studio: Client):
    with events(studio) as told:
        number = studio.post("/api/runs", ENDLESS).json["id"]
        queued = studio.post("/api/runs", ENDLESS).json["id"]
        studio.wait(number, lambda job: job["progress"] is not None and job["progress"]["time"] > 10.0)
        deadline = time.monotonic() + 20
        while (status := studio.get(f"/api/runs/{number}/values?signal=body.flange.flow&time=1e9").status) != 200:
            assert status == 409
            assert time.monotonic() < deadline
            time.sleep(0.1)
        assert studio.ask("DELETE", f"/api/jobs/{number}").code == "studio/busy"
        if studio.job(queued)["state"] == "queued":  # so it is where a single core is left for runs
            assert studio.post(f"/api/jobs/{queued}/cancel", {}).json["state"] == "cancelled"
        else:
            studio.post(f"/api/jobs/{queued}/cancel", {})
        begin = time.monotonic()
        studio.post(f"/api/jobs/{number}/cancel", {})
        job = studio.wait_until_over(number)
        assert time.monotonic() - begin < 3.0  # 2 s, and what a busy machine takes to tell
        assert job["state"] == "cancelled"
        studio.wait_until_over(queued)
    times = [item["progress"]["time"] for item in told if item["id"] == number and item["progress"]]
    assert times == sorted(times)
    end = studio.get(f"/api/runs/{number}/values?signal=body.flange.flow&time=1e9").json["time"]
    assert 0.0 < end <= job["progress"]["end"]
    assert studio.post(f"/api/jobs/{number}/cancel", {}).json["state"] == "cancelled"
    assert studio.ask("DELETE", f"/api/jobs/{number}").status == 204
    assert studio.get(f"/api/jobs/{number}").status == 404
    assert not (studio.folder / "propermodel-runs" / number).exists()


def test_a_killed_worker_loses_nothing_that_was_recorded(studio: Client):
    number = studio.post("/api/runs", ENDLESS).json["id"]
    studio.wait(number, lambda job: job["progress"] is not None)
    deadline = time.monotonic() + 20
    while studio.get(f"/api/runs/{number}/values?signal=body.flange.flow&time=0").status != 200:
        assert time.monotonic() < deadline
        time.sleep(0.1)
    os.kill(int((studio.folder / "process.txt").read_text(encoding="utf-8")), KILL)
    job = studio.wait_until_over(number)
    assert job["state"] == "lost"
    assert f"ended ({'signal' if os.name == 'posix' else 'code'} {int(KILL)})" in job["message"]
    assert studio.get(f"/api/runs/{number}/values?signal=body.flange.flow&time=1e9").json["time"] > 0.0
    assert studio.get("/api/start").status == 200


def test_a_job_without_a_process_is_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    async def order() -> Job:
        queue = Queue(tmp_path, Workers(tmp_path))
        job = queue.add_run(RunOrder(model="half-car"), "Half car")
        while not queue.get(job.id).state.is_over:
            await asyncio.sleep(0.01)
        await queue.close()
        return queue.get(job.id)

    async def refuse(root: Path) -> Worker:
        raise OSError("no more processes\x1b[2J")

    monkeypatch.setattr(Worker, "start", refuse)
    job = asyncio.run(order())
    assert (job.state, job.message) == (JobState.FAILED, "OSError: no more processes?[2J")


def test_another_server_finds_the_jobs_of_the_first(folder: Path, tmp_path: Path):
    root = tmp_path / "models"
    root.mkdir()
    (root / "car.json").write_bytes((folder / "inner" / "car.json").read_bytes())
    (root / "waves.json").write_bytes((folder / "inner" / "waves.json").read_bytes())
    order = {"model": "car.json", "scenario": "waves.json", "step": 1e-3, "until": 1e7}
    with Running(root, tmp_path / "trust.json") as client:
        number = client.post("/api/runs", order).json["id"]
        client.wait(number, lambda job: job["progress"] is not None)
        with pytest.raises(pm.ProperModelError, match="another studio serves this folder"):
            JobStore(root).open()
    state = root / "propermodel-runs" / number / "job.json"
    document = json.loads(state.read_text(encoding="utf-8"))
    assert document["state"] == "cancelled"  # the server has ended in good order
    state.write_text(json.dumps({**document, "state": "running"}), encoding="utf-8")  # now as if it had been killed
    (root / "propermodel-runs" / "7").mkdir()
    (root / "propermodel-runs" / "7" / "job.json").write_text("{broken", encoding="utf-8")
    # A folder of a stranger, whose files would lead elsewhere, is left alone.
    (root / "propermodel-runs" / "8").mkdir()
    (root / "propermodel-runs" / "8" / "job.json").write_text(json.dumps({**document, "state": "running"}))
    (root / "propermodel-runs" / "8" / "job.json.part").symlink_to(tmp_path / "mine.txt")
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    with Running(root, tmp_path / "trust.json") as client:
        (job,) = client.get("/api/jobs").json
        assert (job["id"], job["state"]) == (number, "lost")
        assert client.get(f"/api/runs/{number}/signals").status == 200
    assert (tmp_path / "mine.txt").read_text(encoding="utf-8") == "mine"


def test_many_requests_at_once(studio: Client, done: dict[str, Any]):
    path = f"/api/runs/{done['id']}/series?signal=body.flange.flow"
    paths = ["/api/start", path, "/api/model?id=car.py:QuarterCar", "/api/jobs", "/api/nowhere"]
    answers: list[tuple[str, int, bytes]] = []

    def ask(number: int) -> None:
        answer = studio.get(paths[number % len(paths)])
        answers.append((paths[number % len(paths)], answer.status, answer.body))

    threads = [threading.Thread(target=ask, args=[number]) for number in range(200)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert len(answers) == 200
    for path in paths:
        found = {(status, body) for asked, status, body in answers if asked == path}
        assert len(found) == 1
        assert {status for status, _ in found} == {404 if path == "/api/nowhere" else 200}
