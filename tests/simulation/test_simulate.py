"""Scenarios, recording, continued, interrupted and failing runs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, CompiledModel, Method, compile_model
from propermodel.diagnostics import Path, SimulationError, parse_path
from propermodel.expressions import Expr, ExprLike, exp, time
from propermodel.library.mechanics.translation import Damper, Fixed, ForceSource, Mass, Spring
from propermodel.modelling import (
    Compliance,
    Component,
    Controller,
    Discrete,
    EffortSource,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Scenario,
    TableValues,
    Translation,
    connect,
    elaborate,
    free,
    parameter,
    prescribed_flow,
    table,
)
from propermodel.simulation.simulate import Progress, simulate
from propermodel.simulation.trajectory import RunStatus
from tests.physics.systems import Push, close, compiled, run, scenario, system


class Curve(Resistance):
    """A damper with a measured curve."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    curve = table("N", ("m/s",), [[-1.0, 0.0, 1.0]], [-10.0, 0.0, 10.0], extrapolation="linear")

    def effort(self, flow: Expr) -> Expr:
        return self.curve(flow)


class Counter(Controller):
    """Counts its samples and adds up what it reads."""

    reading = Input("m/s")
    force = Output("N")
    count = Discrete("1")

    def step(self) -> dict[Expr, ExprLike]:
        return {self.count: self.count + 1.0}


class Rig(Component):
    """A mass pushed by an input, on a spring, with a measured damper."""

    push = Input("N")
    mass_value: Parameter = parameter("kg", default=2.0, low=0.1, high=10.0)
    base = Port(Translation)

    mass = Mass(mass=mass_value)
    spring = Spring(stiffness=50.0)
    damper = Curve()
    force = ForceSource()
    counter = Counter(period=0.1)

    connections = (
        connect(force.flange, mass.flange, spring.a, damper.a),
        connect(spring.b, damper.b, base),
        connect(push, force.force),
        connect(mass.flange.flow, counter.reading),
        prescribed_flow(base),
    )


@pytest.fixture(scope="module")
def rig() -> CompiledModel:
    return compiled(Rig())


# -- scenarios ---------------------------------------------------------------------------------------------


def test_a_state_can_be_given_by_its_path_or_by_the_variables_of_its_port(rig):
    given = {
        "mass.momentum": 3.0,
        "mass.flange.momentum": 3.0,
        "mass.flange.flow": 1.5,
    }
    for path, value in given.items():
        assert run(rig, 0.1, initial={path: value}).at_start("mass.flange.flow") == pytest.approx(1.5), path
    for path, value in {
        "spring.displacement": 0.2,
        "spring.port.displacement": 0.2,
        "spring.port.effort": 10.0,
    }.items():
        assert run(rig, 0.1, initial={path: value}).at_start("spring.port.effort") == pytest.approx(10.0), path


def test_a_start_given_at_a_port_follows_a_parameter_of_the_scenario(rig):
    r = run(rig, 0.1, initial={"mass.flange.flow": 1.5}, parameters={"mass_value": 4.0})
    assert r.at_start("mass.momentum") == pytest.approx(6.0)


def test_a_held_value_can_be_given_a_start(rig):
    assert run(rig, 0.35, initial={"counter.count": 10.0}).at_end("counter.count") == 14.0
    assert run(rig, 0.35).at_end("counter.count") == 4.0


def refused(model: CompiledModel, **given: Any) -> str:
    with pytest.raises(SimulationError) as caught:
        simulate(model, scenario(1.0, **given))
    return str(caught.value)


def test_an_unknown_start_is_named_with_the_nearest_state(rig):
    assert refused(rig, initial={"mass.momentun": 1.0}) == (
        "error[simulation/unknown-initial]: scenario 'scenario' gives a start for 'mass.momentun', which is no state "
        "of this model\n"
        "  help: did you mean 'mass.momentum'?"
    )


@pytest.mark.parametrize("path", ["damper.port.flow", "mass.flange.effort", "spring.port.flow", "x", ""])
def test_what_no_state_decides_cannot_be_given_a_start(rig, path):
    assert f"gives a start for '{path}', which is no state of this model" in refused(rig, initial={path: 1.0})


