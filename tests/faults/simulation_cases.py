"""Faults in runs of a compiled model."""

from __future__ import annotations

import sys
from dataclasses import replace as changed
from unittest.mock import patch

import propermodel as pm
from propermodel import (
    Component,
    Expr,
    Inertia,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Scenario,
    SignalBlock,
    TableValues,
    Translation,
    chain,
    compile_model,
    connect,
    elaborate,
    free,
    parameter,
    repeat,
    simulate,
)
from propermodel.library.electrical import ConstantVoltage, CoupledInductors, Ground, IdealDiode, Resistor
from tests.faults.case import Case
from tests.faults.quarter import STEP, Quarter, quarter, run
from tests.parts import Fixed, Mass


class Wheel(Component):
    """Something that is not in the quarter."""

    wheel = Mass(mass=30.0)


def with_scenario(**changes: object) -> object:
    return simulate(quarter(), changed(STEP, **changes), step=1e-3)  # pyright: ignore[reportArgumentType]


def not_recorded() -> object:
    return simulate(quarter(), STEP, step=1e-3, record=["body.flange.flow"])["suspension.spring.port.effort"]


def continued_elsewhere() -> object:
    other = compile_model(elaborate(Quarter()))
    return simulate(other, changed(STEP, stop=1.0), step=1e-3, continued_from=run())


class Drag(Resistance):
    """Turbulent drag: the force grows with the square of the speed."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    linear: Parameter = parameter("N.s/m", default=1.0)
    square: Parameter = parameter("N.s2/m2", default=1.0)

    def effort(self, flow: Expr) -> Expr:
        return flow * (self.linear + self.square * abs(flow))


class Rung(Component):
    """Drag to the next rung and to the ground."""

    a = Port(Translation)
    b = Port(Translation)
    along, across, ground = Drag(), Drag(), Fixed()
    connections = (connect(a, along.a), connect(b, along.b, across.a), connect(across.b, ground.flange))


class Ladder(Component):
    """Dampers without a mass between them."""

    end = Port(Translation)
    mass = Mass(mass=1.0)
    rungs = repeat(25, Rung())
    connections = (connect(mass.flange, rungs[0].a), *chain(rungs, "b", "a"), connect(rungs[24].b, end), free(end))


def without_sundials() -> object:
    # A module that is None cannot be imported.
    with patch.dict(sys.modules, {"sksundae.cvode": None}):
        return simulate(quarter(), STEP, method=pm.Method.CVODE)


def large_block() -> object:
    return simulate(compile_model(elaborate(Ladder())), Scenario(stop=0.1), method=pm.Method.ROS2)


class Rectified(Component):
    """A resistor behind an ideal diode."""

    source = ConstantVoltage(voltage=1.0)
    switch = IdealDiode()
    load = Resistor(resistance=1.0)
    ground = Ground()
    connections = (
        connect(source.p, switch.a),
        connect(switch.b, load.a),
        connect(source.n, load.b, ground.pin),
    )


def sensitivities_with_switches() -> object:
    compiled = compile_model(elaborate(Rectified()))
    return pm.sensitivities(compiled, Scenario(stop=0.1), parameters=["load.resistance"])


class Squared(SignalBlock):
    speed = Input("m/s")
    more = Output("m/s")

    def outputs(self):
        return {self.more: self.speed * self.speed / pm.quantity(1.0, "m/s") + pm.quantity(1.0, "m/s")}


class Unsolvable(Component):
    """A signal that is one more than its own square: no number is."""

    square = Squared()
    connections = (connect(square.more, square.speed),)


def not_converged() -> object:
    return simulate(compile_model(elaborate(Unsolvable())), Scenario(stop=0.1), step=1e-3)


class Relativistic(Inertia):
    """Momentum without bound, at speeds below that of light: given the speed, the law has an end."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", default=1.0)
    light: Parameter = parameter("m/s", default=1.0)

    def flow(self, momentum):
        ratio = momentum / (self.mass * self.light)
        return momentum / self.mass / pm.sqrt(1.0 + ratio * ratio)

    def momentum(self, flow):
        ratio = flow / self.light
        return self.mass * flow / pm.sqrt(1.0 - ratio * ratio)

    def energy(self, momentum):
        ratio = momentum / (self.mass * self.light)
        return self.mass * self.light**2.0 * (pm.sqrt(1.0 + ratio * ratio) - 1.0)


class Welded(Component):
    slow = Mass(mass=1.0)
    fast = Relativistic()
    connections = (connect(slow.flange, fast.flange),)


def too_fast() -> object:
    start = {"slow.momentum": 1.5, "fast.momentum": 0.0}  # 1.5 m/s, faster than light here
    return simulate(compile_model(elaborate(Welded())), Scenario(stop=0.1, initial=start), step=1e-3)  # pyright: ignore[reportArgumentType]


class CoilPair(Component):
    """Two coils with a coupling of one."""

    coils = CoupledInductors(primary_inductance=4.0, secondary_inductance=1.0, mutual_inductance=2.0)
    first = Resistor(resistance=1.0)
    second = Resistor(resistance=1.0)
    ground = Ground()
    connections = (
        connect(coils.primary_a, first.a),
        connect(coils.secondary_a, second.a),
        connect(coils.primary_b, coils.secondary_b, first.b, second.b, ground.pin),
    )


