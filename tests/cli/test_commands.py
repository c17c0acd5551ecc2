"""The commands, as a user types them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from propermodel.catalogue.named import NAMED_MODELS
from propermodel.cli.options import MethodName
from propermodel.compiler import Method, compile_model
from propermodel.simulation.storage import load_trajectory
from tests.cli.commands import FILE, MODEL, fail, invoke, succeed


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


def test_partition_tells_parts_and_cuts():
    printed = succeed("partition", MODEL, "--step", "0.001", "--apart")
    assert "one-way cut" in printed.splitlines()[0]
    assert "tyre.damper.port passes the flow of" in printed
    assert "run one after the other:" in printed
    report = json.loads(succeed("partition", MODEL, "--step", "0.001", "--junction-tolerance", "1e-9", "--json"))
    assert report["format"] == "propermodel-partition"
    assert report["cuts"] == []


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