def test_an_unknown_input_is_named_with_the_nearest(rig):
    assert refused(rig, inputs={"pusch": 1.0}) == (
        "error[simulation/unknown-input]: scenario 'scenario' gives 'pusch', which is no input or table of this model\n"
        "  help: did you mean 'push'?"
    )


def test_an_unknown_parameter_is_named_with_the_nearest(rig):
    assert refused(rig, parameters={"spring.stifness": 1.0}) == (
        "error[simulation/unknown-parameter]: the model has no parameter 'spring.stifness'\n"
        "  help: did you mean 'spring.stiffness'?"
    )


@pytest.mark.parametrize(("value", "text"), [(11.0, "11"), (0.05, "0.05")])
def test_a_parameter_outside_its_range_is_refused(rig, value, text):
    told = refused(rig, parameters={"mass_value": value}).splitlines()
    assert told[0] == (f"error[simulation/parameter-range]: 'mass_value' = {text} kg lies outside its range 0.1 to 10")
    assert told[-1] == "  help: give a value in SI inside the range, which stands where the parameter is declared"


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_parameter_without_a_finite_value_is_refused(rig, value):
    told = refused(rig, parameters={"mass_value": value}).splitlines()
    assert told[0] == f"error[simulation/parameter-range]: 'mass_value' = {value} kg is no finite number"


def test_all_faults_of_a_scenario_are_told_at_once(rig):
    with pytest.raises(SimulationError) as caught:
        simulate(rig, scenario(1.0, initial={"a": 1.0, "b": 1.0}, inputs={"c": 1.0}))
    assert len(caught.value.diagnostics) == 3


def test_a_parameter_of_the_root_reaches_the_part(rig):
    r = run(rig, 0.1, parameters={"mass_value": 4.0}, inputs={"push": 8.0})
    assert r.at_start("mass.flange.effort") == pytest.approx(8.0)
    assert r["mass.flange.flow"][1] == pytest.approx(2.0 * r.time[1], rel=1e-2)


def test_a_parameter_of_a_part_overrides_what_the_parent_says(rig):
    r = run(rig, 0.001, parameters={"mass.mass": 8.0, "mass_value": 4.0}, inputs={"push": 8.0}, step=1e-5)
    assert r.at_end("mass.flange.flow") == pytest.approx(0.001, rel=1e-2)


def test_an_input_may_be_constant_or_a_table_over_time(rig):
    ramp = TableValues(((0.0, 0.5, 2.0),), (0.0, 10.0, 10.0))
    r = run(rig, 2.0, inputs={"push": ramp})
    close(-r["force.flange.effort"], np.minimum(20.0 * r.time, 10.0))
    assert -run(rig, 2.0, inputs={"push": 3.0})["force.flange.effort"] == pytest.approx(3.0)


def test_a_prescribed_port_of_the_root_is_an_input(rig):
    r = run(rig, 1.0, inputs={"base.flow": 0.5})
    assert r["base.flow"] == pytest.approx(0.5)
    assert r["spring.port.flow"] == pytest.approx(r["mass.flange.flow"] - 0.5)


def test_a_table_is_exchanged_by_path_without_another_compilation(rig):
    soft = TableValues(((-2.0, 0.0, 2.0),), (-8.0, 0.0, 8.0))
    exchanged = Scenario(
        stop=0.5, initial={parse_path("mass.flange.flow"): 0.7}, tables={parse_path("damper.curve"): soft}
    )
    r = simulate(rig, exchanged, method=Method.RK4, step=1e-3)
    assert r["damper.port.effort"] == pytest.approx(4.0 * r["damper.port.flow"])


def test_a_table_of_another_shape_is_refused(rig):
    wrong = Scenario(
        stop=0.5,
        tables={parse_path("damper.curve"): TableValues(((0.0, 1.0), (0.0, 1.0)), (0.0, 1.0, 2.0, 3.0))},
    )
    with pytest.raises(SimulationError, match=r"the table 'damper\.curve' was compiled with 1 coordinate\(s\)"):
        simulate(rig, wrong)


