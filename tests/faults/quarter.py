"""A quarter of a car, which the faults of runs, rankings and reductions are made with."""

from __future__ import annotations

from functools import cache

from propermodel import (
    CompiledModel,
    Component,
    Port,
    Scenario,
    Trajectory,
    Translation,
    compile_model,
    connect,
    elaborate,
    prescribed_flow,
    simulate,
)
from tests.parts import Mass, SpringDamper


class Quarter(Component):
    """A body on a suspension whose foot the scenario moves."""

    road = Port(Translation)
    body = Mass(mass=250.0)
    suspension = SpringDamper(stiffness=1.0e4, damping=1.0e3)

    connections = (
        connect(road, suspension.a),
        connect(suspension.b, body.flange),
        prescribed_flow(road),
    )


STEP = Scenario(name="step", stop=0.5, inputs={"road.flow": 0.1})  # pyright: ignore[reportArgumentType]


@cache
def quarter() -> CompiledModel:
    return compile_model(elaborate(Quarter()))


@cache
def run() -> Trajectory:
    return simulate(quarter(), STEP, step=1e-3, record_every=0.05)
