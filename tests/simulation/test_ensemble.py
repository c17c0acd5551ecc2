"""Many designs at once: each has the bits it has alone, and fails alone."""

from __future__ import annotations

import math
import multiprocessing
import pickle
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import propermodel as pm
from propermodel.codegen.fingerprint import fingerprint
from propermodel.diagnostics import SimulationError
from propermodel.library.mechanics.translation import Damper, Fixed, Impact, Mass, Spring, VelocitySource, Weight


class Oscillator(pm.Component):
    """A mass on a spring and a damper, on a base that may move."""

    speed = pm.Input("m/s")

    mass = Mass(mass=2.0, start_velocity=1.0)
    spring = Spring(stiffness=50.0)
    damper = Damper(damping=0.5)
    base = VelocitySource()

    connections = (
        pm.connect(mass.flange, spring.a, damper.a),
        pm.connect(spring.b, damper.b, base.flange),
        pm.connect(speed, base.velocity),
    )


class Bouncing(pm.Component):
    """A ball on a hard floor."""

    ball = Mass(mass=1.0)
    weight = Weight(mass=1.0)
    floor = Impact(restitution=0.8, start_gap=1.0)
    ground = Fixed()

    connections = (
        pm.connect(ball.flange, weight.flange, floor.a),
        pm.connect(floor.b, ground.flange),
    )


@pytest.fixture(scope="module")
def oscillator() -> pm.CompiledModel:
    return pm.compile_model(pm.elaborate(Oscillator()))


SCENARIO = pm.Scenario(stop=2.0, inputs={"speed": 0.0})
STIFFNESS = np.linspace(20.0, 80.0, 11)


@pytest.mark.parametrize("method", list(pm.Method))
def test_each_design_has_the_bits_it_has_alone(oscillator: pm.CompiledModel, method: pm.Method):
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS})
    runs = pm.simulate_many(oscillator, scenarios, method=method, step=1e-3, record_every=0.1)
    assert len(runs) == 11
    for i in (0, 5, 10):
        alone = pm.simulate(oscillator, scenarios[i], method=method, step=1e-3, record_every=0.1)
        assert (runs.time == alone.time).all()
        assert (runs.rows[i] == alone.columns).all()
        assert (runs.final[i] == alone.final_signals).all()
        assert (runs.activities[i] == alone.memory.activity).all()
        assert (runs.integrals[i] == alone.memory.integral).all()


@pytest.mark.parametrize(("lanes", "threads"), [(1, 1), (2, 3), (4, 1), (8, 2)])
def test_lanes_threads_and_order_change_nothing(oscillator: pm.CompiledModel, lanes: int, threads: int):
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS})
    reference = pm.simulate_many(oscillator, scenarios, step=1e-3)
    order = np.random.default_rng(lanes).permutation(11)
    shuffled = [scenarios[i] for i in order]
    runs = pm.simulate_many(oscillator, shuffled, step=1e-3, lanes=lanes, threads=threads)
    assert (runs.final == reference.final[order]).all()
    assert (runs.activities == reference.activities[order]).all()
    assert runs.scenarios == tuple(shuffled)


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:
        yield executor


def test_other_processes_give_the_same_bits(oscillator: pm.CompiledModel, process: Executor):
    # The third design leaves its limits.
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": [20.0, 50.0, 1e9, 60.0, 70.0]})

    def runs(executor: Executor | None) -> pm.Ensemble:
        return pm.simulate_many(oscillator, scenarios, step=1e-3, record_every=0.5, lanes=2, executor=executor)

    here = runs(None)
    with ThreadPoolExecutor(1) as thread:
        for executor in (process, thread):
            there = runs(executor)
            assert there.endings == here.endings
            assert there.failed == (2,)
            for name in ("time", "rows", "final", "integrals", "activities"):
                np.testing.assert_array_equal(getattr(there, name), getattr(here, name))


def test_models_with_events_run_in_other_processes(process: Executor):
    compiled = pm.compile_model(pm.elaborate(Bouncing()))
    scenarios = [pm.Scenario(stop=1.0, initial={"floor.separation.width": gap}) for gap in (1.0, 0.5)]
    here, there = (
        pm.simulate_many(compiled, scenarios, step=1e-3, record_every=0.25, executor=executor)
        for executor in (None, process)
    )
    np.testing.assert_array_equal(there.rows, here.rows)
    np.testing.assert_array_equal(there.activities, here.activities)


def test_a_pickled_model_is_compiled_once_and_is_the_same(oscillator: pm.CompiledModel):
    first, second = (pickle.loads(pickle.dumps(oscillator)) for _ in range(2))
    assert first is second
    assert first.model == oscillator.model
    assert fingerprint(first.lowered.program) == fingerprint(oscillator.lowered.program)


def test_a_model_with_a_condition_of_a_run_stays_in_its_process():
    compiled = pm.compile_model(pm.elaborate(Bouncing()))
    with pytest.raises(ValueError, match="bouncing with an event that its model does not have stays in its process"):
        pickle.loads(pickle.dumps(compiled.with_event(compiled.system.events[0])))