def test_time_spent_outside_a_table_is_counted(rig):
    mass, curve, wall = Mass(mass=1.0, start_velocity=2.0), Curve(), Fixed()
    r = run(
        system(connect(mass.flange, curve.a), connect(curve.b, wall.flange), mass=mass, curve=curve, wall=wall), 1.0
    )
    (use,) = r.outside_tables
    assert use.path == parse_path("curve.curve")
    assert use.seconds == pytest.approx(math.log(2.0) / 10.0, abs=2e-3)
    assert run(rig, 0.5).outside_tables == ()


def test_a_window_must_have_a_length(rig):
    with pytest.raises(
        SimulationError, match=r"scenario 'scenario' goes from \S+ s to 1 s; it must end after its start"
    ):
        simulate(rig, Scenario(start=1.0, stop=1.0))
    with pytest.raises(SimulationError, match=r"the step is 0.0 s; it must be positive"):
        simulate(rig, Scenario(stop=1.0), step=0.0)


def test_a_window_need_not_begin_at_zero():
    class Ramp(EffortSource):
        flange = Port(Translation)
        rate: Parameter = parameter("N/s")

        def effort(self) -> Expr:
            return -self.rate * time

    ramp, mass = Ramp(rate=2.0), Mass(mass=1.0)
    r = run(system(connect(ramp.flange, mass.flange), ramp=ramp, mass=mass), 7.0, start=5.0, every=0.5)
    assert (r.time[0], r.time[-1]) == (5.0, 7.0)
    close(r["mass.flange.flow"], r.time**2 - 25.0)


# -- recording ---------------------------------------------------------------------------------------------


def test_everything_is_recorded_unless_somebody_chooses(rig):
    assert parse_path("spring.port.effort") in run(rig, 0.1)
    r = simulate(rig, scenario(0.5), record=["mass.flange.power", "spring.port.effort"])
    assert "spring.port.effort" in r
    assert r["mass.flange.power"] == pytest.approx(r["mass.flange.effort"] * r["mass.flange.flow"])
    with pytest.raises(SimulationError) as caught:
        r["damper.port.effort"]
    assert str(caught.value) == (
        "error[simulation/not-recorded]: 'damper.port.effort' was not recorded in this run\n"
        "  help: name it in simulate(..., record=[...])"
    )
    assert r.at_end("damper.port.effort") == pytest.approx(10.0 * r.at_end("mass.flange.flow"))


def test_observables_can_be_named_by_expression_path_or_text():
    part = Rig()
    model = compiled(part)
    r = simulate(model, scenario(0.5, inputs={"push": 1.0}), record=[part.mass.flange.flow])
    assert r[part.mass.flange.flow].tobytes() == r[Path(("mass", "flange", "flow"))].tobytes()
    assert r[part.mass.flange.flow].tobytes() == r["mass.flange.flow"].tobytes()
    assert r.unit(part.mass.flange.flow) == "m/s"
    assert r.unit(part.mass.flange.power) == "W"


def test_an_unknown_observable_is_named_with_the_nearest(rig):
    text = (
        "error[simulation/unknown-observable]: the model has no observable 'mass.flange.fow'\n"
        "  help: did you mean 'mass.flange.flow'?"
    )
    with pytest.raises(SimulationError) as caught:
        simulate(rig, scenario(0.5), record=["mass.flange.fow"])
    assert str(caught.value) == text
    with pytest.raises(SimulationError) as caught:
        run(rig, 0.1)["mass.flange.fow"]
    assert str(caught.value) == text


@pytest.mark.parametrize("ask", ["unit", "at_start", "at_end"])
def test_every_question_about_an_unknown_observable_has_the_same_answer(rig, ask):
    with pytest.raises(SimulationError, match=r"the model has no observable 'nothing'"):
        getattr(run(rig, 0.1), ask)("nothing")