def fully_coupled() -> object:
    return simulate(compile_model(elaborate(CoilPair())), Scenario(stop=1.0))


CASES = (
    Case(
        code="simulation/singular-field",
        run=fully_coupled,
        names=("coils", "primary and secondary", "mutual_inductance = 2 H"),
        at="coils = CoupledInductors(",
        cure="transformer",
    ),
    Case(code="simulation/window", run=lambda: with_scenario(stop=0.0), names=("step", "0"), cure="later stop"),
    Case(
        code="simulation/step",
        run=lambda: simulate(quarter(), STEP, step=0.0),
        names=("0.0 s",),
        cure="step well below",
    ),
    Case(
        code="simulation/tolerance",
        run=lambda: simulate(quarter(), STEP, tolerance=0.0),
        names=("0.0",),
        cure="share of each state",
    ),
    Case(
        code="simulation/nothing-to-plot",
        run=lambda: simulate(quarter(), STEP).plot(["body.flange.flow"] * 2, axes=[None]),
        names=("2 observables", "1 were given"),
        cure="axes that another plot",
    ),
    Case(
        code="simulation/sundials",
        run=without_sundials,
        names=("cvode", "not installed"),
        cure="pip install 'propermodel[sundials]'",
    ),
    Case(
        code="simulation/large-block",
        run=large_block,
        names=("25 unknowns", "rungs[1].along", "24"),
        cure="use rk4",
    ),
    Case(
        code="simulation/condition",
        run=lambda: simulate(quarter(), STEP, until="body.flange.flow <"),
        names=("body.flange.flow <", "a number or a name was expected"),
        cure="compare names of the model",
    ),
    Case(
        code="simulation/until",
        run=lambda: simulate(quarter(), STEP, until=Wheel().wheel.flange.flow > 1.0),
        names=("wheel.flange.flow",),
        cure="body.flange.flow",
    ),
    Case(
        code="simulation/unknown-parameter",
        run=lambda: with_scenario(parameters={"body.mas": 1.0}),
        names=("body.mas",),
        cure="did you mean 'body.mass'?",
    ),
    Case(
        code="simulation/parameter-range",
        run=lambda: with_scenario(parameters={"body.mass": float("nan")}),
        names=("body.mass", "nan"),
        cure="finite",
    ),
    Case(
        code="simulation/unknown-input",
        run=lambda: with_scenario(inputs={"road.flw": 1.0}),
        names=("road.flw", "step"),
        cure="did you mean 'road.flow'?",
    ),
    Case(
        code="simulation/unknown-initial",
        run=lambda: with_scenario(initial={"body.momentun": 1.0}),
        names=("body.momentun", "step"),
        cure="did you mean 'body.momentum'?",
    ),
    Case(
        code="simulation/table-shape",
        run=lambda: with_scenario(inputs={"road.flow": TableValues(((0.0, 1.0), (0.0, 1.0)), (0.0,) * 4)}),
        names=("road.flow", "1 coordinate"),
        cure="same kind of grid",
    ),
    Case(
        code="simulation/unknown-observable",
        run=lambda: run()["body.flange.flw"],
        names=("body.flange.flw",),
        cure="did you mean 'body.flange.flow'?",
    ),
    Case(
        code="simulation/not-recorded", run=not_recorded, names=("suspension.spring.port.effort",), cure="record=[...]"
    ),
    Case(
        code="simulation/unknown-bond",
        run=lambda: run().power_index(pm.Path(("body", "flang"))),
        names=("body.flang",),
        cure="did you mean 'body.flange'?",
    ),
    Case(
        code="simulation/not-finite",
        run=lambda: with_scenario(initial={"body.momentum": float("nan")}),
        names=("step", "body.momentum", "nan"),
        cure="finite start",
    ),
    Case(
        code="simulation/period",
        run=lambda: simulate(quarter(), STEP, step=1e-3, record_every=0.0),
        names=("0 s",),
        cure="record_every=",
    ),
    Case(
        code="simulation/record-to",
        run=lambda: simulate(quarter(), STEP, step=1e-3, record_to="nowhere/run.npz"),
        names=("nowhere/run.npz", "No such file"),
        cure="folder that exists",
    ),
    Case(code="simulation/not-converged", run=not_converged, names=("square", "0 s"), cure="laws around this loop"),
    Case(code="simulation/start", run=too_fast, names=("fast.momentum",), cure="starts that agree"),
    Case(code="simulation/continue", run=continued_elsewhere, cure="compile"),
    Case(
        code="simulation/designs",
        run=lambda: pm.designs(pm.Scenario(), {"body.mass": [1.0, 2.0], "tyre.stiffness": [1.0, 2.0, 3.0]}),
        names=("2 of body.mass", "3 of tyre.stiffness"),
        cure="one value for each design",
    ),
    Case(
        code="simulation/sensitivities",
        run=sensitivities_with_switches,
        names=("ideal switches", "switch"),
        cure="differences of two runs",
    ),
)