def test_designs_follow_the_closed_form(oscillator: pm.CompiledModel):
    runs = pm.simulate_many(
        oscillator,
        pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS}),
        method=pm.Method.RK4,
        step=1e-3,
        record=["mass.flange.flow"],
    )
    decay = 0.5 / (2 * 2.0)
    omega = np.sqrt(STIFFNESS / 2.0 - decay**2)
    expected = np.exp(-decay * 2.0) * (np.cos(omega * 2.0) - decay / omega * np.sin(omega * 2.0))
    np.testing.assert_allclose(runs.at_end("mass.flange.flow"), expected, rtol=1e-8)
    kinetic = 0.5 * 2.0 * (expected**2 - 1.0)
    np.testing.assert_allclose(runs.work("mass.flange"), kinetic, rtol=1e-7)
    assert (runs.activity("mass.flange") >= np.abs(kinetic)).all()


def test_a_design_that_fails_says_why_and_leaves_the_others_alone(oscillator: pm.CompiledModel):
    damping = [0.5, 0.5, 1e5, 0.5, 0.5]  # an explicit step of 0.1 ms is stable up to 2 m / step
    scenarios = pm.designs(SCENARIO, {"damper.damping": damping})
    runs = pm.simulate_many(oscillator, scenarios, method=pm.Method.EULER, step=1e-4, record_every=0.1)
    assert runs.failed == (2,)
    alone = pm.simulate(oscillator, scenarios[2], method=pm.Method.EULER, step=1e-4, record_every=0.1)
    assert runs.endings[2].status == alone.ending.status
    assert runs.endings[2].path == alone.ending.path
    assert "smaller step" in runs.endings[2].message
    assert np.isnan(runs.final[2]).all()
    assert np.isnan(runs.activities[2]).all()
    assert np.isnan(runs.rows[2, -1]).all()
    assert np.isfinite(runs.rows[2, 0]).all()
    assert (runs.final[[0, 1, 3, 4]] == runs.final[0]).all()
    assert "design 2: stopped at" in str(runs)


def test_all_designs_may_fail(oscillator: pm.CompiledModel):
    runs = pm.simulate_many(oscillator, pm.designs(SCENARIO, {"damper.damping": [1e5] * 5}), step=1e-3)
    assert runs.failed == (0, 1, 2, 3, 4)
    assert np.isnan(runs.final).all()


def test_inputs_may_differ(oscillator: pm.CompiledModel):
    ramp = pm.table_values([np.array([0.0, 2.0])], np.array([0.0, 1.0]))
    scenarios = [
        pm.Scenario(name=str(i), stop=2.0, inputs={"speed": speed}) for i, speed in enumerate([0.1, 0.2, 0.1, ramp])
    ]
    runs = pm.simulate_many(oscillator, scenarios, step=1e-3)
    for i, scenario in enumerate(scenarios):
        # Recording instants cut the time into ticks, whose steps begin at rounded times.
        alone = pm.simulate(oscillator, scenario, step=1e-3, record_every=math.inf, integrals_every=math.inf)
        assert (runs.final[i] == alone.final_signals).all()


def test_windows_may_differ_where_no_rows_are_kept(oscillator: pm.CompiledModel):
    scenarios = [pm.Scenario(stop=stop, inputs={"speed": 0.0}) for stop in (1.0, 2.0)]
    runs = pm.simulate_many(oscillator, scenarios, step=1e-3)
    for i, scenario in enumerate(scenarios):
        # Recording instants cut the time into ticks, whose steps begin at rounded times.
        alone = pm.simulate(oscillator, scenario, step=1e-3, record_every=math.inf, integrals_every=math.inf)
        assert (runs.final[i] == alone.final_signals).all()
    with pytest.raises(SimulationError, match="one window"):
        pm.simulate_many(oscillator, scenarios, step=1e-3, record_every=0.1)


def test_models_with_events_run_in_turn():
    compiled = pm.compile_model(pm.elaborate(Bouncing()))
    scenarios = pm.designs(pm.Scenario(stop=2.0), {"floor.restitution": [0.5, 0.7, 0.9]})
    runs = pm.simulate_many(compiled, scenarios, step=1e-3, record=["ball.flange.flow"], record_every=0.25)
    assert runs.lanes == 1
    assert len(runs.time) == 9
    for i, scenario in enumerate(scenarios):
        alone = pm.simulate(compiled, scenario, step=1e-3, record_every=0.25)
        assert runs.at_end("ball.flange.flow")[i] == alone.at_end("ball.flange.flow")
        regular = [np.flatnonzero(np.isclose(alone.time, t))[-1] for t in runs.time]
        assert (runs["ball.flange.flow"][i] == alone["ball.flange.flow"][regular]).all()