def test_cumulative_activity_and_work_are_columns(rig):
    r = simulate(rig, scenario(0.5), record_every=0.1, integrals_every=0.1)
    activity, work = r["mass.flange.activity"], r["mass.flange.work"]
    assert r.unit("mass.flange.activity") == "J"
    assert activity[0] == work[0] == 0.0
    assert np.all(np.diff(activity) >= 0.0)
    assert np.all(activity >= np.abs(work) - 1e-12)
    assert activity[-1] == pytest.approx(r.activity(parse_path("mass.flange")))
    # What flows into a mass is its kinetic energy.
    assert work == pytest.approx(r["mass.energy"] - r["mass.energy"][0], rel=1e-3, abs=1e-6)


def test_power_at_the_start_and_end_is_effort_times_flow(rig):
    r = run(rig, 0.5, inputs={"push": 4.0})
    assert r.at_end("mass.flange.power") == pytest.approx(r.at_end("mass.flange.effort") * r.at_end("mass.flange.flow"))


def test_work_and_activity_of_an_unknown_bond_are_refused(rig):
    with pytest.raises(SimulationError, match=r"the model has no bond or row 'mass\.flansch'"):
        run(rig, 0.1).work(parse_path("mass.flansch"))


def test_integrals_are_kept_at_their_own_period(rig):
    r = simulate(rig, scenario(1.0, inputs={"push": 4.0}), record_every=0.25, integrals_every=0.5)
    assert r.time == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
    assert r.integral_times == pytest.approx([0.0, 0.5, 1.0])
    index = r.power_index(parse_path("mass.flange"))
    assert r.integrals[-1, index] == pytest.approx(r.work(parse_path("mass.flange")))


def test_the_work_on_a_mass_is_its_kinetic_energy():
    push, mass = Push(force=4.0), Mass(mass=2.0)
    r = run(system(connect(push.flange, mass.flange), push=push, mass=mass), 1.0)
    assert r.work(parse_path("mass.flange")) == pytest.approx(4.0)


def test_to_pandas_and_xarray_hold_every_recorded_column(rig):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    r = run(rig, 0.5, inputs={"push": 1.0})
    frame, data = r.to_pandas(), r.to_xarray()
    assert isinstance(frame, pd.DataFrame)
    assert set(frame.columns) == set(map(str, r.paths)) == set(data.data_vars)
    assert frame["mass.flange.flow"].to_numpy().tobytes() == r["mass.flange.flow"].tobytes()
    assert frame.index.name == "time_s"
    assert data["mass.flange.flow"].attrs["units"] == "m/s"
    assert data["time"].to_numpy() == pytest.approx(r.time)


def test_a_run_says_what_it_cost(rig):
    r = run(rig, 0.5)
    assert str(r).startswith("rig, scenario scenario: completed to 0.5 s; 500 steps of 0.001 s (rk4) in ")


# -- continued and interrupted ---------------------------------------------------------------------------------


@pytest.mark.parametrize("method", list(Method))
def test_a_continued_run_equals_one_go_bit_for_bit(rig, method):
    def go(stop, **more):
        ramp = TableValues(((0.0, 2.0),), (0.0, 10.0))
        return simulate(
            rig,
            scenario(stop, initial={"mass.flange.flow": 1.0}, inputs={"push": ramp}),
            method=method,
            step=1e-3,
            record_every=0.05,
            integrals_every=0.25,
            **more,
        )

    whole = go(2.0)
    half = go(1.0)
    rest = go(2.0, continued_from=half)
    assert rest.memory.state.tobytes() == whole.memory.state.tobytes()
    assert rest.memory.integral.tobytes() == whole.memory.integral.tobytes()
    assert rest.memory.activity.tobytes() == whole.memory.activity.tobytes()
    assert rest.memory.discrete.tobytes() == whole.memory.discrete.tobytes()
    assert half.memory.time == 1.0  # a run is not changed by the one that goes on from it
    assert np.concatenate([half.time, rest.time]).tobytes() == whole.time.tobytes()
    assert np.concatenate([half.columns, rest.columns]).tobytes() == whole.columns.tobytes()
    assert energy_balance(rest) == energy_balance(whole)


def test_a_run_is_only_continued_with_its_own_model_and_forwards(rig):
    first = run(rig, 1.0)
    with pytest.raises(SimulationError, match="with the compiled model that began it"):
        simulate(compiled(Rig()), scenario(2.0), continued_from=first)
    with pytest.raises(SimulationError, match=r"the run to continue is already at 1.0 s, past the stop 0.5 s"):
        simulate(rig, scenario(0.5), continued_from=first)


