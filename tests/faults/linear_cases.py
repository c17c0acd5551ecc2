"""Faults in what is asked of equilibria and linear models."""

from __future__ import annotations

import sys
from functools import cache
from unittest import mock

import propermodel as pm
from examples.transmission_line import TransmissionLine
from propermodel import (
    Component,
    Hydraulic,
    LinearModel,
    Parameter,
    Port,
    Resistance,
    Scenario,
    compile_model,
    connect,
    elaborate,
    find_equilibrium,
    linearise,
    parameter,
)
from propermodel.compiler import compile_quietly
from tests.faults.case import Case
from tests.faults.quarter import STEP, quarter, run
from tests.parts import Force, Mass, Spring, Tank, Velocity


@cache
def linear() -> LinearModel:
    return linearise(quarter(), STEP, outputs=["body.flange.flow", "suspension.spring.displacement"])


class Pushed(Component):
    """A mass that a force accelerates for ever."""

    mass = Mass(mass=2.0)
    push = Force(force=10.0)
    connections = (connect(mass.flange, push.flange),)


class Carried(Component):
    """A mass that moves exactly as a shaker does."""

    mass = Mass(mass=2.0)
    shaker = Velocity(velocity=0.1)
    connections = (connect(mass.flange, shaker.flange),)


class Pair(Component):
    """Two masses on a spring without damping."""

    one = Mass(mass=1.0)
    two = Mass(mass=1.0)
    spring = Spring(stiffness=50.0)
    push = Force(force=1.0)
    connections = (connect(one.flange, push.flange, spring.a), connect(two.flange, spring.b))


class Outlet(Resistance):
    """An orifice: the flow is the root of the pressure."""

    port = Port(Hydraulic)
    loss: Parameter = parameter("Pa.s2/m6", default=1.0e9)

    def flow(self, effort):
        return pm.sign(effort) * pm.sqrt(abs(effort) / self.loss)


class Emptied(Component):
    """A tank that is empty at the start: the root has a vertical tangent there."""

    tank = Tank(capacity=1.0e-4)
    outlet = Outlet()
    connections = (connect(tank.port, outlet.port),)


class Lifted(pm.SignalBlock):
    """Lifts what is below one to one, and leaves the rest as it is."""

    value = pm.Input("1")
    lifted = pm.Output("1")

    def outputs(self):
        return {self.lifted: pm.maximum(self.value, 1.0)}


class Flat(Component):
    """A signal that is itself lifted: from one on any value will do, so that nothing tells how it changes."""

    lift = Lifted()
    connections = (connect(lift.lifted, lift.value),)


def at_start(component: Component, **chosen: object) -> LinearModel:
    return linearise(compile_quietly(elaborate(component)), Scenario(), **chosen)  # pyright: ignore[reportArgumentType]


def without_control() -> object:
    with mock.patch.dict(sys.modules, {"control": None}):
        return linear().to_control()


CASES = (
    Case(
        code="simulation/no-equilibrium",
        run=lambda: find_equilibrium(compile_model(elaborate(Pushed())), Scenario()),
        names=("mass.momentum", "pushed"),
        at="mass = Mass(mass=2.0)",
        cure="hold=[...]",
    ),
    Case(
        code="simulation/unknown-state",
        run=lambda: find_equilibrium(quarter(), STEP, hold=["body.momentun"]),
        names=("body.momentun",),
        cure="did you mean 'body.momentum'?",
    ),
    Case(code="simulation/singular-block", run=lambda: at_start(Flat()), names=("lift", "0 s"), cure="another point"),
    Case(
        code="linear/point",
        run=lambda: linearise(quarter(), run(), time=9.0),
        names=("0.5 s", "9 s"),
        cure="instant inside the run",
    ),
    Case(
        code="linear/unknown-input",
        run=lambda: linearise(quarter(), STEP, inputs=["road.flw"]),
        names=("road.flw",),
        cure="did you mean 'road.flow'?",
    ),
    Case(
        code="linear/unknown-name",
        run=lambda: linear().transfer_function("road.flow", "body.flange.flw"),
        names=("output", "body.flange.flw"),
        cure="did you mean 'body.flange.flow'?",
    ),
    Case(
        code="linear/not-finite",
        run=lambda: at_start(Emptied()),
        names=("tank.displacement", "0 s"),
        cure="vertical tangent",
    ),
    Case(
        code="linear/improper",
        run=lambda: at_start(Carried(), outputs=["mass.flange.effort"]).step_response(),
        names=("mass.flange.effort", "shaker"),
        cure="frequency response",
    ),
    Case(
        code="linear/resonance",
        run=lambda: at_start(Pair(), outputs=["one.flange.flow"]).frequency_response([1.0, 10.0]),
        names=("pair", "10 rad/s"),
        cure="modes()",
    ),
    Case(
        code="linear/gain",
        run=lambda: at_start(TransmissionLine(), outputs=["load.port.effort"]).transfer_function("voltage"),
        names=("voltage", "load.port.effort"),
        cure="frequency_response()",
    ),
    Case(
        code="linear/duration",
        run=lambda: linear().step_response(duration=0.0),
        names=("501 points", "0 s"),
        cure="positive duration",
    ),
    Case(code="linear/no-control", run=without_control, names=("python-control",), cure="propermodel[control]"),
)
