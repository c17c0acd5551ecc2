"""The commands, as a user types them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from propermodel.catalogue.named import NAMED_MODELS
from propermodel.cli.app import app
from propermodel.cli.options import MethodName
from propermodel.cli.progress import ProgressBars
from propermodel.compiler import Method, compile_model
from propermodel.diagnostics import parse_path
from propermodel.modelling.documents import read_model, write_model, write_scenario
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import Progress
from propermodel.simulation.storage import load_trajectory

FILE = Path(__file__).with_name("quarter_car.py")
MODEL = f"{FILE}:QuarterCar"


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def succeed(*arguments: object) -> str:
    done = invoke(*arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


def fail(code: int, *arguments: object) -> str:
    done = invoke(*arguments)
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    return done.stderr


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("study")
    options = ["--threshold", "0.97", "--junction-tolerance", "0.1", "--step", "0.001", "--output", "body.flange.flow"]
    return out, succeed("reduce", MODEL, "--out", out, *options)


# -- reduce ---------------------------------------------------------------------------------------------


def test_reduce_prints_decisions_errors_and_files(reduced: tuple[Path, str]):
    out, printed = reduced
    lines = printed.splitlines()
    wheel = next(line for line in lines if line.startswith("wheel "))
    assert "removed" in wheel
    assert "no effort" in wheel
    assert any(line.startswith("body.flange.flow ") and line.endswith("m/s") for line in lines)
    assert "4 states become 3" in lines
    assert "6 energy elements; the threshold keeps 4" in lines
    for name in ("activity.png", "outputs.png", "summary.json", "reduced_model.json"):
        assert (out / name).is_file()
        assert (out / name).as_posix() in printed
    assert all(line == line.rstrip() for line in lines)


def test_the_reduced_model_can_be_run_and_shown_again(reduced: tuple[Path, str]):
    out, _ = reduced
    assert len(read_model(out / "reduced_model.json").removals) == 2
    shown = succeed("show", out / "reduced_model.json")
    assert "no effort at wheel.flange" in shown
    report = json.loads(
        succeed("run", out / "reduced_model.json", "--scenario", out / "reduced_scenario.json", "--json")
    )
    assert report["status"] == "completed"
    assert report["time_s"] == 10.0
    assert set(report["outputs"]) == {
        "body.momentum",
        "suspension.spring.displacement",
        "tyre.spring.displacement",
    }


def test_starts_of_removed_storage_are_left_out_of_the_reduced_scenario(tmp_path: Path):
    arguments = ["--scenario", "bouncing", "--threshold", "0.5", "--junction-tolerance", "1", "--no-speed", "--json"]
    summary = json.loads(succeed("reduce", MODEL, "--out", tmp_path, *arguments, "--step", "0.001"))
    gone = {element["path"] for element in summary["elements"] if element["decision"] == "removed"}
    scenario = json.loads((tmp_path / "reduced_scenario.json").read_text())
    assert ("wheel" in gone) == (not scenario["initial"])


def test_the_smallest_model_within_tolerances(tmp_path: Path):
    options = ["--tolerance", "body.flange.flow=5%", "--step", "0.001", "--until", "4", "--out", tmp_path]
    report = json.loads(succeed("reduce", MODEL, *options, "--json"))
    assert report == json.loads((tmp_path / "search.json").read_text())
    smallest = report["candidates"][report["smallest"]]
    assert smallest["verdict"] == "within the tolerances"
    assert smallest["errors"]["waves"]["body.flange.flow"]["rms"] <= 0.05
    assert len(read_model(tmp_path / "reduced_model.json").removals) >= 1
    assert "rows  states" in succeed("reduce", MODEL, *options)


def test_both_ways_to_reduce_write_a_certificate_that_holds(reduced: tuple[Path, str], tmp_path: Path):
    assert "the certificate holds" in succeed("verify", reduced[0] / "certificate.json")
    options = ["--tolerance", "body.flange.flow=5%", "--step", "0.001", "--until", "4", "--out", tmp_path]
    assert "certificate.json" in succeed("reduce", MODEL, *options)
    report = json.loads(succeed("verify", tmp_path / "certificate.json", "--json"))
    assert report["holds"]
    assert report["error_over_tolerance"] <= 1.0
    scenario = tmp_path / "scenario.json"
    assert succeed("verify", tmp_path / "certificate.json", "--model", MODEL, "--scenario", scenario)


def test_ranges_of_parameters_stand_in_the_certificate(tmp_path: Path):
    options = ["--tolerance", "body.flange.flow=9%", "--step", "0.001", "--until", "2", "--out", tmp_path]
    ranges = ["--range", "body.mass=5%", "--range", "wheel.mass=0.07 t..90kg"]
    succeed("reduce", MODEL, *options, *ranges)
    found = json.loads((tmp_path / "certificate.json").read_text())["ranges"]["ranges"]
    assert [(r["parameter"], r["low"], r["high"]) for r in found][1] == ("wheel.mass", 70.0, 90.0)
    assert "is no range of a parameter" in fail(2, "reduce", MODEL, *options, "--range", "body.mass=5")
    assert "no parameter 'body.mas'" in fail(2, "reduce", MODEL, *options, "--range", "body.mas=5%")
    assert "there are none" in fail(2, "reduce", MODEL, "--out", tmp_path, *ranges)


def test_a_certificate_that_does_not_hold_ends_with_1(reduced: tuple[Path, str], tmp_path: Path):
    for file in reduced[0].glob("*.json"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    certificate = tmp_path / "certificate.json"
    document = json.loads(certificate.read_text())
    document["reduced"]["states"] -= 1
    certificate.write_text(json.dumps(document))
    done = invoke("verify", certificate)
    assert done.exit_code == 1
    assert "states of the reduced model" in done.stdout
    assert "does NOT hold" in done.stdout
    assert "not the file that was certified" in fail_after_change(tmp_path / "scenario.json", certificate)


def fail_after_change(file: Path, certificate: Path) -> str:
    file.write_text(file.read_text() + " ")
    return fail(2, "verify", certificate)


def test_tolerances_name_features(tmp_path: Path):
    options = ["--step", "0.001", "--until", "4", "--out", tmp_path, "--json"]
    given = ["--tolerance", "body.flange.flow=2%, largest:4%", "--tolerance", "body.flange.flow=peak-time:0.1"]
    report = json.loads(succeed("reduce", MODEL, *given, *options))
    assert report["tolerances"] == {"body.flange.flow": {"rms": 0.02, "largest": 0.04, "peak_time": 0.1}}
    errors = report["candidates"][report["smallest"]]["errors"]["waves"]["body.flange.flow"]
    assert errors["largest"] <= 0.04
    assert errors["settling"] == "it still moves when the run ends"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("body.flange.flow=finale:1%", "did you mean 'final'?"),
        ("body.flange.flow=1%,rms:2%", "the rms of 'body.flange.flow' is given twice"),
        ("body.flange.flow=-1%", "is no output with a tolerance"),
        ("body.flange.flow=final:", "is no output with a tolerance"),
    ],
)
def test_features_that_do_not_exist_are_refused(tmp_path: Path, text: str, message: str):
    assert message in fail(2, "reduce", MODEL, "--out", tmp_path, "--tolerance", text)


def test_tolerances_that_say_nothing_are_refused(tmp_path: Path):
    assert "'body.flange.flow' is no output with a tolerance" in fail(
        2, "reduce", MODEL, "--out", tmp_path, "--tolerance", "body.flange.flow"
    )
    assert "observables end with 'flow'" in fail(2, "reduce", MODEL, "--out", tmp_path, "--tolerance", "flow=1%")


def test_settings_reach_both_models(tmp_path: Path):
    arguments = ["--set", "body_mass=0.9 t", "--output", "body.flange.flow", "--no-speed", "--step", "0.001"]
    succeed("reduce", MODEL, "--out", tmp_path, *arguments, "--json")
    for name in ("scenario.json", "reduced_scenario.json"):
        assert json.loads((tmp_path / name).read_text())["parameters"] == {"body_mass": 900.0}


def test_json_is_the_summary_file(tmp_path: Path):
    printed = succeed("reduce", MODEL, "--out", tmp_path, "--until", "1", "--no-speed", "--step", "0.001", "--json")
    assert json.loads(printed) == json.loads((tmp_path / "summary.json").read_text())


# -- other commands -------------------------------------------------------------------------------------


def test_compare_methods_draws_size_against_error(tmp_path: Path):
    printed = succeed(
        "compare-methods", MODEL, "--until", "2", "--output", "body.flange.flow", "--step", "0.001", "--out", tmp_path
    )
    assert "predicted and verified" in printed
    assert "balanced truncation" in printed
    assert "methods.png  size against error, all methods" in printed
    assert (tmp_path / "methods.csv").read_text().startswith("method,rows,states,error_rms_over_range,")
    assert "no outputs were given" in fail(2, "compare-methods", MODEL, "--out", tmp_path)


def test_run_prints_a_summary_and_writes_what_was_recorded(tmp_path: Path):
    printed = succeed("run", MODEL, "--until", "2", "--method", "rk4", "--step", "0.002", "--out", tmp_path)
    assert printed.startswith("quarter_car, scenario waves: completed to 2 s; 1000 steps of 0.002 s (rk4)")
    assert "energy balance: sources" in printed
    header = (tmp_path / "outputs.csv").read_text().splitlines()[0]
    assert header.split(",")[:2] == ["time_s", "body.momentum [N.s]"]
    assert (tmp_path / "trajectory.npz").is_file()


def test_a_run_is_recorded_shown_and_run_again(tmp_path: Path):
    file = tmp_path / "run.npz"
    printed = succeed("run", MODEL, "--until", "2", "--method", "rk4", "--step", "0.002", "--record-to", file)
    assert printed.splitlines()[-1] == file.as_posix()
    stored = load_trajectory(file)
    assert stored.ending.is_complete
    shown = succeed("show", file).splitlines()
    assert shown[:3] == [
        "quarter_car, scenario waves: completed to 2 s",
        "1000 steps of at most 0.002 s (rk4)",
        f"{len(stored.time)} rows, 0 events",
    ]
    (row,) = [line.split() for line in shown if line.startswith("body.flange.flow ")]
    flow = stored["body.flange.flow"]
    assert row[1:] == [f"{flow.min():.6g}", f"{flow.max():.6g}", "m/s"]
    assert "suspension" in succeed("show", file, "--tree")
    succeed(
        "run",
        MODEL,
        "--until",
        "2",
        "--record-every",
        "0.5",
        "--record-extremes",
        "--record-to",
        tmp_path / "coarse.npz",
    )
    assert load_trajectory(tmp_path / "coarse.npz").extremes("body.flange.flow").greatest.max() == pytest.approx(
        flow.max(), rel=1e-3
    )
    assert succeed("run", file).startswith("quarter_car, scenario waves: completed to 2 s; 1000 steps of 0.002 s (rk4)")
    done = invoke("run", MODEL, "--record-to", tmp_path / "nowhere" / "run.npz")
    assert done.exit_code == 2
    assert "error[simulation/record-to]" in done.output


def test_a_condition_ends_a_run():
    report = json.loads(succeed("run", MODEL, "--until", "time > 1.5 s and time > 500 ms", "--step", "0.01", "--json"))
    assert report["status"] == "stopped"
    assert report["time_s"] == pytest.approx(1.5, abs=1e-6)
    done = invoke("run", MODEL, "--until", "body.flange.flw > 1", "--step", "0.01")
    assert done.exit_code == 2
    assert "did you mean 'body.flange.flow'?" in done.output


def test_rank_prints_the_ranking_with_its_check():
    printed = succeed("rank", MODEL, "--step", "0.001")
    rows = [line.split()[0] for line in printed.splitlines()[2:8]]
    assert rows[0] == "suspension.spring"
    assert rows[-1] == "tyre.damper"
    assert "at a step of 0.0005 s instead of 0.001 s indices change by at most" in printed


def test_rank_of_a_window_and_without_a_check():
    report = json.loads(succeed("rank", MODEL, "--window", 2, 5, "--no-refine", "--json"))
    assert report["window_s"] == [2.0, 5.0]
    assert report["discretisation_check_points"] is None
    assert sum(element["index"] for element in report["elements"]) == pytest.approx(1.0)


def test_rank_of_bonds_tells_their_shares_at_junctions():
    printed = succeed("rank", MODEL, "--step", "0.001", "--bonds", "--no-refine").splitlines()
    assert printed[2].split()[0] == "suspension.spring.difference_ring2.carried"
    assert "not checked with a smaller step" in printed
    report = json.loads(succeed("rank", MODEL, "--step", "0.001", "--bonds", "--json"))
    (road,) = (bond for bond in report["bonds"] if bond["kind"] == "Sf")
    assert list(road["relative"].values()) == [1.0]
    assert report["discretisation_check"] == "at a step of 0.0005 s instead of 0.001 s"
    assert not any(junction["is_inactive"] for junction in report["junctions"])
    lines = succeed("rank", MODEL, "--step", "0.001", "--bonds", "--no-refine", "--csv").splitlines()
    assert lines[0].startswith("rank,path,kind,domain,tail,head,activity_J,share")
    assert len(lines) == 1 + len(report["bonds"])


def test_rank_measures_storage_about_a_point():
    plain, about = (
        json.loads(succeed("rank", MODEL, "--step", "0.001", "--no-refine", "--json", *more))
        for more in ((), ("--about", "equilibrium"))
    )
    # At rest nothing in this car is loaded, so that nothing changes but what the ranking says of itself.
    assert about["elements"] == plain["elements"]
    assert about["datums"] == [*plain["datums"], "storage: measured about the equilibrium in scenario waves"]
    printed = succeed(
        "rank", MODEL, "--step", "0.001", "--no-refine", "--about", "start", "--about-of", "tyre", "--about-of", "body"
    )
    assert "datum of storage: measured about the start of scenario waves in tyre, body" in printed
    assert "error[command/about]" in fail(2, "rank", MODEL, "--about-of", "tyre")


def test_rank_by_frequency_needs_no_run():
    printed = succeed("rank", MODEL, "--frequencies", "0.5:20", "--input", "road.flow=0.01", "--threshold", "0.99")
    assert "datum of efforts and flows: deviations from the start of scenario waves" in printed
    report = json.loads(succeed("rank", MODEL, "--frequencies", "0.5:20:7", "--about", "equilibrium", "--json"))
    assert [part["name"] for part in report["parts"]] == [f"{0.5 * 40.0 ** (k / 6):.4g} Hz" for k in range(7)]
    assert "error[command/frequencies]" in fail(2, "rank", MODEL, "--frequencies", "20:5")
    assert "error[command/frequencies]" in fail(2, "rank", MODEL, "--frequencies", "1:2", "--input", "road.flow=much")


def test_partition_tells_parts_and_cuts():
    printed = succeed("partition", MODEL, "--step", "0.001", "--apart")
    assert "one-way cut" in printed.splitlines()[0]
    assert "tyre.damper.port passes the flow of" in printed
    assert "run one after the other:" in printed
    report = json.loads(succeed("partition", MODEL, "--step", "0.001", "--junction-tolerance", "1e-9", "--json"))
    assert report["format"] == "propermodel-partition"
    assert report["cuts"] == []


def test_rank_over_windows_tells_the_largest_indices_and_what_is_kept():
    printed = succeed("rank", MODEL, "--step", "0.001", "--windows", "0.3:1.7,2:4", "--threshold", "0.99")
    assert "waves, 0.3 to 1.7 s" in printed
    assert "a threshold of 0.99 keeps 5 of 6" in printed
    report = json.loads(succeed("rank", MODEL, "--step", "0.001", "--no-refine", "--windows", "1 s", "--json"))
    assert len(report["parts"]) == 10
    body = next(element for element in report["elements"] if element["path"] == "body")
    assert body["largest_index"] == max(part["index"] for part in body["parts"])
    assert sum(c["index"] for c in report["components"]) < 1.0
    assert "'0:x' are no windows" in fail(2, "rank", MODEL, "--windows", "0:x")


def test_rank_prints_csv_with_a_column_for_each_scenario(tmp_path: Path):
    files = [tmp_path / f"{name}.json" for name in ("short", "long")]
    for number, file in enumerate(files, 1):
        start = {parse_path("wheel.momentum"): 8.0}
        write_scenario(Scenario(name=file.stem, stop=float(number), initial=start), file)
    scenarios = [argument for file in files for argument in ("--scenario", file)]
    lines = succeed("rank", MODEL, "--csv", "--no-refine", *scenarios).splitlines()
    assert lines[0].endswith("index in short,index in long")
    assert len(lines) == 7


def test_show_tells_the_tree_by_default():
    printed = succeed("show", MODEL)
    assert printed.splitlines()[0] == "quarter_car  QuarterCar"
    assert "spring  Spring  A linear spring." in printed


def test_show_tells_where_values_come_from():
    printed = succeed("show", MODEL, "--parameters").splitlines()
    assert next(line.split(maxsplit=4) for line in printed if line.startswith("body_mass")) == [
        "body_mass",
        "1200",
        "kg",
        "estimated",
        "a weighbridge",
    ]
    assert next(line.split() for line in printed if line.startswith("body.mass")) == [
        "body.mass",
        "1200",
        "kg",
        "body_mass",
    ]


def test_show_tells_causality_and_equations():
    printed = succeed("show", MODEL, "--causality", "--equations")
    assert "integral causality" in printed
    assert "algebraic loops: none" in printed
    assert "  body_mass*body.velocity' = suspension.stiffness*suspension.spring.displacement\n" in printed


def test_show_explains_causality_step_by_step():
    printed = succeed("show", MODEL, "--causality", "--explain")
    assert "1. Sf source prescribes the velocity (flow) of bond " in printed


def test_show_writes_equations_for_documents():
    assert r"\begin{align*}" in succeed("show", MODEL, "--equations", "--format", "latex")
    assert "| `body.velocity` | m/s | state |" in succeed("show", MODEL, "--equations", "--format", "markdown")


def test_check_of_a_sound_model():
    assert succeed("check", MODEL).splitlines()[0] == "quarter_car: no faults"


def test_check_prints_every_fault_and_fails():
    printed = fail(1, "check", f"{FILE}:Unfinished")
    assert "error[model/unconnected-port]" in printed
    assert "spring.b" in printed
    assert "fault" in printed.splitlines()[-1]
    assert str(FILE.parent) not in printed  # places are given relative to the project


def test_version_comes_first():
    lines = succeed("--version").splitlines()
    assert lines[0].startswith("propermodel ")
    assert lines[1].startswith("platform ")
    assert lines[2].startswith("CPU ")
    assert lines[3].startswith("LLVM ")


@pytest.mark.parametrize("name", NAMED_MODELS)
def test_models_of_the_library_have_what_their_entry_says(name: str):
    from propermodel.catalogue.finding import load_subject
    from propermodel.report.options import check_outputs
    from propermodel.simulation.start import begin

    subject = load_subject(name)
    compiled = compile_model(subject.model)
    check_outputs(compiled, (*subject.outputs, *subject.totals.values()))
    begin(compiled, subject.scenario)


def test_demo_writes_a_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.cli.demo.SUBJECT", "half-car")  # the truck takes minutes
    printed = succeed("demo", "--out", tmp_path, "--until", "1")
    assert (tmp_path / "mission.png").as_posix() in printed
    assert (tmp_path / "summary.json").is_file()


def test_an_implicit_method_says_in_its_file_how_many_steps_share_a_jacobian(tmp_path: Path):
    options = ("--method", "ros2", "--step", "1e-3", "--jacobian-every", "3", "--until", "0.1", "--out", tmp_path)
    assert "completed to 0.1 s" in succeed("run", MODEL, *options)
    stored = load_trajectory(tmp_path / "trajectory.npz")
    assert (stored.method, stored.step, stored.jacobian_every) == ("ros2", 1e-3, 3)
    assert "0 steps shall share a Jacobian" in fail(2, "run", MODEL, "--method", "ros2", "--jacobian-every", "0")


def test_methods_have_the_names_of_the_compiler():
    assert [name.value for name in MethodName] == [*(method.value for method in Method), "auto"]


def test_a_method_that_controls_its_steps_goes_by_a_tolerance(tmp_path: Path):
    options = ("--tolerance", "1e-6", "--until", "0.1", "--out", tmp_path)
    assert "(rodas, tolerance 1e-06" in succeed("run", MODEL, "--method", "rodas", *options)
    stored = load_trajectory(tmp_path / "trajectory.npz")
    assert (stored.method, stored.tolerance) == ("rodas", 1e-6)
    assert "note: method auto chose " in succeed("run", MODEL, "--method", "auto", "--until", "0.1")
    assert "the tolerance is 2.0; it is a share" in fail(2, "run", MODEL, "--method", "auto", "--tolerance", "2.0")


def test_a_reduction_goes_by_the_tolerance_of_its_steps(tmp_path: Path):
    options = ("--until", "2.0", "--out", tmp_path, "--no-speed")
    printed = succeed("reduce", MODEL, "--method", "rodas", "--step-tolerance", "1e-5", *options)
    assert "at a tolerance of 1e-06 instead of 1e-05" in " ".join(printed.split())


# -- wrong arguments ------------------------------------------------------------------------------------


def test_unknown_model():
    assert fail(2, "run", "half-kar") == (
        "error[command/unknown-model]: there is no model 'half-kar'\n  help: did you mean 'half-car'?\n"
    )


def test_unknown_class():
    assert "help: did you mean 'QuarterCar'?" in fail(2, "run", f"{FILE}:QuarterCra")


def test_a_file_without_a_class_offers_its_components():
    printed = fail(2, "show", FILE)
    assert "say which one is the model" in printed
    assert f"{FILE}:QuarterCar" in printed


def test_something_that_is_no_component():
    assert "gives Scenario, which is no component or model" in fail(2, "show", f"{FILE}:waves")


def test_a_file_that_is_not_there():
    assert "error[command/file]: there is no file 'gone.py'" in fail(2, "check", "gone.py:Car")
    assert "error[document/file]" in fail(1, "check", "gone.json")


def test_a_file_that_cannot_be_imported(tmp_path: Path):
    file = tmp_path / "wrong_import.py"
    file.write_text("import math\n\nmath.nothing\n")
    printed = fail(2, "check", f"{file}:Car")
    assert "the file cannot be imported: AttributeError" in printed
    assert "wrong_import.py:3" in printed


def test_unknown_scenario():
    assert "help: did you mean 'bouncing'?" in fail(2, "run", MODEL, "--scenario", "bouncy")
    assert "one of waves, bouncing, scenario" in fail(2, "run", MODEL, "--scenario", "xyz")


def test_scenario_of_a_file_and_of_another_model(tmp_path: Path):
    printed = succeed("run", MODEL, "--scenario", f"{FILE}:bouncing", "--step", "0.001")
    assert "scenario bouncing: completed to 4 s" in printed
    write_model(compile_model(_model()).model, tmp_path / "car.json")
    assert "document of format 'propermodel-scenario'" in fail(2, "run", MODEL, "--scenario", tmp_path / "car.json")


def _model():
    from propermodel.catalogue.finding import load_subject

    return load_subject(MODEL).model


def test_wrong_settings_are_all_reported():
    settings = ["body_mas=3", "body_mass=3 m", "body_mass", "wheel.mass=heavy", "suspension.stiffness=20 kN/m"]
    printed = fail(2, "run", MODEL, *(part for setting in settings for part in ("--set", setting)))
    assert printed.count("error[") == 4
    assert "the model has no parameter 'body_mas'\n  help: did you mean 'body_mass'?" in printed
    assert "'3 m' has the dimension m, not that of kg" in printed
    assert "'--set body_mass' has no '='" in printed
    assert "'heavy' is not a number with a unit" in printed


def test_a_value_out_of_range():
    assert "lies outside its range 100 to inf" in fail(2, "run", MODEL, "--set", "body_mass=5 kg")


def test_unknown_output_is_found_before_the_run(tmp_path: Path):
    printed = fail(2, "reduce", MODEL, "--out", tmp_path, "--output", "body.flange.flw")
    assert "did you mean 'body.flange.flow'?" in printed


def test_a_run_that_fails_numerically_says_so_and_keeps_what_was_computed(tmp_path: Path):
    done = invoke("run", MODEL, "--method", "euler", "--step", "0.3", "--until", "900", "--out", tmp_path)
    assert done.exit_code == 1
    assert "is no longer a finite number; try a smaller step" in done.stdout
    assert (tmp_path / "trajectory.npz").is_file()
    done = invoke("reduce", MODEL, "--method", "euler", "--step", "0.3", "--until", "900", "--out", tmp_path)
    assert done.exit_code == 1
    assert "error[study/incomplete]: full run: stopped at" in done.stderr
    assert (tmp_path / "full.npz").is_file()


class InterruptingBars(ProgressBars):
    """A user who presses Ctrl-C as soon as something moves."""

    def __call__(self, stage: str, progress: Progress | None = None) -> None:
        if progress is not None and stage in {"simulating", "refined"}:
            raise KeyboardInterrupt


def test_an_interrupted_run_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.cli.progress.ProgressBars", InterruptingBars)
    done = invoke("run", MODEL, "--until", "1000", "--step", "0.001", "--out", tmp_path)
    assert done.exit_code == 130
    assert "what was computed is kept" in done.stdout
    assert (tmp_path / "trajectory.npz").is_file()


def test_an_interrupted_study_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("propermodel.cli.progress.ProgressBars", InterruptingBars)
    done = invoke("reduce", MODEL, "--step", "0.001", "--out", tmp_path)
    assert done.exit_code == 130
    assert "refined run: interrupted at" in done.stderr
    assert (tmp_path / "full.npz").is_file()


# -- as a process ---------------------------------------------------------------------------------------

COMMAND = [sys.executable, "-c", "from propermodel.cli import main; main()"]


def test_the_command_runs_as_a_process_without_progress_in_a_pipe():
    done = subprocess.run([*COMMAND, "run", MODEL, "--until", "1"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "completed to 1 s" in done.stdout


def test_linear_algebra_of_the_command_stays_in_one_thread_unless_more_are_asked_for():
    told = "import os, propermodel.cli.app as a; a.app = lambda: print(os.environ['OPENBLAS_NUM_THREADS'])"
    command = [sys.executable, "-c", f"{told}; from propermodel.cli import main; main()"]
    unset = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    for given, expected in ((unset, "1"), ({**unset, "OPENBLAS_NUM_THREADS": "2"}, "2")):
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=given)
        assert done.stdout.strip() == expected


# -- cache ----------------------------------------------------------------------------------------------


def test_cache_tells_what_is_kept_and_clears_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PROPERMODEL_CACHE", str(tmp_path))
    assert succeed("cache").splitlines() == [f"folder: {tmp_path}", "kept: 0 entries, 0.0 MiB of at most 256.0 MiB"]
    succeed("run", MODEL, "--until", "0.01", "--step", "0.001")
    (entry,) = tmp_path.iterdir()
    told = json.loads(succeed("cache", "--json"))
    size = entry.stat().st_size
    assert told == {"folder": str(tmp_path), "entries": 1, "bytes": size, "most_bytes": 2**28, "cleared": False}
    assert succeed("cache", "--clear").splitlines()[1].startswith("deleted: 1 entry, ")
    assert list(tmp_path.iterdir()) == []


def test_cache_says_that_it_is_off(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PROPERMODEL_CACHE", "off")
    assert succeed("cache") == "compiled code is not kept: PROPERMODEL_CACHE is off\n"
    assert json.loads(succeed("cache", "--json")) == {"folder": None}


# -- files from strangers -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("strange")
    write_model(_model(), folder / "whole.json")
    whole = (folder / "whole.json").read_bytes()
    (folder / "truncated.json").write_bytes(whole[: len(whole) // 2])
    (folder / "junk.json").write_bytes(bytes(range(256)) * 10)
    (folder / "junk.py").write_bytes(bytes(range(256)) * 10)
    (folder / "deep.json").write_bytes(b"[" * 10**6)
    (folder / "folder.json").mkdir()
    (folder / "device.json").symlink_to("/dev/zero")
    with (folder / "large.json").open("wb") as stream:
        stream.truncate(2**40)
    return folder


@pytest.mark.parametrize(
    ("name", "code", "message"),
    [
        ("missing.json", "document/file", "No such file or directory"),
        ("folder.json", "document/file", "it is a folder"),
        ("device.json", "document/file", "it is a pipe or a device"),
        ("large.json", "document/size", "at most 67108864 are read"),
        ("truncated.json", "document/json", "the file is not JSON"),
        ("junk.json", "document/json", "the file is not text in UTF-8"),
        ("deep.json", "document/limit", "more than 32 lists and objects in each other"),
        ("junk.py", "command/import", "cannot be imported"),
    ],
)
def test_strange_files_are_refused_by_every_command(strange: Path, name: str, code: str, message: str):
    scenario = f"{strange / name}:f" if name.endswith(".py") else strange / name
    for arguments in (
        ("check", strange / name),
        ("show", strange / name),
        ("run", strange / name),
        ("run", strange / "whole.json", "--scenario", scenario),
    ):
        done = invoke(*arguments)
        assert isinstance(done.exception, SystemExit), done.exception
        assert done.exit_code in (1, 2)
        assert f"error[{code}]: " in done.stderr
        assert message in done.stderr
        assert name in done.stderr
        assert "\n  help: " in done.stderr
        assert not set(map(chr, range(32))) & set(done.stderr) - {"\n"}


def test_no_document_writes_to_the_screen_what_is_no_text(strange: Path):
    whole = (strange / "whole.json").read_bytes()
    (strange / "screen.json").write_bytes(whole.replace(b'"QuarterCar"', rb'"\u001b[2J"'))
    printed = fail(2, "show", strange / "screen.json")
    assert r"the text '\x1b[2J' has control characters" in printed
    assert "\x1b" not in printed
