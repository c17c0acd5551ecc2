"""The sensitivities of examples are the limits of differences between runs with the same steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import propermodel as pm
from propermodel.expressions.core import Op
from tests.examples.runs import module, run_of

# Every kind of model: loops, dependent storage, closed loops, tables, controllers, fields, starts, events, impacts.
EXAMPLES = (
    "accumulator",
    "belt_drive",
    "bouncing_ball",
    "clutch",
    "coupled_coils",
    "coupled_pendulums",
    "cruise_control",
    "double_pendulum",
    "electrostatic_transducer",
    "four_bar_linkage",
    "freewheeling_diode",
    "gas_spring",
    "geared_inertias",
    "heat_exchanger",
    "hydraulic_press",
    "loudspeaker",
    "pendulum_by_transformers",
    "planetary_gear",
    "slider_crank_chain",
    "stacked_balls",
    "suspension_modes",
    "thermal_wall",
    "thermostat",
    "transformer_load",
    "two_equilibria",
    "wheatstone_bridge",
)
IMPLICIT = ("clutch", "cruise_control", "gas_spring", "planetary_gear", "slider_crank")
MOVING = ("bouncing_ball", "stacked_balls", "thermostat")  # instants of events
STEPS = 200
PARAMETERS = 4
DISTANCE = 1e-7  # between runs, as a share of the parameter
NOISE = 1e-12  # of the runs, as a share of the largest value


@pytest.mark.parametrize("name", EXAMPLES)
def test_sensitivities_are_the_limit_of_differences(name: str):
    check(name, {"method": run_of(name)[0].method})


@pytest.mark.parametrize("name", IMPLICIT)
@pytest.mark.parametrize("jacobian_every", [1, 3])
def test_those_of_implicit_steps_are_too(name: str, jacobian_every: int):
    check(name, {"method": pm.Method.ROS2, "jacobian_every": jacobian_every})


def check(name: str, options: Mapping[str, Any]) -> None:
    """Compare the sensitivities of a short run with differences."""
    run, _ = run_of(name)
    compiled, outputs = run.compiled, module(name).OUTPUTS
    whole = run.scenario
    scenario = replace(whole, stop=min(whole.stop, whole.start + STEPS * run.step))
    flat = compiled.graph.parameters
    constants = [path for path, parameter in flat.items() if parameter.value.op is Op.CONSTANT]
    chosen = np.random.default_rng(len(name)).choice(len(constants), min(PARAMETERS, len(constants)), replace=False)
    parameters = [constants[i] for i in sorted(chosen)]
    found = pm.sensitivities(
        compiled,
        scenario,
        parameters=parameters,
        outputs=outputs,
        step=run.step,
        **options,
        record_every=100 * run.step,
    )
    assert found.ending.is_complete
    for k, path in enumerate(parameters):
        value = found.parameter_values[k]
        distance = DISTANCE * (abs(value) or 1.0)
        runs = pm.simulate_many(
            compiled,
            pm.designs(scenario, {path: [value - distance, value, value + distance]}),
            step=run.step,
            **options,
            record=outputs,
            record_every=100 * run.step,
        )
        assert not runs.failed
        for output in outputs:
            agree(found[output, path], runs[output], distance)
        entries = [row.path if len(row.bonds) > 1 else next(iter(row.bonds)) for row in compiled.system.rows]
        works, activities = (np.array([of(entry) for entry in entries]).T for of in (runs.work, runs.activity))
        agree(found.row_work.slopes[:, k], works, distance)
        # Where events move, steps move over the instants at which powers change their sign.
        agree(found.row_activity.slopes[:, k], activities, distance, 2e-2 if name in MOVING else 2e-4)


def agree(slopes: np.ndarray, runs: np.ndarray, distance: float, tolerance: float = 2e-4) -> None:
    """Compare with the differences to either side, between which a kink may lie (a power that changes its sign)."""
    sides = np.diff(runs, axis=0) / distance
    allowed = tolerance * np.abs(slopes).max() + NOISE * np.abs(runs).max() / distance
    assert (slopes >= sides.min(axis=0) - allowed).all()
    assert (slopes <= sides.max(axis=0) + allowed).all()
