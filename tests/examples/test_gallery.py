"""What every example keeps: a docstring that teaches, a short file, closed energy."""

from __future__ import annotations

import runpy

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from tests.examples.runs import FOLDER, NAMES, answer, module

# Sampled controllers and jumps of inputs make the order of integration one at their instants.
TOLERANCE = dict.fromkeys(NAMES, 1e-06)


@pytest.mark.parametrize("name", NAMES)
def test_the_file_is_short_and_teaches(name: str):
    text = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    assert 30 <= len(text.splitlines()) <= 90
    assert len((module(name).__doc__ or "").split()) > 35
    assert "import propermodel as pm" in text


@pytest.mark.parametrize("name", NAMES)
def test_the_run_completes_and_its_energy_balance_closes(name: str):
    run = answer(name)
    assert run.ending.is_complete
    assert np.isfinite(run.columns).all()
    assert energy_balance(run).relative_residual < TOLERANCE[name]
    for output in module(name).OUTPUTS:
        assert np.ptp(run[output]) > 0.0, output


@pytest.mark.parametrize("name", NAMES)
def test_the_script_prints_a_short_result(name: str, capsys):
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    printed = capsys.readouterr().out
    assert "energy balance: sources" in printed
    assert len(printed.splitlines()) <= 30
