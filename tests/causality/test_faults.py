"""All contradictions of one graph are reported at once, each for itself."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel import Component, connect
from propermodel.bondgraph.flatten import flatten
from propermodel.causality.faults import causal_faults
from propermodel.diagnostics import StructureError
from tests.faults.structure_cases import HardMass, OneWay
from tests.parts import (
    Damper,
    Flywheel,
    Force,
    Gear,
    Ground,
    Mass,
    Resistor,
    Spring,
    Velocity,
    Voltage,
)


class Workshop(Component):
    """Five faults at five places, and a sound oscillator between two of them."""

    road, shaker, crank = Velocity(velocity=1.0), Velocity(velocity=2.0), Velocity(velocity=3.0)
    body = Mass(mass=1.0)
    mains, battery = Voltage(voltage=230.0), Voltage(voltage=12.0)
    lamp, ground = Resistor(resistance=10.0), Ground()
    push, brake = Force(force=1.0), OneWay()
    up, down, wheel = Gear(ratio=2.0), Gear(ratio=0.5), Flywheel(inertia=1.0)
    belt, load = Velocity(velocity=1.0), HardMass()
    spring, damper, mass = Spring(stiffness=1.0), Damper(damping=1.0), Mass(mass=1.0)

    connections = (
        connect(road.flange, shaker.flange, crank.flange, body.flange, spring.a),
        connect(mains.a, battery.a, lamp.a),
        connect(mains.b, battery.b, lamp.b, ground.pin),
        connect(push.flange, brake.port),
        connect(up.a, down.b, wheel.shaft),
        connect(up.b, down.a),
        connect(belt.flange, load.flange, damper.a),
        connect(spring.b, mass.flange, damper.b),
    )


def test_a_model_with_five_faults_is_told_all_five():
    with pytest.raises(StructureError) as caught:
        pm.compile_model(pm.elaborate(Workshop()))
    found = [(d.code, d.message, [i.path for i in d.involved]) for d in caught.value.diagnostics]
    assert found == [
        (
            "causality/transformer-loop",
            "up and down close a loop of the ratio 1: nothing decides how they share the torque",
            ["up", "down"],
        ),
        (
            "causality/conflict",
            "three flow sources set the velocity of one junction",
            ["road", "shaker", "crank"],
        ),
        ("causality/conflict", "two effort sources set the voltage of one junction", ["mains", "battery"]),
        (
            "causality/conflict",
            "nothing sets the velocity of one junction: every bond prescribes its other variable",
            ["push", "brake"],
        ),
        (
            "causality/no-inverse",
            (
                "the velocity of the storage load is decided elsewhere, and its law cannot be inverted: "
                "it is flat from 100 to 1000 N.s"
            ),
            ["belt"],
        ),
    ]


def test_a_law_that_can_be_inverted_is_no_fault():
    class Pushed(Component):
        push, damper, clamp = Force(force=1.0), Damper(damping=1.0), Velocity(velocity=1.0)
        connections = (connect(push.flange, damper.a), connect(damper.b, clamp.flange))

    assert causal_faults(flatten(pm.elaborate(Pushed()))) == []
