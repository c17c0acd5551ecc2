"""The study of a reduction, and what it writes."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from propermodel.catalogue.finding import load_subject
from propermodel.compiler import Method
from propermodel.diagnostics import ProperModelError, parse_path
from propermodel.modelling.documents import read_model, read_scenario
from propermodel.report.files import write_study
from propermodel.report.options import StudyOptions
from propermodel.report.panels import Panel, Series
from propermodel.report.study import ReductionStudy, run_study
from propermodel.report.summary import summarise
from propermodel.simulation.display_units import display_for

MODEL = f"{Path(__file__).parents[1] / 'cli' / 'quarter_car.py'}:QuarterCar"
OUTPUT = parse_path("body.flange.flow")


@pytest.fixture(scope="module")
def study() -> ReductionStudy:
    subject = load_subject(MODEL)
    options = StudyOptions(
        threshold=0.97,
        tolerance=0.1,
        outputs=(OUTPUT,),
        totals={"travel_m": parse_path("suspension.spring.displacement")},
        panels=(Panel("Road", (Series("road.flow"),)), Panel("Body", (Series("body.flange.flow", "speed"),))),
        method=Method.RK4,
        step=1e-3,
    )
    return run_study(subject.model, subject.scenario, options)


@pytest.fixture(scope="module")
def folder(study: ReductionStudy, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study")
    write_study(study, out)
    return out


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


def test_the_summary_holds_what_is_published(summary: dict):
    assert (summary["format"], summary["version"]) == ("propermodel-summary", 1)
    promised = {
        "energy_elements",
        "threshold",
        "kept_by_threshold",
        "kept",
        "removed",
        "kept_activity",
        "elements",
        "states",
        "totals",
        "output_errors",
        "energy_balance_residual",
        "discretisation_check_points",
        "method",
        "step_s",
        "jacobian_every",
        "step_tolerance",
        "wall_s",
        "speedup",
        "speedup_best_steps",
        "versions",
    }
    assert promised <= set(summary)


def test_the_summary_is_consistent(summary: dict):
    elements = summary["elements"]
    decisions = [element["decision"] for element in elements]
    assert summary["kept"] + summary["removed"] == summary["energy_elements"] == len(elements) == 6
    assert decisions.count("removed") == summary["removed"]
    assert sum(element["index"] for element in elements) == pytest.approx(1.0)
    assert elements[-1]["cumulative"] == pytest.approx(1.0)
    activities = [element["activity_J"] for element in elements]
    assert activities == sorted(activities, reverse=True)
    kept = sum(element["index"] for element in elements if element["decision"] != "removed")
    assert summary["kept_activity"] == pytest.approx(kept)
    before = elements[summary["kept_by_threshold"] - 2]["cumulative"]
    assert before < summary["threshold"] <= elements[summary["kept_by_threshold"] - 1]["cumulative"]
    assert all(element["removal"] for element in elements if element["decision"] == "removed")
    assert summary["states"] == {"full": 4, "reduced": 3}


def test_energy_balances_close(summary: dict):
    assert summary["energy_balance_residual"]["full"] < 1e-6
    assert summary["energy_balance_residual"]["reduced"] < 1e-6


def test_totals_are_changes_over_the_run(study: ReductionStudy, summary: dict):
    total = summary["totals"]["travel_m"]
    column = study.full["suspension.spring.displacement"]
    assert total["full"] == pytest.approx(column[-1] - column[0])
    assert total["error_percent"] == pytest.approx((total["reduced"] / total["full"] - 1.0) * 100.0)
    assert "fuel_kg" not in summary


def test_output_errors_are_those_of_the_columns(study: ReductionStudy, summary: dict):
    full, reduced = study.full[OUTPUT], study.reduced[OUTPUT]
    error = summary["output_errors"]["body.flange.flow"]
    square = np.trapezoid((reduced - full) ** 2, study.full.time) / np.ptp(study.full.time)
    assert error["rms"] == pytest.approx(np.sqrt(square) / np.ptp(full))
    assert error["final_full"] == full[-1]


def test_speed_is_measured_on_equal_terms(study: ReductionStudy):
    speed, best = study.speed, study.best_steps
    assert speed is not None
    assert speed.full.step == speed.reduced.step == study.options.step
    assert speed.full.steps == speed.reduced.steps
    assert len(speed.full.runs) == len(speed.reduced.runs) == 5
    assert speed.window == (0.0, 10.0)
    assert best is not None
    assert best.full_step is not None
    assert best.reduced_step is not None
    assert best.full_step >= study.options.step
    assert best.reduced_step >= study.options.step


def test_the_ranking_as_csv_has_a_row_for_each_element(folder: Path, summary: dict):
    with (folder / "ranking.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["path"] for row in rows] == [element["path"] for element in summary["elements"]]
    assert [row["decision"] for row in rows] == [element["decision"] for element in summary["elements"]]


def test_the_outputs_as_csv_hold_both_models(folder: Path, study: ReductionStudy):
    header, *rows = list(csv.reader((folder / "outputs.csv").read_text().splitlines()))
    assert header == ["time_s", "body.flange.flow [m/s] full", "body.flange.flow [m/s] reduced"]
    assert len(rows) == len(study.full.time)
    assert float(rows[-1][1]) == pytest.approx(study.full[OUTPUT][-1])


def test_models_and_scenarios_are_kept_as_documents(folder: Path, study: ReductionStudy):
    assert read_model(folder / "full_model.json") == study.full.compiled.model
    assert read_model(folder / "reduced_model.json") == study.reduced.compiled.model
    assert read_scenario(folder / "reduced_scenario.json") == study.reduced.scenario


@pytest.mark.parametrize("name", ["mission.png", "activity.png", "outputs.png"])
def test_figures_are_pictures(folder: Path, name: str):
    from matplotlib.image import imread

    picture = imread(folder / name)
    assert picture.shape[0] > 300
    assert picture.shape[1] > 1000
    assert picture.min() < 0.3  # something dark is drawn


def test_figures_leave_the_settings_of_matplotlib_alone(study: ReductionStudy, tmp_path: Path):
    import matplotlib

    from propermodel.report.figures import write_figures

    before = dict(matplotlib.rcParams)
    write_figures(study, tmp_path)
    assert dict(matplotlib.rcParams) == before


def test_without_outputs_the_most_active_storage_is_compared():
    subject = load_subject(MODEL)
    study = run_study(subject.model, subject.scenario, StudyOptions(step=1e-3, speed_repeats=0))
    assert study.speed is None
    assert [str(path) for path in study.compared][:2] == ["suspension.spring.port.effort", "body.flange.flow"]
    assert summarise(study)["speedup"] is None


def test_panels_are_checked_before_the_run():
    subject = load_subject(MODEL)
    options = StudyOptions(panels=(Panel("Body", (Series("body.flange.flw"),)),))
    with pytest.raises(ProperModelError, match=r"did you mean 'body.flange.flow'"):
        run_study(subject.model, subject.scenario, options)


def test_readers_get_the_units_they_are_used_to():
    assert display_for("Pa", 2e7).unit == "bar"
    assert 2e7 * display_for("Pa", 2e7).factor == pytest.approx(200.0)
    assert display_for("rad/s", 200.0).unit == "rpm"
    assert 100.0 * display_for("rad/s", 200.0).factor == pytest.approx(954.93, abs=0.01)
    assert display_for("m/s", 20.0).factor == 3.6
    assert display_for("m/s", 0.2).unit == "m/s"
    assert display_for("kg", 3.0).unit == "kg"
