"""Every example goes to JSON and back equal, and runs the same from its document where its author's module is not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from propermodel.modelling.documents import read_model, read_scenario, write_model, write_scenario
from propermodel.simulation.storage import load_trajectory
from tests.examples.runs import NAMES, answer, module, run_of, subject

SOURCES = Path(__file__).parents[2] / "src"
SCRIPT = Path(__file__).parent / "open_elsewhere.py"


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the documents of all examples, and what another process has made of them."""
    folder = tmp_path_factory.mktemp("elsewhere")
    script = folder / "open_elsewhere.py"
    script.write_text(SCRIPT.read_text(encoding="utf-8"), encoding="utf-8")
    for name in NAMES:
        write_model(subject(name).model, folder / f"{name}.model.json")
        write_scenario(module(name).scenario(), folder / f"{name}.scenario.json")
    orders = {name: dict(run_of(name)[1]) for name in NAMES}
    (folder / "orders.json").write_text(json.dumps(orders), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(SOURCES)}
    done = subprocess.run(
        [sys.executable, str(script), str(folder)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("name", NAMES)
def test_the_documents_are_equal(name: str, elsewhere: Path):
    assert read_model(elsewhere / f"{name}.model.json") == subject(name).model
    assert read_scenario(elsewhere / f"{name}.scenario.json") == module(name).scenario()
    assert read_model(elsewhere / f"{name}.again.json") == subject(name).model


@pytest.mark.parametrize("name", NAMES)
def test_the_run_is_the_same_without_the_author(name: str, elsewhere: Path):
    here, there = answer(name), load_trajectory(elsewhere / f"{name}.npz")
    assert there.ending == here.ending
    assert there.events == here.events
    assert there.notes == here.notes
    np.testing.assert_array_equal(there.time, here.time)
    assert there.paths == here.paths
    for path in there.paths:
        np.testing.assert_array_equal(there[path], here[path])
    for power in here.compiled.lowered.powers:
        if power.kind != "outside":
            np.testing.assert_array_equal(there.activity(power.path), here.activities[:, here.power_index(power.path)])
            np.testing.assert_array_equal(there.work(power.path), here.integrals[:, here.power_index(power.path)])