def test_everything_comes_as_a_dataset(oscillator: pm.CompiledModel):
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS, "mass.mass": 3.0})
    runs = pm.simulate_many(oscillator, scenarios, step=1e-3, record=["mass.flange.flow"], record_every=0.5)
    data = runs.to_xarray()
    assert data["mass.flange.flow"].shape == (11, 5)
    assert data["mass.flange.flow"].units == "m/s"
    np.testing.assert_array_equal(data["parameter spring.stiffness"], STIFFNESS)
    assert set(data["parameter mass.mass"].values) == {3.0}
    assert data["activity"].sel(bond="mass.flange").shape == (11,)
    assert data["parameter spring.stiffness"].units == "N/m"


def test_progress_counts_designs(oscillator: pm.CompiledModel):
    seen: list[tuple[int, int]] = []
    pm.simulate_many(
        oscillator,
        pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS}),
        step=1e-3,
        progress=lambda done, all: seen.append((done, all)),
    )
    assert seen[-1] == (11, 11)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_what_was_not_recorded_is_named(oscillator: pm.CompiledModel):
    runs = pm.simulate_many(oscillator, [SCENARIO], step=1e-3, record=["mass.flange.flow"])
    with pytest.raises(SimulationError, match="was not recorded in these runs"):
        runs.at_end("spring.port.effort")
    with pytest.raises(SimulationError, match=r"did you mean 'mass\.flange'"):
        runs.activity("mass.flang")
    with pytest.raises(SimulationError, match="no designs"):
        pm.simulate_many(oscillator, [])


def test_a_scenario_that_does_not_fit_is_refused_before_its_turn(oscillator: pm.CompiledModel):
    with pytest.raises(SimulationError, match="lies outside"):
        pm.simulate_many(oscillator, pm.designs(SCENARIO, {"spring.stiffness": [50.0, -1.0]}), step=1e-3)
    assert threading.active_count() < 20


@pytest.mark.parametrize("record_every", [0.3, math.inf])
@pytest.mark.parametrize("method", [pm.Method.RK4, pm.Method.ROS2, pm.Method.RODAS])
def test_extremes_of_designs_are_those_of_their_runs(
    oscillator: pm.CompiledModel, method: pm.Method, record_every: float
):
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": STIFFNESS})
    options = {"method": method, "step": 1e-3, "record": ["mass.flange.flow"], "record_extremes": True}
    runs = pm.simulate_many(oscillator, scenarios, record_every=record_every, **options)  # type: ignore[arg-type]
    seen = runs.extremes("mass.flange.flow")
    assert seen.least.shape == (11, len(seen.time)) == (11, 7 if record_every < 1.0 else 1)
    for i in (0, 5, 10):
        period = min(record_every, 2.0)
        alone = pm.simulate(oscillator, scenarios[i], record_every=period, integrals_every=2.0, **options)  # type: ignore[arg-type]
        own = alone.extremes("mass.flange.flow")
        assert (own.time == seen.time).all()
        assert (own.least == seen.least[i]).all()
        assert (own.greatest == seen.greatest[i]).all()
    assert (seen.least < runs["mass.flange.flow"].min()).any()
    data = runs.to_xarray()
    assert (data["greatest mass.flange.flow"].to_numpy() == seen.greatest).all()
    with pytest.raises(SimulationError, match=r"extremes of 'mass\.flange\.flow' were not recorded in these runs"):
        pm.simulate_many(oscillator, scenarios[:1], step=1e-3).extremes("mass.flange.flow")


def test_extremes_of_designs_with_events_join_what_is_between_their_rows():
    compiled = pm.compile_model(pm.elaborate(Bouncing()))
    scenarios = pm.designs(pm.Scenario(stop=2.0), {"floor.restitution": [0.5, 0.8]})
    options = {"step": 1e-3, "record": ["ball.flange.flow"], "record_extremes": True}
    for record_every in (0.5, math.inf):
        runs = pm.simulate_many(compiled, scenarios, record_every=record_every, **options)  # type: ignore[arg-type]
        seen = runs.extremes("ball.flange.flow")
        for i, scenario in enumerate(scenarios):
            every = pm.simulate(compiled, scenario, step=1e-3, record_every=1e-3)
            for k, (begin, end) in enumerate(zip(seen.time, [*seen.time[1:], 2.0], strict=True)):
                inside = (every.time >= begin - 1e-9) & (every.time <= end + 1e-9)
                values = every["ball.flange.flow"][inside]
                assert seen.least[i, k] == pytest.approx(values.min(), rel=1e-9)
                assert seen.greatest[i, k] == pytest.approx(values.max(), rel=1e-9)


def test_extremes_of_a_design_that_fails_end_with_it(oscillator: pm.CompiledModel):
    """A step that is too long for the second design: its numbers grow beyond all bounds."""
    scenarios = pm.designs(SCENARIO, {"spring.stiffness": [20.0, 4e9, 80.0]})
    runs = pm.simulate_many(
        oscillator, scenarios, step=1e-3, record=["mass.flange.flow"], record_every=0.2, record_extremes=True
    )
    assert runs.failed == (1,)
    seen = runs.extremes("mass.flange.flow")
    ends = seen.time + 0.2
    failed = runs.endings[1].time
    assert np.isnan(seen.least[1, ends > failed + 1e-9]).all()
    assert np.isfinite(seen.least[[0, 2]]).all()
