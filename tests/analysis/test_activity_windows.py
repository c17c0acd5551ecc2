"""Rankings over windows of a run and over several scenarios, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.ranking import ActivityRanking
from propermodel.analysis.windows import period_for, windows_of
from propermodel.compiler import CompiledModel, Method
from propermodel.diagnostics import Path, ReductionError, parse_path
from propermodel.expressions import Expr, sin, time, where
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import FlowSource, Parameter, Port, Translation, connect, parameter
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory
from tests.physics.systems import Drag, Moving, compiled, scenario, system

LARGE, SMALL = Path(("large",)), Path(("small",))


class Manoeuvre(FlowSource):
    """Half a sine of velocity from 5 to 6 s, otherwise still."""

    flange = Port(Translation)
    velocity: Parameter = parameter("m/s", default=1.0)
    duration: Parameter = parameter("s", default=1.0)

    def flow(self) -> Expr:
        turn = time / self.duration
        return self.velocity * where(turn < 5.0, 0.0, where(turn < 6.0, sin(math.pi * (turn - 5.0)), 0.0))


@cache
def mission() -> CompiledModel:
    """A damper that works all the time, with 1 W, and one that works 1 J in the sixth second alone."""
    drive, manoeuvre, wall = Moving(velocity=1.0), Manoeuvre(), Fixed()
    large, small = Damper(damping=1.0), Damper(damping=2.0)
    return compiled(
        system(
            connect(drive.flange, large.a),
            connect(manoeuvre.flange, small.a),
            connect(large.b, small.b, wall.flange),
            drive=drive,
            manoeuvre=manoeuvre,
            large=large,
            small=small,
            wall=wall,
        )
    )


@cache
def long_run(stop: float = 120.0, step: float = 1e-2, every: float = 1.0) -> Trajectory:
    return simulate(mission(), scenario(stop), method=Method.RK4, step=step, record_every=stop, integrals_every=every)


def kept(ranking: ActivityRanking, threshold: float = 0.99) -> set[str]:
    return {str(row.path) for row in ranking.kept_by(threshold)}


# -- windows ---------------------------------------------------------------------------------------------


def test_a_short_manoeuvre_in_a_long_mission_is_not_diluted():
    whole = rank_activity(long_run())
    assert whole.row(SMALL).index == pytest.approx(1.0 / 121.0, rel=1e-6)
    assert kept(whole) == {"large"}
    ranking = rank_activity(long_run(), windows=120)
    assert ranking.row(SMALL).index == whole.row(SMALL).index
    assert ranking.row(SMALL).largest_index == pytest.approx(0.5, rel=1e-6)
    assert ranking.row(SMALL).largest_in == "scenario, 5 to 6 s"
    assert kept(ranking) == {"large", "small"}


@pytest.mark.parametrize(
    ("windows", "index"), [(60, 1.0 / 3.0), ("4 s", 1.0 / 5.0), (((4.0, 7.0), (20.0, 30.0)), 1.0 / 4.0)]
)
def test_windows_are_a_number_a_length_or_pairs(windows, index):
    assert rank_activity(long_run(), windows=windows).row(SMALL).largest_index == pytest.approx(index, rel=1e-6)


def test_windows_that_cover_a_run_have_its_activity():
    ranking = rank_activity(long_run(), windows="7 s")  # 17 windows and one of 1 s
    assert len(ranking.parts) == 18
    assert ranking.parts[-1].window == (119.0, 120.0)
    for row in ranking.rows:
        assert sum(part.activities[row.path] for part in ranking.parts) == pytest.approx(row.activity, rel=1e-12)


def test_windows_keep_all_that_the_whole_keeps():
    for threshold in (0.5, 0.9, 0.999, 1.0):
        assert kept(rank_activity(long_run()), threshold) <= kept(rank_activity(long_run(), windows=10), threshold)


def test_windows_end_with_a_run_that_ends_between_integrals():
    run = long_run(stop=7.4)
    ranking = rank_activity(run, windows=[(5.0, 7.4)])
    assert ranking.parts[0].activities[LARGE] == pytest.approx(2.4, rel=1e-9)


def test_windows_stay_inside_the_window():
    ranking = rank_activity(long_run(), window=(4.0, 8.0), windows=4)
    assert [part.window for part in ranking.parts] == [(4.0, 5.0), (5.0, 6.0), (6.0, 7.0), (7.0, 8.0)]
    assert ranking.row(SMALL).index == pytest.approx(1.0 / 5.0, rel=1e-6)


def test_windows_between_kept_integrals_are_refused_with_the_period_that_would_do():
    with pytest.raises(ReductionError) as caught:
        rank_activity(long_run(), windows=[(0.0, 0.75)])
    assert str(caught.value) == (
        "error[activity/coarse]: the activity until 0.75 s is not known: integrals of power were kept every 1 s\n"
        "  help: begin and end windows where they were kept, or keep them more often: simulate(..., "
        "integrals_every=0.75)"
    )
    fine = long_run(stop=10.0, every=0.75)
    assert rank_activity(fine, windows=[(0.0, 0.75)]).parts[0].activities[LARGE] == pytest.approx(0.75, rel=1e-9)


@pytest.mark.parametrize(
    ("windows", "message"),
    [
        (0, "0 is no number of windows"),
        ([], "there are no windows"),
        ([(3.0, 3.0)], "3 to 3 s is no window of a run from 0 to 120 s"),
        ([(100.0, 121.0)], "100 to 121 s is no window"),
        ("10 kg", "'10 kg' is no length of windows"),
        ("-1 s", "windows of -1 s do not divide a run of 120 s"),
        ("1 us", "windows of 1 us do not divide"),
    ],
)
def test_what_is_no_window_is_refused(windows, message):
    with pytest.raises(ReductionError, match=message):
        rank_activity(long_run(), windows=windows)


def test_the_period_for_windows_divides_all_their_edges():
    assert period_for([(0.0, 0.6), (1.5, 10.0)], 0.0, 10.0, 1.0) == pytest.approx(0.3)
    assert period_for([(2.0, 4.0)], 1.0, 10.0, 0.4) == pytest.approx(1.0 / 3.0)
    assert period_for([(0.0, 10.0)], 0.0, 10.0, 0.5) == 0.5
    assert period_for([(0.0, 1e-6)], 0.0, 1.0, 1.0) is None
    assert windows_of("2.5 s", 0.0, 5.0) == ((0.0, 2.5), (2.5, 5.0))


def test_a_window_in_which_almost_nothing_happens_keeps_nothing_and_is_named():
    mass, spring, drag, wall = Mass(mass=1.0, start_velocity=1.0), Spring(stiffness=400.0), Drag(damping=2.0), Fixed()
    model = compiled(
        system(
            connect(mass.flange, spring.a, drag.flange),
            connect(spring.b, wall.flange),
            mass=mass,
            spring=spring,
            drag=drag,
            wall=wall,
        )
    )
    # Energy decays as exp(-2 t): the last window begins with exp(-20) of it.
    run = simulate(model, scenario(20.0), method=Method.RK4, step=1e-3, record_every=20.0)
    ranking = rank_activity(run, windows=2)
    first, last = ranking.parts
    assert (first.is_idle, last.is_idle) == (False, True)
    assert last.total > 0.0
    assert last.index(Path(("drag",))) == 0.0
    assert last.kept_by(1.0) == set()
    assert ranking.notes == ("idle, with a mean power below 0.001 of that of the run: scenario, 10 to 20 s",)
    assert ranking.notes[0] in str(ranking)
    busy = rank_activity(run, windows=2, idle_below=0.0)
    assert not busy.parts[1].is_idle
    assert busy.notes == ()


def test_a_window_in_which_nothing_happens_is_idle_at_any_floor():
    run = simulate(mission(), scenario(3.0, parameters={"drive.velocity": 0.0}), method=Method.RK4, step=1e-2)
    with pytest.raises(ReductionError, match="nothing is active"):
        rank_activity(run)
    late = simulate(mission(), scenario(8.0, parameters={"drive.velocity": 0.0}), method=Method.RK4, step=1e-2)
    ranking = rank_activity(late, windows=8, idle_below=0.0)
    assert [part.is_idle for part in ranking.parts] == [number != 5 for number in range(8)]


def test_the_check_with_finer_steps_covers_every_window():
    coarse, fine = long_run(stop=10.0, step=0.1), long_run(stop=10.0, step=0.05)
    ranking = rank_activity(coarse, refined=fine, windows=10)
    finer = rank_activity(fine, windows=10)
    for part, other in zip(ranking.parts, finer.parts, strict=True):
        for path in part.activities:
            change = 100.0 * abs(part.index(path) - other.index(path))
            assert part.changes[path] == pytest.approx(change, abs=1e-12)
    assert ranking.discretisation is not None
    worst = max(max(part.changes.values()) for part in ranking.parts)
    assert ranking.discretisation.largest_change_points == worst
    assert worst > max(row.change_points or 0.0 for row in ranking.rows) > 0.0


# -- scenarios -------------------------------------------------------------------------------------------


def two_scenarios() -> list[Trajectory]:
    slow = replace(scenario(6.0), name="manoeuvre", parameters={parse_path("drive.velocity"): 0.0})
    fast = replace(scenario(4.0), name="cruise", parameters={parse_path("drive.velocity"): 20.0})
    return [simulate(mission(), each, method=Method.RK4, step=1e-2) for each in (slow, fast)]


def test_scenarios_are_ranked_each_by_itself_and_together():
    ranking = rank_activity(two_scenarios())
    assert [part.name for part in ranking.parts] == ["manoeuvre", "cruise"]
    assert [part.index(SMALL) for part in ranking.parts] == pytest.approx([1.0, 0.0])
    assert ranking.row(SMALL).largest_in == "manoeuvre"
    assert ranking.row(LARGE).largest_in == "cruise"
    assert ranking.total == pytest.approx(1.0 + 1600.0, rel=1e-6)
    assert ranking.row(SMALL).index == pytest.approx(1.0 / 1601.0, rel=1e-6)
    assert kept(ranking) == {"large", "small"}
    assert ranking.scenario == "manoeuvre, cruise"
    assert "manoeuvre" in str(ranking)


def test_a_plan_keeps_what_any_scenario_needs():
    runs = two_scenarios()
    alone = plan_reduction(mission(), runs[1], rank_activity(runs[1]), threshold=0.99)
    assert [str(d.row.path) for d in alone.removed] == ["small"]
    together = plan_reduction(mission(), runs[1], rank_activity(runs), threshold=0.99)
    assert together.removed == ()


def test_scenarios_and_windows_go_together():
    ranking = rank_activity(two_scenarios(), windows=[(0.0, 2.0), (2.0, 4.0)])
    assert [part.name for part in ranking.parts] == [
        "manoeuvre",
        "manoeuvre, 0 to 2 s",
        "manoeuvre, 2 to 4 s",
        "cruise",
        "cruise, 0 to 2 s",
        "cruise, 2 to 4 s",
    ]


def test_runs_that_do_not_belong_together_are_refused():
    mass, drag = Mass(mass=1.0, start_velocity=1.0), Drag(damping=2.0)
    other = simulate(compiled(system(connect(mass.flange, drag.flange), mass=mass, drag=drag)), scenario(1.0))
    with pytest.raises(ReductionError, match=r"error\[activity/runs\]: the runs are of models with different rows"):
        rank_activity([long_run(), other])
    with pytest.raises(ReductionError, match="0 runs and 0 refined runs cannot be ranked"):
        rank_activity([])
    with pytest.raises(ReductionError, match="2 runs and 1 refined runs cannot be ranked"):
        rank_activity([long_run(), long_run()], refined=[long_run()])


def test_a_row_that_is_not_there_is_refused():
    with pytest.raises(ReductionError) as caught:
        rank_activity(long_run()).row(Path(("smal",)))
    assert str(caught.value).startswith(
        "error[activity/unknown-row]: the ranking has no row 'smal'\n  help: did you mean"
    )
