"""Friction that sticks and clutches that lock, at located instants, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, Method
from propermodel.library.mechanics.rotation import FixedShaft, LockingClutch, RotatingInertia, TorqueSource
from propermodel.library.mechanics.rotation import StickingFriction as RotationalFriction
from propermodel.library.mechanics.translation import (
    Fixed,
    ForceSource,
    Impact,
    Mass,
    MotionSensor,
    Spring,
    StickingFriction,
    VelocitySource,
)
from propermodel.modelling import Component, Input, TableValues, connect, elaborate
from propermodel.modelling.documents import from_document, to_document
from tests.physics.systems import close, compiled, run

BACKENDS = pytest.mark.parametrize("backend", list(Backend))
MASS, FORCE = 2.0, 6.0  # slows with 3 m/s2


class Sliding(Component):
    """A block on the floor, with a force on it."""

    push = Input("N")
    block = Mass(mass=MASS)
    sensor = MotionSensor()
    friction = StickingFriction(force=FORCE, breakaway=1.5)
    hand = ForceSource()
    floor = Fixed()

    connections = (
        connect(block.flange, sensor.flange, friction.a, hand.flange),
        connect(friction.b, floor.flange),
        connect(push, hand.force),
    )


@BACKENDS
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_a_block_stops_at_its_stopping_distance_and_stays(backend: Backend, speed: float):
    r = run(Sliding(), 3.0, backend=backend, step=1e-2, inputs={"push": 0.0}, initial={"block.flange.flow": speed})
    begins, stops = r.events
    assert begins.time == 0.0
    assert stops.time == pytest.approx(1.0, abs=1e-11)
    distance = r["sensor.position"]
    assert distance[-1] == pytest.approx(math.copysign(speed**2 / (2.0 * FORCE / MASS), speed), rel=1e-11)
    resting = r.time > stops.time
    assert not np.any(r["block.flange.flow"][resting])
    assert np.all(distance[resting] == distance[-1])
    balance = energy_balance(r)
    assert balance.dissipated == pytest.approx(9.0, rel=1e-11)
    assert balance.relative_residual < 1e-11


@pytest.mark.parametrize("method", list(Method))
def test_a_block_stays_where_it_has_stopped_with_every_method(method: Method):
    r = run(Sliding(), 1.5, method=method, inputs={"push": 2.0}, initial={"block.flange.flow": 2.0})
    assert [e.time for e in r.events] == pytest.approx([0.0, 1.0], abs=1e-11)  # (6 - 2) N slow 2 kg
    assert not np.any(r["block.flange.flow"][r.time > 1.0 + 1e-9])
    assert r.at_end("friction.port.effort") == pytest.approx(2.0, rel=1e-12)


@BACKENDS
def test_a_block_slips_when_the_force_exceeds_what_holds_it(backend: Backend):
    # The force grows with 3 N/s: 9 N at 3 s. Then 2 v' = 3 t - 6.
    ramp = TableValues(((0.0, 10.0),), (0.0, 30.0))
    r = run(Sliding(), 5.0, backend=backend, step=1e-2, inputs={"push": ramp})
    (event,) = r.events
    assert event.time == pytest.approx(3.0, abs=1e-11)
    t = r.time
    speed = np.where(t > 3.0, 0.75 * (t**2 - 9.0) - 3.0 * (t - 3.0), 0.0)
    close(r["block.flange.flow"], speed, 1e-10)
    held = np.where(t < 3.0, 3.0 * t, FORCE)
    outside = np.abs(t - 3.0) > 1e-9
    close(r["friction.port.effort"][outside], held[outside], 1e-10)


@BACKENDS
def test_stick_slip_on_a_belt_has_the_period_and_amplitude_of_its_event_wise_solution(backend: Backend):
    class Belt(Component):
        speed = Input("m/s")
        belt = VelocitySource()
        block = Mass(mass=1.0)
        spring = Spring(stiffness=25.0)
        friction = StickingFriction(force=5.0, breakaway=1.6)
        wall = Fixed()

        connections = (
            connect(speed, belt.velocity),
            connect(belt.flange, friction.a),
            connect(block.flange, friction.b, spring.a),
            connect(spring.b, wall.flange),
        )

    stiffness, omega, speed = 25.0, 5.0, 0.5
    excess = (8.0 - 5.0) / stiffness  # between breakaway and sliding force, as a displacement
    slipping = 2.0 * (math.pi - math.atan(excess * omega / speed)) / omega
    sticking = 2.0 * excess / speed
    until, count = (6.0, 6) if backend is Backend.NATIVE else (2.6, 3)
    r = run(Belt(), until, backend=backend, step=1e-3, inputs={"speed": speed}, initial={"block.flange.flow": speed})
    first = 8.0 / stiffness / speed
    expected: list[float] = []
    for k in range(4):
        begins = first + k * (slipping + sticking)
        expected += [begins, begins + slipping]
    assert [e.time for e in r.events][:count] == pytest.approx(expected[:count], abs=1e-9)
    assert r["spring.port.displacement"].max() == pytest.approx(0.2 + math.hypot(excess, speed / omega), rel=1e-3)
    stuck = (r.time > expected[1] + 1e-9) & (r.time < expected[2] - 1e-9)
    assert stuck.sum() > 3
    close(r["block.flange.flow"][stuck], np.full(stuck.sum(), speed), 1e-12)
    position = 0.2 - excess + speed * (r.time[stuck] - expected[1])
    close(r["spring.port.displacement"][stuck], position, 1e-9)
    assert energy_balance(r).relative_residual < 1e-8


@BACKENDS
def test_a_block_that_bounces_slides_back_until_it_stops(backend: Backend):
    class Yard(Component):
        block = Mass(mass=MASS, start_velocity=5.0)
        friction = StickingFriction(force=FORCE)
        impact = Impact(start_gap=1.5, restitution=0.5)
        floor = Fixed()

        connections = (
            connect(block.flange, friction.a, impact.a),
            connect(floor.flange, friction.b, impact.b),
        )

    r = run(Yard(), 3.0, backend=backend, step=1e-2)
    # It hits with sqrt(25 - 2 3 1.5) = 4 m/s after 1/3 s, goes back with 2 m/s, and stops after 2/3 s and 2/3 m.
    assert [e.time for e in r.events] == pytest.approx([0.0, 1.0 / 3.0, 1.0 / 3.0, 1.0], abs=1e-11)
    assert r.at_end("impact.gap") == pytest.approx(2.0 / 3.0, rel=1e-10)
    balance = energy_balance(r)
    assert balance.lost_in_events == pytest.approx(0.5 * MASS * (16.0 - 4.0), rel=1e-10)
    assert balance.relative_residual < 1e-11


@BACKENDS
def test_a_blow_makes_a_block_slip_that_sticks(backend: Backend):
    class Struck(Component):
        ball = Mass(mass=1.0, start_velocity=3.0)
        block = Mass(mass=MASS)
        friction = StickingFriction(force=FORCE)
        impact = Impact(start_gap=0.3, restitution=0.5)
        sensor = MotionSensor()
        floor = Fixed()

        connections = (
            connect(ball.flange, impact.a),
            connect(block.flange, friction.a, impact.b, sensor.flange),
            connect(floor.flange, friction.b),
        )

    r = run(Struck(), 1.0, backend=backend, step=1e-2)
    speed = 1.5 * 3.0 * 1.0 / 3.0  # of the block after the blow
    assert r.at_end("ball.flange.flow") == pytest.approx(0.0, abs=1e-12)
    assert [e.time for e in r.events] == pytest.approx([0.1, 0.1, 0.1 + speed / 3.0], abs=1e-11)
    assert r.at_end("sensor.position") == pytest.approx(speed**2 / 6.0, rel=1e-10)


@BACKENDS
def test_a_clutch_locks_keeps_momentum_and_lets_go(backend: Backend):
    class Driveline(Component):
        capacity = Input("N.m")
        torque = Input("N.m")
        engine = RotatingInertia(inertia=0.5, start_speed=100.0)
        load = RotatingInertia(inertia=2.0, start_speed=20.0)
        clutch = LockingClutch()
        motor = TorqueSource()

        connections = (
            connect(engine.shaft, clutch.a, motor.shaft),
            connect(load.shaft, clutch.b),
            connect(capacity, clutch.capacity),
            connect(torque, motor.torque),
        )

    # The torque begins at 1 s and grows with 25 N.m/s; the load takes 2 / 2.5 of it: 40 N.m at 3 s.
    torque = TableValues(((0.0, 1.0, 5.0),), (0.0, 0.0, 100.0))
    r = run(Driveline(), 4.0, backend=backend, step=1e-2, inputs={"capacity": 40.0, "torque": torque})
    reduced, common = 0.5 * 2.0 / 2.5, (0.5 * 100.0 + 2.0 * 20.0) / 2.5
    starts, closes, opens = r.events
    assert starts.time == 0.0
    assert closes.time == pytest.approx(80.0 * reduced / 40.0, abs=1e-11)
    assert opens.time == pytest.approx(3.0, abs=1e-9)
    locked = (r.time > closes.time + 1e-9) & (r.time < 1.0 - 1e-9)
    close(r["engine.shaft.flow"][locked], np.full(locked.sum(), common), 1e-10)
    assert np.abs(r["clutch.port.flow"][(r.time > closes.time + 1e-9) & (r.time < 3.0 - 1e-9)]).max() < 1e-11
    before = run(Driveline(), 0.95, backend=backend, step=1e-2, inputs={"capacity": 40.0, "torque": torque})
    assert energy_balance(before).dissipated == pytest.approx(0.5 * reduced * 80.0**2, rel=1e-10)
    # Afterwards 0.5 w' = 25 (t - 1) - 40 and 2 w' = 40.
    assert r.at_end("clutch.port.flow") == pytest.approx(50.0 * 2.5 - 80.0 - 20.0, rel=1e-8)
    assert energy_balance(r).relative_residual < 1e-9


@BACKENDS
def test_a_rotor_with_dry_friction_stops_and_stays(backend: Backend):
    class Rotor(Component):
        rotor = RotatingInertia(inertia=0.5, start_speed=-8.0)
        friction = RotationalFriction(torque=2.0)
        frame = FixedShaft()

        connections = (connect(rotor.shaft, friction.a), connect(friction.b, frame.shaft))

    r = run(Rotor(), 3.0, backend=backend, step=1e-2)
    assert [e.time for e in r.events] == pytest.approx([0.0, 2.0], abs=1e-11)
    assert not np.any(r["rotor.shaft.flow"][r.time > r.events[-1].time])
    assert energy_balance(r).dissipated == pytest.approx(16.0, rel=1e-11)


def test_friction_comes_back_from_its_document_and_runs_the_same():
    model = elaborate(Sliding())
    again = from_document(to_document(model))
    assert again == model
    given = {"inputs": {"push": 0.0}, "initial": {"block.flange.flow": 3.0}}
    one, other = (run(compiled(m), 2.0, step=1e-2, **given) for m in (model, again))
    assert one.events == other.events
    assert len(one.events) == 2