def test_what_was_computed_before_an_interruption_is_kept(rig):
    def stop_at_some_time(progress: Progress) -> None:
        if progress.time > 1.0:
            raise KeyboardInterrupt

    given = {"method": Method.RK4, "step": 1e-3, "record_every": 0.01}
    r = simulate(rig, scenario(1e4, inputs={"push": 1.0}), progress=stop_at_some_time, **given)
    assert r.ending.status is RunStatus.INTERRUPTED
    assert 1.0 < r.ending.time < 1e4
    assert r.ending.message == f"interrupted at {r.ending.time:.6g} s; what was computed is kept"
    assert r.time[-1] == pytest.approx(r.ending.time, abs=0.011)
    short = simulate(rig, scenario(1e4, inputs={"push": 1.0}), progress=stop_at_some_time, **given)
    common = min(len(r.time), len(short.time))
    assert r.columns[:common].tobytes() == short.columns[:common].tobytes()


def test_progress_goes_from_start_to_stop(rig):
    seen: list[Progress] = []
    simulate(rig, scenario(50.0, inputs={"push": 1.0}), progress=seen.append)
    fractions = [p.fraction for p in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)
    assert seen[-1].seconds_left == pytest.approx(0.0, abs=1e-9)
    assert seen[-1].times_real_time > 1.0


# -- failures ------------------------------------------------------------------------------------------------


def attempt(model: Component, stop: float = 5.0, step: float = 1e-3, **given: Any):
    return simulate(compiled(model), scenario(stop, **given), method=Method.RK4, step=step, record_every=0.1)


class Explosive(EffortSource):
    """Pushes with a force that grows without bound."""

    flange = Port(Translation)
    growth: Parameter = parameter("1/s")
    force: Parameter = parameter("N", default=1.0)

    def effort(self) -> Expr:
        return -self.force * exp(exp(self.growth * time))


def test_a_state_that_is_no_number_stops_the_run_and_is_named():
    push, mass = Explosive(growth=1.9), Mass(mass=1.0)
    r = attempt(system(connect(push.flange, mass.flange), push=push, mass=mass))
    assert r.ending.status is RunStatus.FAILED
    assert r.ending.path == parse_path("mass.momentum")
    assert math.log(709.0) / 1.9 - 0.2 < r.ending.time < math.log(709.0) / 1.9 + 0.2
    assert r.ending.message == (
        f"stopped at {r.ending.time:.6g} s: the state mass.momentum is no longer a finite number; try a smaller step"
    )
    assert np.all(np.isfinite(r["mass.flange.flow"]))
    assert r.time[-1] > 3.0


@pytest.mark.parametrize("backend", list(Backend))
def test_a_run_whose_energies_are_no_numbers_does_not_end_as_completed(backend):
    spring, mass, wall = Spring(stiffness=100.0), Mass(mass=1.0, start_velocity=1.0), Fixed()
    model = system(connect(wall.flange, spring.a), connect(spring.b, mass.flange), spring=spring, mass=mass, wall=wall)
    blown = compile_model(elaborate(model), backend=backend)

    def euler(stop: float):
        # Each step of 1 s multiplies the energy by 1 + 100, so by Euler 50 J pass 1.8e308 J after some 154 steps.
        return simulate(blown, scenario(stop), method=Method.EULER, step=1.0, record_every=1.0)

    assert euler(100.0).ending.status is RunStatus.COMPLETED
    for stop in (155.5, 160.0, 200.0):
        r = euler(stop)
        assert np.all(np.isfinite(r.memory.state))
        assert not np.all(np.isfinite(r.memory.activity))
        assert r.ending.status is RunStatus.FAILED
        assert r.ending.path in (parse_path("mass.flange"), parse_path("spring.port"))
        assert 150.0 <= r.ending.time <= 156.0
        assert r.ending.message == (
            f"stopped at {r.ending.time:.6g} s: the energy exchanged at {r.ending.path} is no longer a finite number; "
            "try a smaller step"
        )


