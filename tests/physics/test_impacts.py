"""Impulses at events: restitution, rest, and what else an impulse moves, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend
from propermodel.diagnostics import Path
from propermodel.expressions import Expr
from propermodel.library.mechanics.translation import (
    Damper,
    Fixed,
    ForceSource,
    Impact,
    Mass,
    MotionSensor,
    Spring,
    VelocitySource,
    Weight,
)
from propermodel.modelling import (
    Component,
    Discrete,
    Input,
    Parameter,
    Port,
    Resistance,
    SignalBlock,
    State,
    TableValues,
    Transformer,
    Translation,
    connect,
    elaborate,
    parameter,
    quantity,
    when,
)
from propermodel.modelling.documents import from_document, to_document
from tests.physics.systems import close, compiled, run, system

BACKENDS = pytest.mark.parametrize("backend", list(Backend))
GRAVITY = 10.0


# -- rest -------------------------------------------------------------------------------------------------


class Bouncing(Component):
    """A ball of 2 kg that falls from 1 m; a hand may lift it."""

    lift = Input("N")
    ball = Mass(mass=2.0)
    weight = Weight(mass=2.0, gravity=GRAVITY)
    hand = ForceSource()
    floor = Fixed()
    impact = Impact(start_gap=1.0, restitution=0.8, rest_speed=1e-3)

    connections = (
        connect(ball.flange, weight.flange, hand.flange, impact.b),
        connect(floor.flange, impact.a),
        connect(lift, hand.force),
    )


@BACKENDS
def test_a_ball_bounces_in_its_closed_form_and_comes_to_rest(backend: Backend):
    r = run(Bouncing(), 6.0, backend=backend, step=1e-2, inputs={"lift": 0.0})
    first = math.sqrt(2.0 / GRAVITY)
    speeds = GRAVITY * first * 0.8 ** np.arange(100)
    slow = int(np.argmax(speeds <= 1e-3))
    assert len(r.events) == slow + 1
    expected = first + np.concatenate(([0.0], np.cumsum(2.0 * 0.8 * speeds[:slow] / GRAVITY)))
    assert [e.time for e in r.events] == pytest.approx(expected, abs=1e-11)
    kept = np.where(np.arange(slow + 1) < slow, 0.8**2, 0.0)
    assert [e.lost for e in r.events] == pytest.approx(speeds[: slow + 1] ** 2 * (1.0 - kept), rel=1e-7)
    resting = r.time > expected[-1]
    assert not np.any(r["ball.flange.flow"][resting])
    close(r["impact.contact.port.effort"][resting], np.full(resting.sum(), 20.0), 1e-12)
    assert abs(r.at_end("impact.gap")) < 1e-14
    balance = energy_balance(r)
    assert balance.lost_in_events == pytest.approx(20.0, rel=1e-12)
    assert balance.relative_residual < 1e-12


@BACKENDS
def test_a_body_at_rest_leaves_when_it_is_pulled_and_only_then(backend: Backend):
    # It rests at 4.03 s; a force that grows with 10 N/s from 5 s lifts 20 N at 7 s: x = 10 (t - 7)^3 / (6 m).
    lift = TableValues(((0.0, 5.0, 9.0),), (0.0, 0.0, 40.0))
    r = run(Bouncing(), 8.0, backend=backend, step=1e-2, inputs={"lift": lift})
    assert r.events[-1].time == pytest.approx(7.0, abs=1e-10)
    assert r.events[-1].lost == 0.0
    assert r.at_end("impact.gap") == pytest.approx(10.0 / 12.0, rel=1e-9)


# -- collisions -------------------------------------------------------------------------------------------


class Colliding(Component):
    """A mass that overtakes another."""

    one = Mass(mass=2.0, start_velocity=3.0)
    other = Mass(mass=5.0, start_velocity=-1.0)
    impact = Impact(start_gap=1.0, restitution=0.6)

    connections = (connect(one.flange, impact.a), connect(other.flange, impact.b))


@BACKENDS
def test_two_masses_that_collide_keep_their_momentum_and_obey_newtons_restitution(backend: Backend):
    r = run(Colliding(), 1.0, backend=backend, step=1e-2)
    (event,) = r.events
    assert event.time == pytest.approx(0.25, abs=1e-12)
    u, v = r.at_end("one.flange.flow"), r.at_end("other.flange.flow")
    assert 2.0 * u + 5.0 * v == pytest.approx(2.0 * 3.0 - 5.0, abs=1e-13)
    assert v - u == pytest.approx(0.6 * 4.0, rel=1e-13)
    reduced = 2.0 * 5.0 / 7.0
    assert event.lost == pytest.approx(0.5 * reduced * 4.0**2 * (1.0 - 0.6**2), rel=1e-12)
    assert energy_balance(r).relative_residual < 1e-12


@BACKENDS
def test_balls_in_a_row_pass_the_blow_on(backend: Backend):
    class Cradle(Component):
        a = Mass(mass=1.0, start_velocity=2.0)
        b = Mass(mass=1.0)
        c = Mass(mass=1.0)
        first = Impact(start_gap=0.5, restitution=1.0)
        second = Impact(start_gap=0.0, restitution=1.0)

        connections = (connect(a.flange, first.a), connect(b.flange, first.b, second.a), connect(c.flange, second.b))

    # They touch: a rounding apart, so that the second impact follows at the first's instant.
    r = run(Cradle(), 0.5, backend=backend, step=1e-2)
    assert [e.time for e in r.events] == pytest.approx([0.25, 0.25], abs=1e-11)
    speeds = [r.at_end(f"{name}.flange.flow") for name in "abc"]
    assert speeds == pytest.approx([0.0, 0.0, 2.0], abs=1e-12)


@BACKENDS
def test_a_ball_on_a_floor_on_a_spring_bounces_as_a_hand_written_solution_says(backend: Backend):
    class SoftFloor(Component):
        ball = Mass(mass=1.0)
        floor = Mass(mass=4.0)
        weight = Weight(mass=1.0, gravity=GRAVITY)
        spring = Spring(stiffness=400.0)
        ground = Fixed()
        impact = Impact(start_gap=0.2, restitution=0.7, rest_speed=1e-9)

        connections = (
            connect(ball.flange, weight.flange, impact.b),
            connect(floor.flange, impact.a, spring.a),
            connect(spring.b, ground.flange),
        )

    # Free motion between impacts: x = x0 + v0 t - g t^2 / 2, y = y0 cos(w t) + w0 sin(w t) / w.
    omega = 10.0
    t, x, v, y, w = 0.0, 0.2, 0.0, 0.0, 0.0
    hits: list[float] = []
    while True:
        grid = np.arange(1e-7, 1.6, 1e-4)

        def gap(s, x=x, v=v, y=y, w=w):
            return x + v * s - 0.5 * GRAVITY * s * s - y * np.cos(omega * s) - w / omega * np.sin(omega * s)

        below = np.flatnonzero(gap(grid) < 0.0)
        if t + grid[below[0]] > 0.98:  # soon they are shorter than the grid
            break
        low, high = grid[below[0] - 1], grid[below[0]]
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if gap(middle) < 0.0 else (middle, high)
        s = high
        x, v = x + v * s - 0.5 * GRAVITY * s * s, v - GRAVITY * s
        y, w = (
            y * np.cos(omega * s) + w / omega * np.sin(omega * s),
            w * np.cos(omega * s) - omega * y * np.sin(omega * s),
        )
        impulse = 1.7 * (w - v) / (1.0 / 1.0 + 1.0 / 4.0)
        v, w = v + impulse / 1.0, w - impulse / 4.0
        t += s
        hits.append(t)
    assert len(hits) >= 15
    r = run(SoftFloor(), 1.5, backend=backend, step=1e-3)
    assert [e.time for e in r.events[: len(hits)]] == pytest.approx(hits, abs=1e-9)
    # In the end the ball rides on the floor: 5 kg on the spring, pressed down by 10 N.
    riding = r.time > r.events[-1].time
    y, w, t = (r[name][riding] for name in ("spring.port.displacement", "ball.flange.flow", "floor.flange.flow"))
    assert riding.sum() > 20
    close(w, t, 1e-12)
    energy = 0.5 * 5.0 * w**2 + 0.5 * 400.0 * y**2 + 10.0 * y
    close(energy, np.full_like(energy, energy[0]), 1e-7)
    assert energy_balance(r).relative_residual < 1e-8


# -- what else an impulse moves -----------------------------------------------------------------------------


class Gear(Transformer):
    """A lever with velocities in the ratio of its arms."""

    a = Port(Translation)
    b = Port(Translation)
    ratio: Parameter = parameter("1")

    def modulus(self) -> Expr:
        return self.ratio


@BACKENDS
def test_an_impulse_reaches_dependent_storage_through_a_transformer(backend: Backend):
    near, far = Mass(mass=2.0, start_velocity=3.0), Mass(mass=1.0, start_velocity=6.0)
    gear, impact, wall = Gear(ratio=2.0), Impact(start_gap=0.3, restitution=0.5), Fixed()
    model = system(
        connect(near.flange, gear.a, impact.a),
        connect(gear.b, far.flange),
        connect(impact.b, wall.flange),
        near=near,
        far=far,
        gear=gear,
        impact=impact,
        wall=wall,
    )
    r = run(model, 0.2, backend=backend, step=1e-2)
    (event,) = r.events
    assert r.at_end("near.flange.flow") == pytest.approx(-1.5, rel=1e-13)
    assert r.at_end("far.flange.flow") == pytest.approx(-3.0, rel=1e-13)
    # The mass at the end of the lever counts four times: 2 kg + 4 kg.
    assert event.lost == pytest.approx(0.5 * 6.0 * 9.0 * (1.0 - 0.25), rel=1e-12)


@BACKENDS
def test_two_bodies_that_strike_a_third_at_once_share_the_loss(backend: Backend):
    left, middle, right = Mass(mass=1.0, start_velocity=2.0), Mass(mass=3.0), Mass(mass=1.0, start_velocity=-2.0)
    one, two = Impact(start_gap=0.5, restitution=0.0), Impact(start_gap=0.5, restitution=0.5)
    model = system(
        connect(left.flange, one.a),
        connect(middle.flange, one.b, two.a),
        connect(right.flange, two.b),
        left=left,
        middle=middle,
        right=right,
        one=one,
        two=two,
    )
    r = run(model, 0.3, backend=backend, step=1e-2)
    first, second = r.events[:2]
    assert first.time == second.time == pytest.approx(0.25, abs=1e-12)
    u, v, w = (r.at_end(f"{name}.flange.flow") for name in ("left", "middle", "right"))
    assert u - v == pytest.approx(0.0, abs=1e-13)
    assert w - v == pytest.approx(0.5 * 2.0, rel=1e-13)
    assert u + 3.0 * v + w == pytest.approx(0.0, abs=1e-13)
    assert first.lost + second.lost == pytest.approx(4.0 - 0.5 * (u * u + 3.0 * v * v + w * w), rel=1e-12)
    # The work of each impulse: its impulse times the mean of its flow before and after.
    ratio = (2.0 - u) * 1.0 / ((w + 2.0) * 0.5)
    assert first.lost / second.lost == pytest.approx(ratio, rel=1e-12)


class Brake(Resistance):
    """Holds what it is connected to while it is closed, against any force."""

    flange = Port(Translation)
    closed = Input("1")

    def effort(self, flow: Expr) -> Expr:
        return quantity(0.0, "N.s/m") * flow

    def locked(self) -> Expr:
        """While it is closed."""
        return self.closed > 0.5


@BACKENDS
@pytest.mark.parametrize("closed", [0.0, 1.0])
def test_what_is_locked_bears_the_impulse(backend: Backend, closed: float):
    class Rig(Component):
        pedal = Input("1")
        ball = Mass(mass=1.0, start_velocity=1.0)
        block = Mass(mass=3.0)
        brake = Brake()
        impact = Impact(start_gap=0.1, restitution=0.5)

        connections = (
            connect(ball.flange, impact.a),
            connect(block.flange, impact.b, brake.flange),
            connect(pedal, brake.closed),
        )

    r = run(Rig(), 0.2, backend=backend, step=1e-2, inputs={"pedal": closed})
    assert len(r.events) == 1
    free = 1.5 / (1.0 + 1.0 / 3.0)
    assert r.at_end("ball.flange.flow") == pytest.approx(-0.5 if closed else 1.0 - free, rel=1e-12)
    assert r.at_end("block.flange.flow") == pytest.approx(0.0 if closed else free / 3.0, abs=1e-13)


@BACKENDS
def test_a_signal_that_integrates_the_force_of_a_contact_takes_up_the_impulse(backend: Backend):
    class Latch(Resistance):
        """Stops what reaches a distance, for good."""

        flange = Port(Translation)
        covered = Input("m")
        distance: Parameter = parameter("m", default=0.5)
        caught = Discrete("1")

        def effort(self, flow: Expr) -> Expr:
            return quantity(0.0, "N.s/m") * flow

        def locked(self) -> Expr:
            return self.caught > 0.5

        def events(self):
            return (when(self.covered > self.distance, {self.caught: 1.0}, restitution=0.0),)

    class Gauge(SignalBlock):
        """The impulse of a force."""

        force = Input("N")
        total = State("N.s")

        def derivatives(self):
            return {self.total: self.force}

        def outputs(self):
            return {}

    class Caught(Component):
        mass = Mass(mass=2.0, start_velocity=2.0)
        damper = Damper(damping=0.0)
        wall = Fixed()
        sensor = MotionSensor()
        latch = Latch()
        gauge = Gauge()

        connections = (
            connect(mass.flange, damper.a, sensor.flange, latch.flange),
            connect(damper.b, wall.flange),
            connect(sensor.position, latch.covered),
            connect(latch.flange.effort, gauge.force),
        )

    r = run(Caught(), 1.0, backend=backend, step=1e-2)
    (event,) = r.events
    assert event.element == Path(("latch",))
    assert event.time == pytest.approx(0.25, abs=1e-12)
    assert r.at_end("mass.flange.flow") == 0.0
    assert abs(r.at_end("gauge.total")) == pytest.approx(4.0, rel=1e-13)
    assert r.at_end("sensor.position") == pytest.approx(0.5, rel=1e-12)


@BACKENDS
def test_a_moving_wall_strikes_with_its_own_velocity(backend: Backend):
    class Struck(Component):
        speed = Input("m/s")
        wall = VelocitySource()
        ball = Mass(mass=2.0)
        impact = Impact(start_gap=0.5, restitution=0.5)

        connections = (
            connect(speed, wall.velocity),
            connect(wall.flange, impact.a),
            connect(ball.flange, impact.b),
        )

    r = run(Struck(), 1.0, backend=backend, step=1e-2, inputs={"speed": 1.0})
    assert r.at_end("ball.flange.flow") == pytest.approx(1.5, rel=1e-13)


def test_an_impact_comes_back_from_its_document_and_runs_the_same():
    model = elaborate(Bouncing())
    again = from_document(to_document(model))
    assert again == model
    one, other = (run(compiled(m), 2.0, step=1e-2, inputs={"lift": 0.0}) for m in (model, again))
    assert one.events == other.events
    assert len(one.events) == 3
