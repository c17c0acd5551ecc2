"""Events of a run: instants and jumps against closed forms, on both backends; runs whose events have no end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path as FilePath

import numpy as np
import pytest

from propermodel import (
    Backend,
    CompiledModel,
    Component,
    Controller,
    Discrete,
    Input,
    Method,
    Output,
    Parameter,
    Path,
    Scenario,
    SignalBlock,
    State,
    Trajectory,
    compile_model,
    connect,
    elaborate,
    energy_balance,
    load_trajectory,
    parameter,
    quantity,
    save_trajectory,
    simulate,
    time,
    when,
    where,
)
from propermodel.diagnostics import parse_path
from propermodel.modelling.documents import from_document, to_document
from propermodel.simulation.trajectory import RunStatus
from tests.event_parts import BouncingBall, Heated, SlowingMass, Winding
from tests.parts import Damper, Fixed, Mass

BACKENDS = pytest.mark.parametrize("backend", list(Backend))
GRAVITY = 10.0  # m/s2
FIRST_HIT = math.sqrt(2.0 / GRAVITY)  # s, from 1 m
ENDS = FIRST_HIT * (1.0 + 2.0 * 0.8 / (1.0 - 0.8))  # s, the limit of the instants of a ball with restitution 0.8


def compiled(component: Component, backend: Backend = Backend.NATIVE) -> CompiledModel:
    return compile_model(elaborate(component), backend=backend)


def run(
    model: CompiledModel,
    stop: float,
    *,
    step: float = 1e-2,
    initial: Mapping[str, float] | None = None,
    method: Method = Method.RK4,
) -> Trajectory:
    start = {parse_path(name): value for name, value in (initial or {}).items()}
    return simulate(model, Scenario(stop=stop, initial=start), method=method, step=step, record_every=0.05)


# -- a ball ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", [Method.RK4, Method.ROS2, Method.RODAS, Method.DOPRI5])
@BACKENDS
def test_a_ball_bounces_at_the_instants_and_with_the_speeds_of_its_closed_form(backend: Backend, method: Method):
    answer = run(compiled(BouncingBall(), backend), 3.5, method=method)
    assert answer.ending.is_complete
    assert len(answer.events) == 9
    at, speed = FIRST_HIT, GRAVITY * FIRST_HIT
    for event in answer.events:
        assert event.element == Path(("ball",))
        assert event.time == pytest.approx(at, abs=1e-12)
        assert event.energy_before == pytest.approx(speed**2, rel=1e-11)
        assert event.lost == pytest.approx(speed**2 * (1.0 - 0.8**2), rel=1e-11)
        speed *= 0.8
        at += 2.0 * speed / GRAVITY


def test_the_heights_between_bounces_are_those_of_the_closed_form():
    answer = run(compiled(BouncingBall()), 3.0)
    hits = [event.time for event in answer.events]
    heights = answer["height.x"]
    for k, (begin, end) in enumerate(pairwise(hits)):
        inside = (answer.time > begin) & (answer.time < end)
        t = answer.time[inside] - begin
        expected = GRAVITY * FIRST_HIT * 0.8 ** (k + 1) * t - 0.5 * GRAVITY * t**2
        assert inside.sum() > 3
        np.testing.assert_allclose(heights[inside], expected, atol=1e-11)


def test_a_row_stands_on_either_side_of_an_event():
    answer = run(compiled(BouncingBall()), 0.6)
    (event,) = answer.events
    (before, after) = np.flatnonzero(answer.time == event.time)
    assert answer["ball.momentum"][after] == pytest.approx(-0.8 * answer["ball.momentum"][before], rel=1e-14)
    assert np.all(np.diff(answer.time) >= 0.0)


@BACKENDS
def test_a_ball_that_comes_to_rest_ends_the_run_and_never_falls_through_the_floor(backend: Backend):
    answer = run(compiled(BouncingBall(), backend), 6.0)
    assert answer.ending.status is RunStatus.CHATTERING
    assert answer.ending.path == Path(("ball",))
    assert "ball" in answer.ending.message
    assert answer.ending.time == pytest.approx(ENDS, abs=1e-9)
    assert answer["height.x"].min() > -1e-12
    assert answer.at_end("height.x") == pytest.approx(0.0, abs=1e-12)


def test_what_events_lose_is_in_the_energy_balance():
    balance = energy_balance(run(compiled(BouncingBall()), 6.0))
    assert balance.lost_in_events == pytest.approx(20.0, rel=1e-10)  # 2 kg from 1 m
    assert balance.supplied == pytest.approx(20.0, rel=1e-10)
    assert balance.relative_residual < 1e-12
    assert "lost in events 20 J" in str(balance)


@pytest.mark.parametrize("method", list(Method))
def test_both_backends_do_the_same_with_every_method(method: Method):
    first, second = (
        simulate(compiled(BouncingBall(), backend), Scenario(stop=2.0), method=method, step=1e-2) for backend in Backend
    )
    assert len(first.events) >= 3
    assert [event.time for event in first.events] == pytest.approx([e.time for e in second.events], abs=1e-13)
    np.testing.assert_allclose(first.final_signals, second.final_signals, rtol=1e-12, atol=1e-12)


def test_a_continued_run_has_the_events_of_one_that_was_not_interrupted():
    model = compiled(BouncingBall())
    whole = run(model, 2.5)
    part = run(model, 1.3)
    rest = simulate(model, Scenario(stop=2.5), method=Method.RK4, step=1e-2, record_every=0.05, continued_from=part)
    assert 0 < len(part.events) < len(rest.events)
    assert [e.time for e in rest.events] == pytest.approx([e.time for e in whole.events], abs=1e-12)
    assert energy_balance(rest).relative_residual < 1e-12


# -- held values ----------------------------------------------------------------------------------------


@BACKENDS
def test_a_switch_with_hysteresis_has_the_period_of_its_closed_form(backend: Backend):
    answer = run(compiled(Heated(), backend), 2.0, step=1e-2)
    # It is colder than its lower threshold at the start.
    off = math.log((2.0 - 0.5) / (2.0 - 1.1))
    fall, rise = math.log(1.1 / 0.9), math.log((2.0 - 0.9) / (2.0 - 1.1))
    expected = [0.0, off, off + fall, off + fall + rise, off + 2 * fall + rise, off + 2 * (fall + rise)]
    times = [event.time for event in answer.events]
    assert times[:6] == pytest.approx(expected, abs=1e-9)
    assert answer["room.x"][answer.time >= off].max() == pytest.approx(1.1, abs=1e-11)
    assert answer["room.x"][answer.time >= off].min() == pytest.approx(0.9, abs=1e-11)
    assert set(answer["room.is_on"]) == {0.0, 1.0}


@BACKENDS
def test_a_law_reads_the_mode_of_its_element(backend: Backend):
    answer = run(compiled(SlowingMass(), backend), 1.0, initial={"mass.flange.flow": 1.0})
    (event,) = answer.events
    change = math.log(2.0)
    assert event.time == pytest.approx(change, abs=1e-10)
    assert event.lost == 0.0
    assert answer.at_end("mass.flange.flow") == pytest.approx(0.5 * math.exp(-4.0 * (1.0 - change)), rel=1e-7)
    assert energy_balance(answer).relative_residual < 1e-6


def test_what_is_true_at_the_start_happens_at_the_start():
    answer = run(compiled(SlowingMass()), 1.0, initial={"mass.flange.flow": 0.25})
    assert [event.time for event in answer.events] == [0.0]
    assert answer.at_end("mass.flange.flow") == pytest.approx(0.25 * math.exp(-4.0), rel=1e-7)


@BACKENDS
def test_a_spring_that_jumps_loses_what_it_held(backend: Backend):
    answer = run(compiled(Winding(), backend), 1.8)
    assert [event.time for event in answer.events] == pytest.approx([0.5, 1.0, 1.5], abs=1e-12)
    assert [event.lost for event in answer.events] == pytest.approx([1.0] * 3, rel=1e-11)  # 8 N/m, 0.5 m
    assert answer.at_end("ratchet.displacement") == pytest.approx(0.3, rel=1e-10)
    assert energy_balance(answer).relative_residual < 1e-12


class Clocked(Controller):
    command = Output("")
    ticks = Discrete("")

    def step(self):
        return {self.ticks: self.ticks + 1.0, self.command: where(self.ticks >= 3.0, 1.0, 0.0)}


class Counter(SignalBlock):
    command = Input("")
    count = Output("")
    number = Discrete("")

    def outputs(self):
        return {self.count: self.number}

    def events(self):
        return (when(self.command > 0.5, {self.number: self.number + 1.0}),)


class Commanded(Component):
    controller = Clocked(period=0.1)
    counter = Counter()

    connections = (connect(controller.command, counter.command),)


@BACKENDS
def test_what_a_controller_makes_true_happens_once_at_its_sample(backend: Backend):
    answer = run(compiled(Commanded(), backend), 1.0)
    assert [event.time for event in answer.events] == pytest.approx([0.3], abs=1e-12)
    assert answer.at_end("counter.count") == 1.0


# -- events without end ---------------------------------------------------------------------------------


class Relay(SignalBlock):
    """A relay without hysteresis that drives its own input back."""

    rate: Parameter = parameter("1/s", default=1.0)
    level = Output("")
    up = Discrete("", start=1.0)
    x = State("", start=-0.35)

    def outputs(self):
        return {self.level: self.x}

    def derivatives(self):
        return {self.x: where(self.up > 0.5, self.rate, -self.rate)}

    def events(self):
        return (when(self.x > 0.0, {self.up: 0.0}), when(self.x < 0.0, {self.up: 1.0}))


class Relayed(Component):
    relay = Relay()


class Restless(SignalBlock):
    """Two events each of which makes the other happen."""

    level = Output("")
    mode = Discrete("")

    def outputs(self):
        return {self.level: self.mode}

    def events(self):
        return (when(self.mode > 0.5, {self.mode: 0.0}), when(self.mode <= 0.5, {self.mode: 1.0}))


class Unsettled(Component):
    restless = Restless()


@BACKENDS
def test_chattering_ends_the_run_and_names_the_element(backend: Backend):
    answer = run(compiled(Relayed(), backend), 5.0)
    assert answer.ending.status is RunStatus.CHATTERING
    assert answer.ending.path == Path(("relay",))
    assert answer.ending.time == pytest.approx(0.35, abs=1e-2)
    assert not answer.ending.is_complete
    assert "relay" in answer.ending.message


def test_events_that_make_each_other_happen_at_once_end_the_run():
    answer = run(compiled(Unsettled()), 1.0)
    assert answer.ending.status is RunStatus.CHATTERING
    assert answer.ending.path == Path(("restless",))
    assert answer.ending.time == 0.0


# -- files and removals ---------------------------------------------------------------------------------


def test_a_model_with_events_read_from_its_document_is_equal_and_runs_the_same():
    for component, stop in ((BouncingBall(), 1.5), (Heated(), 1.0)):
        model = elaborate(component)
        again = from_document(to_document(model))
        assert again == model
        first, second = run(compile_model(model), stop), run(compile_model(again), stop)
        assert first.events == second.events
        assert len(first.events) >= 2


def test_the_events_of_a_run_are_in_its_file(tmp_path: FilePath):
    answer = run(compiled(BouncingBall()), 2.0)
    save_trajectory(answer, tmp_path / "ball.npz")
    assert load_trajectory(tmp_path / "ball.npz").events == answer.events
    assert answer.events


# -- conditions that end a run ----------------------------------------------------------------------------


class Coasting(Component):
    """A mass that nothing slows."""

    mass = Mass(mass=2.0)
    damper = Damper(damping=0.0)
    wall = Fixed()

    connections = (connect(mass.flange, damper.a), connect(damper.b, wall.flange))


@BACKENDS
def test_integrals_of_an_implicit_method_end_at_the_instant_of_an_event(backend: Backend):
    class Slowing(Component):
        mass, damper, wall = Mass(mass=2.0), Damper(damping=3.0), Fixed()
        connections = (connect(mass.flange, damper.a), connect(damper.b, wall.flange))

    model = compiled(Slowing(), backend)
    scenario = Scenario(stop=9.0, initial={parse_path("mass.flange.flow"): 2.0})
    until = Slowing().mass.flange.flow < quantity(0.5, "m/s")
    answer = simulate(model, scenario, method=Method.ROS2, step=0.01, jacobian_every=5, record_every=9.0, until=until)
    assert answer.ending.time == pytest.approx(2.0 / 3.0 * math.log(4.0), rel=1e-5)
    # Half a step more or less of the power at the end, 0.75 W, would be 4 mJ.
    assert answer.work(parse_path("damper.port")) == pytest.approx(4.0 - 0.25, abs=5e-4)


@BACKENDS
def test_a_run_stops_where_its_condition_becomes_true(backend: Backend):
    model, rig = compiled(SlowingMass(), backend), SlowingMass()
    scenario = Scenario(stop=5.0, initial={"mass.flange.flow": 1.0})  # pyright: ignore[reportArgumentType]
    slow = rig.mass.flange.flow < 0.1
    answer = simulate(model, scenario, method=Method.RK4, step=1e-2, until=slow, integrals_every=10.0)
    expected = math.log(2.0) + math.log(0.5 / 0.1) / 4.0
    assert answer.ending.status is RunStatus.STOPPED
    assert answer.ending.is_complete
    assert answer.ending.time == pytest.approx(expected, abs=1e-8)
    assert answer.time[-1] == answer.ending.time
    assert answer.at_end("mass.flange.flow") == pytest.approx(0.1, abs=1e-12)
    assert [event.element for event in answer.events] == [Path(("damper",))]
    assert answer["damper.flange.work"][-1] == pytest.approx(answer.work(Path(("damper", "flange"))))
    assert energy_balance(answer).relative_residual < 1e-6


def test_a_run_that_was_stopped_goes_on_to_the_next_time_its_condition_becomes_true():
    model, rig = compiled(Heated()), Heated()
    off = math.log(1.5 / 0.9)
    fall, rise = math.log(1.1 / 0.9), math.log(1.1 / 0.9)
    warm = rig.room.level > 1.0
    times: list[float] = []
    run: Trajectory | None = None
    for _ in range(2):
        run = simulate(model, Scenario(stop=9.0), method=Method.RK4, step=1e-2, until=warm, continued_from=run)
        times.append(run.ending.time)
    again = fall + math.log((2.0 - 0.9) / (2.0 - 1.0))
    assert times == pytest.approx([math.log(1.5), off + again], abs=1e-8)
    assert run is not None
    whole = simulate(model, Scenario(stop=2.0), method=Method.RK4, step=1e-2, continued_from=run)
    assert whole.ending.status is RunStatus.COMPLETED
    assert [e.time for e in whole.events][:4] == pytest.approx([0.0, off, off + fall, off + fall + rise], abs=1e-8)


def test_a_condition_on_time_and_parameters_stops_a_model_without_events():
    component = Coasting()
    model = compiled(component)
    moved = time * component.mass.flange.flow * component.mass.mass
    late = (moved > quantity(0.6, "kg.m")) | (time > 2.0)
    scenario = Scenario(stop=5.0, initial={"mass.flange.flow": 0.5})  # pyright: ignore[reportArgumentType]
    answer = simulate(model, scenario, step=1e-2, until=late)
    assert answer.ending.time == pytest.approx(0.6, abs=1e-12)
    assert model.lowered.program.guards is None
    assert simulate(model, scenario, step=1e-2).ending.status is RunStatus.COMPLETED


def test_what_is_true_at_the_start_stops_a_run_there():
    component = Coasting()
    answer = simulate(compiled(component), Scenario(stop=5.0), until=component.mass.flange.flow >= 0.0)
    assert answer.ending.status is RunStatus.STOPPED
    assert answer.ending.time == 0.0