@pytest.mark.parametrize("backend", list(Backend))
def test_a_condition_does_not_end_a_run_as_stopped_whose_energies_are_no_numbers(backend):
    spring, mass, wall = Spring(stiffness=100.0), Mass(mass=1.0, start_velocity=1.0), Fixed()
    model = system(connect(wall.flange, spring.a), connect(spring.b, mass.flange), spring=spring, mass=mass, wall=wall)
    blown = compile_model(elaborate(model), backend=backend)

    def ended(at: float):
        return simulate(
            blown,
            scenario(200.0),
            method=Method.EULER,
            step=1.0,
            record_every=1.0,
            integrals_every=math.inf,
            until=time > at,
        )

    assert ended(100.5).ending.status is RunStatus.STOPPED
    r = ended(155.5)
    assert r.ending.time < 157.0
    assert r.ending.status is RunStatus.FAILED
    assert "is no longer a finite number" in r.ending.message


class LimitedSpring(Compliance):
    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m")
    travel: Parameter = parameter("m")

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement

    def limits(self) -> tuple[Expr, Expr]:
        return -self.travel, self.travel


def test_a_state_that_leaves_its_range_stops_the_run_and_is_named():
    mass, spring, wall = Mass(mass=1.0, start_velocity=1.0), LimitedSpring(stiffness=1.0, travel=0.5), Fixed()
    model = system(connect(mass.flange, spring.a), connect(spring.b, wall.flange), mass=mass, spring=spring, wall=wall)
    r = attempt(model)
    assert r.ending.status is RunStatus.FAILED
    assert r.ending.path == parse_path("spring.displacement")
    assert r.ending.time == pytest.approx(math.asin(0.5), abs=0.11)
    value = r.at_end("spring.displacement")
    assert value > 0.5
    assert r.ending.message == (
        f"stopped at {r.ending.time:.6g} s: the state spring.displacement = {value:.6g} m has left the range it is "
        "meant for"
    )
    assert attempt(model, parameters={"spring.travel": 1.5}).ending.is_complete


class Bent(Resistance):
    """F = L (1 + v^2 / w^2), least at rest, so that some forces belong to two speeds and some to none."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    least: Parameter = parameter("N")
    width: Parameter = parameter("m/s", default=1.0)

    def effort(self, flow: Expr) -> Expr:
        return self.least * (1.0 + (flow / self.width) * (flow / self.width))


class FadingPush(EffortSource):
    flange = Port(Translation)
    force: Parameter = parameter("N")
    rate: Parameter = parameter("N/s")

    def effort(self) -> Expr:
        return self.rate * time - self.force


def test_a_loop_without_solution_stops_the_run_and_names_its_elements():
    # 4 v + 4 (1 + v^2) = 6 - t has the solution v = (sqrt(3 - t) - 1) / 2 up to t = 3 s, and none after.
    push, damper, bent, wall = FadingPush(force=6.0, rate=1.0), Damper(damping=4.0), Bent(least=4.0), Fixed()
    r = attempt(
        system(
            connect(push.flange, damper.a, bent.a),
            connect(damper.b, bent.b, wall.flange),
            push=push,
            damper=damper,
            bent=bent,
            wall=wall,
        )
    )
    assert r.ending.status is RunStatus.FAILED
    assert str(r.ending.path) in ("bent", "damper")  # whichever the loop was torn at
    assert r.ending.time == pytest.approx(3.0, abs=0.01)
    assert (
        r.ending.message == f"stopped at {r.ending.time:.6g} s: Newton's method found no solution for {r.ending.path}"
    )
    assert r["bent.port.flow"] == pytest.approx((np.sqrt(3.0 - r.time) - 1.0) / 2.0, abs=1e-6)


def test_a_free_port_of_the_root_takes_no_power():
    class Open(Component):
        end = Port(Translation)
        mass = Mass(mass=1.0, start_velocity=1.0)
        damper = Damper(damping=2.0)
        connections = (connect(mass.flange, damper.a), connect(damper.b, end), free(end))

    r = run(Open(), 1.0)
    assert r["mass.flange.flow"] == pytest.approx(1.0)
