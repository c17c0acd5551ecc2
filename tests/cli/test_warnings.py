"""Warnings about a model on the command line: printed on stderr as errors are, once, by every command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from propermodel.cli.app import app

MODEL = f"{Path(__file__).with_name('two_rooms.py')}:TwoRooms"
FIRST = "warning[structure/disconnected]: two_rooms is in two parts that do not act on each other"


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", MODEL),
        ("show", MODEL, "--causality"),
        ("run", MODEL, "--json"),
        ("rank", MODEL),
        ("linearise", MODEL),
        ("reduce", MODEL, "--until", "2", "--out", "OUT"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_every_command_that_compiles_prints_a_warning_once_on_stderr(arguments: tuple[str, ...], tmp_path: Path):
    done = CliRunner().invoke(app, [str(tmp_path) if argument == "OUT" else argument for argument in arguments])
    assert [line for line in done.stderr.splitlines() if line.startswith("warning[")] == [FIRST]
    assert "  help: connect them where they should meet" in done.stderr
    assert "warning" not in done.stdout or arguments[0] == "check"
    assert done.exit_code == 0, done.output


def test_check_counts_warnings():
    done = CliRunner().invoke(app, ["check", MODEL])
    assert done.stdout.splitlines()[0] == "two_rooms: no faults, 1 warning"


def test_what_a_program_reads_stays_clean():
    done = CliRunner().invoke(app, ["run", MODEL, "--json"])
    assert json.loads(done.stdout)["status"] == "completed"
