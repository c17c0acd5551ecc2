"""Sensitivities of random rigs are what their runs differ by when a mass, a stiffness, a damping or a lever differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings

import propermodel as pm
from propermodel.compiler import Backend, CompiledModel, compile_quietly
from tests.rigs import Rig, rigs

STOP, STEP = 0.5, 0.05
DISTANCE = 1e-5
SIZES = {"spring": "stiffness", "damper": "damping", "lever": "ratio"}


def ends(model: CompiledModel, scenario: pm.Scenario) -> np.ndarray:
    """The states at the end, and the work of every row."""
    run = pm.simulate(model, scenario, method=pm.Method.RK4, step=STEP, record=[], integrals_every=STOP)
    rows = [row.path if len(row.bonds) > 1 else next(iter(row.bonds)) for row in model.system.rows]
    return np.array([*run.memory.state, *(run.work(entry) for entry in rows)])


@settings(max_examples=6, deadline=None)
@given(rigs())
def test_sensitivities_are_the_limit_of_differences(rig: Rig):
    model = compile_quietly(pm.elaborate(rig.component()), backend=Backend.INTERPRETED)
    names = ["push.force", "m0.mass"]
    names += [f"e{number}.{SIZES[edge.kind]}" for number, edge in enumerate(rig.edges)]
    states = [state.path for state in model.system.states]
    scenario = pm.Scenario(stop=STOP)
    found = pm.sensitivities(
        model, scenario, parameters=names[:6], outputs=states, method=pm.Method.RK4, step=STEP, record_every=STOP
    )
    assert found.ending.is_complete
    slopes = np.concatenate([found.final.slopes, found.row_work.slopes])
    for k, path in enumerate(found.parameters):
        value = float(found.parameter_values[k])
        less, more = (
            ends(model, replace(scenario, parameters={path: value + side * DISTANCE})) for side in (-1.0, 1.0)
        )
        scale = np.abs(slopes[:, k]).max() + np.abs(more).max()
        assert np.abs(slopes[:, k] - (more - less) / (2.0 * DISTANCE)).max() <= 1e-6 * scale
    if rig.force:
        assert found.row_work.slopes[:, 0].any()
