"""The NumPy backend takes the first steps of every example as native code does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propermodel.compiler import Backend, compile_model
from propermodel.simulation.simulate import simulate
from tests.examples.runs import NAMES, answer, module, subject


@pytest.mark.parametrize("name", NAMES)
def test_both_backends_take_the_same_steps(name: str):
    full = answer(name)
    scenario = replace(module(name).scenario(), stop=20 * full.step)
    native, interpreted = (
        simulate(
            compile_model(subject(name).model, backend=backend),
            scenario,
            method=full.method,
            step=full.step,
            record_every=5 * full.step,
        )
        for backend in (Backend.NATIVE, Backend.INTERPRETED)
    )
    assert interpreted.ending.is_complete
    scale = np.abs(native.columns).max(axis=0)
    assert (np.abs(interpreted.columns - native.columns) <= 1e-12 + 1e-9 * scale).all()
