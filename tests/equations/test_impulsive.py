"""Storage that sources decide alone: who is warned about whom."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel import Component, FlowSource, Input, Port, Translation, connect
from propermodel.compiler import compile_quietly
from propermodel.equations.impulsive import impulsive_sources
from tests.parts import (
    Capacitor,
    Damper,
    Fixed,
    Flywheel,
    Force,
    Gear,
    Ground,
    Lever,
    Mass,
    Motor,
    Resistor,
    Spring,
    Torque,
    Velocity,
    Voltage,
)
from tests.physics.systems import system


def warned(component: Component) -> list[tuple[str, ...]]:
    """The sources and the storage of each warning."""
    found = impulsive_sources(compile_quietly(pm.elaborate(component)).system)
    return [tuple(item.path for item in diagnostic.involved) for diagnostic in found]


class Follower(FlowSource):
    """Moves at the speed that it is told."""

    flange = Port(Translation)
    speed = Input("m/s")

    def flow(self):
        return self.speed


def test_a_mass_that_is_carried():
    shaker, mass, spring, wall = Velocity(velocity=1.0), Mass(mass=1.0), Spring(stiffness=1.0), Fixed()
    alone = system(connect(shaker.flange, mass.flange), shaker=shaker, mass=mass)
    assert warned(alone) == [("shaker", "mass")]
    held = system(
        connect(shaker.flange, mass.flange, spring.a),
        connect(spring.b, wall.flange),
        shaker=shaker,
        mass=mass,
        spring=spring,
        wall=wall,
    )
    assert warned(held) == [("shaker", "mass")]


def test_a_mass_behind_a_compliance_is_free_of_impulses():
    shaker, mass, spring = Velocity(velocity=1.0), Mass(mass=1.0), Spring(stiffness=1.0)
    parts = {"shaker": shaker, "mass": mass, "spring": spring}
    assert warned(system(connect(shaker.flange, spring.a), connect(spring.b, mass.flange), **parts)) == []


def test_a_capacitor_across_a_voltage_and_one_behind_a_resistor():
    cell, store, ground, resistor = Voltage(voltage=1.0), Capacitor(capacitance=1.0), Ground(), Resistor(resistance=1.0)
    across = system(
        connect(cell.a, store.a), connect(cell.b, store.b, ground.pin), cell=cell, store=store, ground=ground
    )
    assert warned(across) == [("cell", "store")]
    charged = system(
        connect(cell.a, resistor.a),
        connect(resistor.b, store.a),
        connect(cell.b, store.b, ground.pin),
        cell=cell,
        store=store,
        ground=ground,
        resistor=resistor,
    )
    assert warned(charged) == []


def test_sources_reach_through_levers_and_motors():
    shaker, lever, mass = Velocity(velocity=1.0), Lever(ratio=2.0), Mass(mass=1.0)
    levered = system(
        connect(shaker.flange, lever.a), connect(lever.b, mass.flange), shaker=shaker, lever=lever, mass=mass
    )
    assert warned(levered) == [("shaker", "mass")]
    cell, motor, rotor, ground = Voltage(voltage=1.0), Motor(constant=1.0), Flywheel(inertia=1.0), Ground()
    turned = system(
        connect(cell.a, motor.a),
        connect(cell.b, ground.pin),
        connect(motor.b, rotor.shaft),
        cell=cell,
        motor=motor,
        rotor=rotor,
        ground=ground,
    )
    assert warned(turned) == [("cell", "rotor")]


def test_what_follows_other_storage_is_no_matter_of_sources():
    one, two, gear, torque = Flywheel(inertia=1.0), Flywheel(inertia=2.0), Gear(ratio=2.0), Torque(torque=1.0)
    geared = system(
        connect(one.shaft, gear.a, torque.shaft), connect(gear.b, two.shaft), one=one, two=two, gear=gear, torque=torque
    )
    assert warned(geared) == []


def test_a_source_that_follows_a_state_does_not_jump():
    leader, push, follower, mass = Mass(mass=1.0), Force(force=1.0), Follower(), Mass(mass=2.0)
    follows = system(
        connect(leader.flange, push.flange),
        connect(leader.flange.flow, follower.speed),
        connect(follower.flange, mass.flange),
        leader=leader,
        push=push,
        follower=follower,
        mass=mass,
    )
    assert warned(follows) == []


def test_the_text_names_the_variables_and_the_cure():
    shaker, mass = Velocity(velocity=1.0), Mass(mass=1.0)
    carried = system(connect(shaker.flange, mass.flange), shaker=shaker, mass=mass)
    with pytest.warns(pm.ModelWarning) as shown:
        compiled = pm.compile_model(pm.elaborate(carried))
    text = str(shown[0].message)
    assert text.startswith(
        "warning[equations/impulsive]: nothing but shaker decides the velocity of mass: where that jumps, "
        "its force is an impulse\n"
    )
    assert text.endswith("help: put a compliance between them, or drive it with an effort source")
    run = pm.simulate(compiled, pm.Scenario(stop=0.1), step=1e-3)
    assert run.at_end("mass.momentum") == pytest.approx(1.0)
    assert run.at_end("mass.flange.effort") == pytest.approx(0.0)


def test_a_damper_does_not_decide():
    shaker, damper, mass = Velocity(velocity=1.0), Damper(damping=1.0), Mass(mass=1.0)
    dragged = system(
        connect(shaker.flange, damper.a), connect(damper.b, mass.flange), shaker=shaker, damper=damper, mass=mass
    )
    assert warned(dragged) == []
