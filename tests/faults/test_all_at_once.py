"""A stage goes on after a fault: what is wrong with a model is told at once, stage by stage."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import propermodel as pm
from propermodel import (
    Compliance,
    Component,
    Input,
    Parameter,
    Port,
    ProperModelError,
    Resistance,
    Scenario,
    SignalBlock,
    Translation,
    bond,
    connect,
    parameter,
)
from tests.faults.structure_cases import More, Shaker, Yielding
from tests.parts import Fixed, Flywheel, Force, Ground, Mass, Resistor, Spring, Velocity, Voltage


def told(run: Callable[[], object]) -> list[str]:
    """The codes of what is raised, each fault once, with a cure for each."""
    with pytest.raises(ProperModelError) as caught:
        run()
    assert all(diagnostic.help for diagnostic in caught.value.diagnostics)
    assert len(set(caught.value.diagnostics)) == len(caught.value.diagnostics)
    return sorted(diagnostic.code for diagnostic in caught.value.diagnostics)


# -- modelling ------------------------------------------------------------------------------------------------


class WrongUnit(Resistance):
    port = Port(Translation)
    stiffness: Parameter = parameter("N/m", default=1.0)

    def effort(self, flow):
        return self.stiffness * flow


class Lawless(Resistance):
    port = Port(Translation)


class Broken(Compliance):
    port = Port(Translation)

    def effort(self, displacement):
        return {}["stiffness"] * displacement


class Share(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m", low=0.0, high=10.0)

    def effort(self, flow):
        return self.damping * flow


class Misdescribed(Component):
    stranger = Mass(mass=1.0)
    wrong, lawless, broken = WrongUnit(), Lawless(), Broken()
    large, nothing = Share(damping=11.0), Share()
    wheel = Flywheel(inertia=1.0)
    body = Mass(mass=1.0)

    connections = (
        connect(wheel.shaft, body.flange),  # pyright: ignore[reportArgumentType, reportCallIssue]
        connect(wrong.port, lawless.port, broken.port, large.port, nothing.port, Fixed().flange),
        connect(stranger.flange, Fixed().flange),
    )


def test_modelling():
    assert told(lambda: pm.elaborate(Misdescribed())) == [
        "model/dimension",
        "model/domain",
        "model/foreign-reference",
        "model/foreign-reference",
        "model/law",
        "model/law-missing",
        "model/missing-parameter",
        "model/parameter-range",
    ]


# -- connection -----------------------------------------------------------------------------------------------


class Loose(Component):
    """A spring without an end, an input without a signal, a junction of two domains, an open port, a wide value."""

    end = Port(Translation)
    size: Parameter = parameter("N.s/m", default=20.0)

    body, spring = Mass(mass=1.0), Spring(stiffness=1.0)
    mover = Yielding()
    node = pm.OneJunction()
    wheel, load = Flywheel(inertia=1.0), Mass(mass=1.0)
    drag = Share(damping=size)

    connections = (
        connect(end, body.flange, spring.a, mover.flange, drag.port),
        bond(node, wheel.shaft),
        bond(node, load.flange),
    )


def test_connection():
    assert told(lambda: pm.compile_model(pm.elaborate(Loose()))) == [
        "model/domain",
        "model/open-port",
        "model/parameter-range",
        "model/unconnected-port",
        "model/undriven-signal",
    ]


# -- causality ------------------------------------------------------------------------------------------------


class Contradictory(Component):
    road, shaker, body = Velocity(velocity=1.0), Velocity(velocity=2.0), Mass(mass=1.0)
    mains, battery, lamp, ground = Voltage(voltage=230.0), Voltage(voltage=12.0), Resistor(resistance=10.0), Ground()
    push, pull = Force(force=1.0), Force(force=2.0)

    connections = (
        connect(road.flange, shaker.flange, body.flange),
        connect(mains.a, battery.a, lamp.a),
        connect(mains.b, battery.b, lamp.b, ground.pin),
        connect(push.flange, pull.flange),
    )


def test_causality():
    assert told(lambda: pm.compile_model(pm.elaborate(Contradictory()))) == ["causality/conflict"] * 3


# -- equations ------------------------------------------------------------------------------------------------


class Unsolvable(Component):
    """Two signals that feed themselves, and a mass that follows the reaction of another."""

    first, second = More(), More()
    shaker, one = Shaker(), Mass(mass=1.0)
    mover, two = Yielding(), Mass(mass=1.0)

    connections = (
        connect(first.more, first.speed),
        connect(second.more, second.speed),
        connect(shaker.flange, one.flange),
        connect(mover.flange, two.flange),
        connect(one.flange.effort, mover.force),
    )


def test_equations():
    assert told(lambda: pm.compile_model(pm.elaborate(Unsolvable()))) == [
        "equations/index",
        "equations/singular",
        "equations/singular",
    ]


# -- runs -----------------------------------------------------------------------------------------------------


class Pushed(SignalBlock):
    """Reads a signal of the scenario."""

    given = Input("N")
    result = pm.Output("N")

    def outputs(self):
        return {self.result: self.given}


class Rig(Component):
    body, drag = Mass(mass=1.0), Share(damping=1.0)
    push = pm.Input("N")
    block = Pushed()

    connections = (connect(body.flange, drag.port), connect(push, block.given))


def test_runs():
    compiled = pm.compile_model(pm.elaborate(Rig()))
    scenario = Scenario(
        stop=-1.0,
        inputs={"pusch": 1.0},  # pyright: ignore[reportArgumentType]
        initial={"body.momentun": 1.0},  # pyright: ignore[reportArgumentType]
        parameters={"drag.damping": 11.0, "drag.dampnig": 1.0, "body.mass": float("nan")},  # pyright: ignore[reportArgumentType]
    )
    assert told(
        lambda: pm.simulate(
            compiled,
            scenario,
            step=0.0,
            record_every=-1.0,
            record=["body.flange.flw", "drag.port.effrt"],
            until=Rig().body.flange.flow + 1.0,  # pyright: ignore[reportArgumentType]
        )
    ) == [
        "simulation/parameter-range",
        "simulation/parameter-range",
        "simulation/period",
        "simulation/step",
        "simulation/unknown-initial",
        "simulation/unknown-input",
        "simulation/unknown-observable",
        "simulation/unknown-observable",
        "simulation/unknown-parameter",
        "simulation/until",
        "simulation/window",
    ]
