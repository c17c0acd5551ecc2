"""Activity of what other tools have recorded, against closed forms and against runs."""

from __future__ import annotations

import json
import math
from pathlib import Path as FilePath

import numpy as np
import pytest
from typer.testing import CliRunner

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.recorded import RecordedElement, absolute_integral, rank_recorded
from propermodel.cli.app import app
from propermodel.diagnostics import Path, ReductionError
from tests.analysis.test_activity import damped
from tests.physics.systems import run

OSCILLATOR = {
    "mass": RecordedElement(ports=(("force [kN]", "speed"),), kind="I", units=(("speed", "mm/s"),)),
    "damper": RecordedElement(ports=(("drag", "speed"),), kind="R", units=(("speed", "mm/s"),)),
}


def oscillator(samples: int = 2001) -> dict[str, np.ndarray]:
    """Ten periods of a second: a mass of 2 kg and a damper of 3 N.s/m that move with sin(2 pi t)."""
    time = np.linspace(0.0, 10.0, samples)
    speed, force = np.sin(2 * math.pi * time), 2.0 * 2 * math.pi * np.cos(2 * math.pi * time)
    return {"time_s": time, "speed": 1e3 * speed, "force [kN]": 1e-3 * force, "drag [N]": 3.0 * speed}


@pytest.mark.parametrize(
    "coefficients",
    [
        (1.0, 0.0, 0.0),
        (1.0, -2.0, 0.0),
        (0.0, 0.0, 1.0),
        (0.1, -1.0, 1.3),
        (-1.0, 4.0, -3.0),
        (0.0, 0.0, 0.0),
        (1, 2, 3),
    ],
)
def test_the_integral_of_a_parabola_without_sign_is_exact(coefficients):
    s = np.linspace(0.0, 1.0, 200_001)
    a, b, c = coefficients
    expected = np.trapezoid(np.abs(a + b * s + c * s * s), s)
    found = absolute_integral(*(np.array([float(k)]) for k in coefficients))
    assert found[0] == pytest.approx(expected, rel=1e-8, abs=1e-12)


def test_sines_have_their_known_activities():
    ranking = rank_recorded(oscillator(), OSCILLATOR)
    # A period has 2 I v^2 for the mass, and pi R v^2 / w for the damper; chords of h lose (w h)^2 / 6 of them.
    assert ranking.row(Path(("mass",))).activity == pytest.approx(10 * 2 * 2.0, rel=1.7e-4)
    assert ranking.row(Path(("damper",))).activity == pytest.approx(10 * 3.0 / 2.0, rel=1.7e-4)
    assert ranking.rows[0].kind == "I"
    assert ranking.notes == ()


def test_every_index_tells_how_it_depends_on_the_samples():
    elements = {**OSCILLATOR, "fast": RecordedElement(ports=(("fast", "fast_speed"),))}

    def ranking(samples):
        columns = oscillator(samples)
        turns = 12 * math.pi * columns["time_s"]
        return rank_recorded(columns | {"fast": np.cos(turns), "fast_speed": np.sin(turns)}, elements)

    coarse, fine = ranking(1001), ranking(16001)
    for row in coarse.rows:
        # Of second order: half the samples are wrong by four times as much, so they move by three times the error.
        true = abs(row.index - fine.row(row.path).index) * 100.0
        assert 2.0 * true <= row.change_points <= 4.0 * true


def test_samples_that_are_too_far_apart_are_named():
    (first, second) = rank_recorded(oscillator(61), OSCILLATOR).notes
    assert first.startswith("the samples are too far apart for mass: with every second one its activity changes by")
    assert "damper" in second


def test_windows_are_ranked_by_themselves():
    ranking = rank_recorded(oscillator(), OSCILLATOR, windows="2.5 s")
    assert len(ranking.parts) == 4
    for row in ranking.rows:
        assert sum(part.activities[row.path] for part in ranking.parts) == pytest.approx(row.activity, rel=1e-9)


def test_ports_count_together_and_each_alone():
    columns = oscillator()
    columns["back"] = -columns["drag [N]"]
    both = RecordedElement(ports=(("drag", "speed"), ("back", "speed")), units=(("speed", "mm/s"),))
    row = rank_recorded(columns, {**OSCILLATOR, "both": both}).row(Path(("both",)))
    assert row.activity == pytest.approx(0.0, abs=1e-9)
    assert row.sum_over_ports == pytest.approx(2 * 15.0, rel=1.7e-4)


def recorded_run(folder: FilePath, ending: str) -> tuple[FilePath, dict[str, RecordedElement]]:
    """A run of this package, written to a file, and what names its elements."""
    r = run(damped(), 3.0, step=1e-3, every=2e-3)
    file = folder / f"run.{ending}"
    if ending == "csv":
        r.to_csv(file)
    elif ending == "parquet":
        r.to_pandas().to_parquet(file)
    else:
        r.to_xarray().to_netcdf(file, engine="scipy")
    ports = {"mass": "mass.flange", "spring": "spring.port", "damper": "damper.port"}
    return file, {e: RecordedElement(ports=((f"{p}.effort", f"{p}.flow"),)) for e, p in ports.items()}


@pytest.mark.parametrize(("ending", "time"), [("csv", "time_s"), ("parquet", "time_s"), ("nc", "time")])
def test_files_of_every_kind_rank_as_the_run_that_was_recorded(tmp_path, ending, time):
    file, elements = recorded_run(tmp_path, ending)
    expected = rank_activity(run(damped(), 3.0, step=1e-3))
    ranking = rank_recorded(file, elements, time=time)
    assert [row.path for row in ranking.rows] == [row.path for row in expected.rows]
    assert [row.index for row in ranking.rows] == pytest.approx([row.index for row in expected.rows], abs=1e-4)


def test_what_does_not_fit_is_told_at_once():
    columns = oscillator()
    columns["drag [N]"][3] = math.nan
    wrong = RecordedElement(ports=(("force", "drag"), ("forse", "speed")))
    with pytest.raises(ReductionError) as caught:
        rank_recorded(columns, {**OSCILLATOR, "wrong": wrong})
    text = str(caught.value)
    assert "the column 'drag' is no number in row 4" in text
    assert "'force' in kN times 'drag' in N is no power" in text
    assert "there is no column 'forse'" in text


def test_time_must_grow():
    columns = oscillator()
    columns["time_s"] = columns["time_s"][::-1]
    with pytest.raises(ReductionError, match="the column time_s does not grow"):
        rank_recorded(columns, OSCILLATOR)


def test_the_command_ranks_a_recording(tmp_path):
    file, _ = recorded_run(tmp_path, "csv")
    names = {"mass": "mass.flange", "spring": "spring.port", "damper": "damper.port"}
    lines = [f'[elements.{e}]\nkind = "X"\neffort = "{p}.effort"\nflow = "{p}.flow"\n' for e, p in names.items()]
    map_file = tmp_path / "map.toml"
    map_file.write_text("\n".join(lines), encoding="utf-8")
    done = CliRunner().invoke(app, ["rank", str(file), "--map", str(map_file), "--windows", "3", "--json"])
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["scenario"] == "run"
    assert {element["path"] for element in report["elements"]} == set(names)
    assert len(report["parts"]) == 3
    map_file.write_text("[elements.mass]\n", encoding="utf-8")
    refused = CliRunner().invoke(app, ["rank", str(file), "--map", str(map_file)])
    assert "elements.mass does not name its columns" in refused.output
