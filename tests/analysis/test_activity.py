"""Activity against the identities that define it (Louca, Stein and Hulbert 2010)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from propermodel.analysis.activity import bond_activities, rank_activity, row_activities
from propermodel.analysis.ranking import ActivityRanking, ActivityRow
from propermodel.compiler import Method
from propermodel.diagnostics import Path, ReductionError, parse_path
from propermodel.expressions import Expr
from propermodel.library.mechanics.translation import Damper, Fixed, GasSpring, Mass, Spring
from propermodel.library.thermal import HeatCapacity
from propermodel.modelling import (
    Compliance,
    Component,
    Domain,
    Parameter,
    Port,
    Resistance,
    Shared,
    Translation,
    connect,
    parameter,
)
from propermodel.simulation.simulate import simulate
from tests.parts import Capacitor, Coil, Ground, Resistor
from tests.physics.systems import Moving, Push, Shaking, SineVoltage, Wall, compiled, run, scenario, system


def damped(order: tuple[str, ...] = ("mass", "spring", "damper", "wall")) -> Component:
    parts: dict[str, Any] = {
        "mass": Mass(mass=2.0, start_velocity=0.3),
        "spring": Spring(stiffness=50.0),
        "damper": Damper(damping=3.0),
        "wall": Fixed(),
    }
    return system(
        connect(parts["mass"].flange, parts["spring"].a, parts["damper"].a),
        connect(parts["spring"].b, parts["damper"].b, parts["wall"].flange),
        **{name: parts[name] for name in order},
    )


def total_variation(values: np.ndarray) -> float:
    return float(np.sum(np.abs(np.diff(values))))


# -- identities --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ["mass", "spring"])
def test_the_activity_of_a_storage_is_the_total_variation_of_its_energy(element):
    r = run(damped(), 3.0, step=1e-3, every=1e-3)
    assert row_activities(r)[Path((element,))] == pytest.approx(total_variation(r[f"{element}.energy"]), rel=1e-5)


def test_the_activity_of_a_resistance_is_what_it_dissipates():
    r = run(damped(), 3.0)
    lost = sum(r.at_start(f"{name}.energy") - r.at_end(f"{name}.energy") for name in ("mass", "spring"))
    activity = row_activities(r)[Path(("damper",))]
    assert activity == pytest.approx(r.work(parse_path("damper.port")), rel=1e-12)
    assert activity == pytest.approx(lost, rel=1e-8)


def test_a_storage_that_only_fills_has_the_activity_of_its_energy():
    push, mass = Push(force=10.0), Mass(mass=2.0)
    r = run(system(connect(push.flange, mass.flange), push=push, mass=mass), 3.0)
    assert row_activities(r)[Path(("mass",))] == pytest.approx(0.5 * 2.0 * 15.0**2, rel=1e-10)


def test_a_sine_through_a_series_circuit_has_the_known_activities_per_period():
    # Over a period: I 2 L i^2, C 2 C u^2, R pi R i^2 / w, with amplitudes i and u.
    resistance, inductance, capacitance, frequency, amplitude = 20.0, 0.02, 1e-4, 50.0, 10.0
    source = SineVoltage(voltage=amplitude, frequency=frequency)
    r = Resistor(resistance=resistance)
    l = Coil(inductance=inductance)
    c = Capacitor(capacitance=capacitance)
    ground = Ground()
    model = system(
        connect(source.a, r.a),
        connect(r.b, l.a),
        connect(l.b, c.a),
        connect(c.b, source.b, ground.pin),
        source=source,
        r=r,
        l=l,
        c=c,
        ground=ground,
    )
    trajectory = simulate(
        compiled(model), scenario(1.0), method=Method.RK4, step=1e-5, record_every=0.1, integrals_every=0.02
    )
    ranking = rank_activity(trajectory, window=(0.98, 1.0))
    w = 2.0 * math.pi * frequency
    current = amplitude / abs(complex(resistance, w * inductance - 1.0 / (w * capacitance)))
    assert ranking.row(Path(("l",))).activity == pytest.approx(2.0 * inductance * current**2, rel=1e-4)
    assert ranking.row(Path(("c",))).activity == pytest.approx(2.0 * current**2 / (w**2 * capacitance), rel=1e-4)
    assert ranking.row(Path(("r",))).activity == pytest.approx(math.pi * resistance * current**2 / w, rel=1e-6)


def test_indices_of_a_linear_model_do_not_depend_on_the_amplitude():
    def ranking(velocity):
        shaker = Shaking(velocity=velocity, frequency=1.0)
        spring = Spring(stiffness=50.0)
        damper = Damper(damping=3.0)
        mass = Mass(mass=2.0)
        model = system(
            connect(shaker.flange, spring.a, damper.a),
            connect(spring.b, damper.b, mass.flange),
            shaker=shaker,
            spring=spring,
            damper=damper,
            mass=mass,
        )
        return rank_activity(run(model, 3.0))

    small, large = ranking(0.1), ranking(10.0)
    assert large.total == pytest.approx(1e4 * small.total, rel=1e-9)
    assert [row.index for row in large.rows] == pytest.approx([row.index for row in small.rows], rel=1e-9)


def gas() -> Component:
    mass = Mass(mass=50.0, start_velocity=1.0)
    spring = GasSpring(gas_volume=2e-3, piston_area=1e-2, static_pressure=5e5)
    ground = Fixed()
    wall, shell = Wall(conductance=8.0), HeatCapacity(capacity=300.0)
    return system(
        connect(mass.flange, spring.a),
        connect(spring.b, ground.flange),
        connect(spring.wall, wall.a),
        connect(wall.b, shell.port),
        mass=mass,
        spring=spring,
        ground=ground,
        wall=wall,
        shell=shell,
    )


def test_a_field_counts_the_power_of_its_ports_together_and_each_port_alone():
    r = run(gas(), 1.0, step=1e-3, every=1e-3)
    row = rank_activity(r).row(Path(("spring",)))
    assert row.activity == pytest.approx(total_variation(r["spring.energy"]), rel=1e-4)
    ports = dict(row.ports)
    assert set(ports) == {parse_path("spring.port"), parse_path("spring.wall")}
    assert row.activity <= sum(ports.values()) * (1.0 + 1e-12)
    assert row.activity < 0.999 * sum(ports.values())  # heat and work do flow against each other here


class Brake(Component):
    """Two frictions declared as one energy element."""

    flange = Port(Translation)
    energy_group = True
    first = Damper(damping=1.0)
    second = Damper(damping=2.0)
    ground = Fixed()
    connections = (connect(flange, first.a, second.a), connect(first.b, second.b, ground.flange))


def test_a_declared_group_is_one_row():
    mass, brake = Mass(mass=2.0, start_velocity=1.0), Brake()
    r = run(system(connect(mass.flange, brake.flange), mass=mass, brake=brake), 2.0)
    ranking = rank_activity(r)
    row = ranking.row(Path(("brake",)))
    assert {str(path) for path in row.elements} == {"brake.first", "brake.second"}
    assert row.activity == pytest.approx(1.0 - math.exp(-6.0), rel=1e-9)
    assert sum(activity for _, activity in row.ports) == pytest.approx(row.activity)
    assert {str(r.path) for r in ranking.rows} == {"mass", "brake"}


# -- what a ranking does not depend on -----------------------------------------------------------------------


def test_indices_do_not_depend_on_the_recording_grid():
    fine, coarse = (
        simulate(
            compiled(damped()), scenario(3.0), method=Method.RK4, step=1e-3, record_every=every, integrals_every=every
        )
        for every in (0.01, 1.5)
    )
    one, other = rank_activity(fine), rank_activity(coarse)
    assert [row.path for row in one.rows] == [row.path for row in other.rows]
    assert [row.index for row in one.rows] == pytest.approx([row.index for row in other.rows], abs=1e-12)


def test_indices_hardly_depend_on_the_step_and_the_ranking_says_by_how_much():
    model = compiled(damped())
    coarse, fine = run(model, 3.0, step=2e-3), run(model, 3.0, step=1e-3)
    ranking = rank_activity(coarse, refined=fine)
    check = ranking.discretisation
    assert check is not None
    assert check.comparison == "at a step of 0.001 s instead of 0.002 s"
    finer = {row.path: row.index for row in rank_activity(fine).rows}
    changes = {row.path: abs(row.index - finer[row.path]) * 100.0 for row in ranking.rows}
    assert check.largest_change_points == pytest.approx(max(changes.values()), rel=1e-9)
    assert changes[check.largest_change_at] == max(changes.values())
    assert {row.path: row.change_points for row in ranking.rows} == pytest.approx(changes, abs=1e-12)
    assert check.largest_change_points < 0.01
    assert "discretisation check: at a step of 0.001 s instead of 0.002 s" in str(ranking)


def test_an_unchecked_ranking_says_so():
    assert "no discretisation check was made" in str(rank_activity(run(damped(), 1.0)))


def test_a_ranking_does_not_depend_on_the_order_of_parts():
    one = rank_activity(run(damped(), 3.0))
    other = rank_activity(run(damped(("wall", "damper", "spring", "mass")), 3.0))
    assert [row.path for row in one.rows] == [row.path for row in other.rows]
    assert [row.activity for row in one.rows] == pytest.approx([row.activity for row in other.rows], rel=1e-12)


def test_equal_rows_stand_in_the_order_of_their_paths():
    push, z, a, m = Moving(velocity=1.0), Damper(damping=2.0), Damper(damping=2.0), Damper(damping=2.0)
    wall = Fixed()
    model = system(
        connect(push.flange, z.a, a.a, m.a), connect(z.b, a.b, m.b, wall.flange), push=push, z=z, a=a, m=m, wall=wall
    )
    assert [str(row.path) for row in rank_activity(run(model, 1.0)).rows] == ["a", "m", "z"]


# -- the threshold -------------------------------------------------------------------------------------------


def ranking_of(*activities: float) -> ActivityRanking:
    total, cumulative, rows = sum(activities), 0.0, []
    for number, activity in enumerate(activities):
        cumulative += activity
        path = Path((f"e{number}",))
        rows.append(ActivityRow(path, "R", activity, activity / total, cumulative / total, (path,), ()))
    return ActivityRanking(
        rows=tuple(rows), total=total, window=(0.0, 1.0), scenario="", datums=(), discretisation=None
    )


@pytest.mark.parametrize(
    ("activities", "threshold", "kept"),
    [
        ((60.0, 30.0, 9.0, 1.0), 0.0, 0),
        ((60.0, 30.0, 9.0, 1.0), 0.5, 1),
        ((60.0, 30.0, 9.0, 1.0), 0.6, 1),  # met exactly
        ((60.0, 30.0, 9.0, 1.0), 0.61, 2),  # the row that lifts the sum over the threshold stays
        ((60.0, 30.0, 9.0, 1.0), 0.99, 3),
        ((60.0, 30.0, 9.0, 1.0), 1.0, 4),
        ((50.0, 50.0, 0.0), 1.0, 2),  # what is not active is not needed, even for everything
        ((1.0, 1.0, 1.0), 1.0, 3),
        ((25.0, 25.0, 25.0, 25.0), 0.5, 2),  # ties: the first ones
        ((1e17, 1.0, 1.0), 1.0, 3),  # also where rounding lifts the share to one early
    ],
)
def test_rows_are_kept_until_the_threshold_is_reached(activities, threshold, kept):
    assert [str(row.path) for row in ranking_of(*activities).kept_by(threshold)] == [f"e{n}" for n in range(kept)]


@pytest.mark.parametrize("threshold", [-0.1, 1.1, float("nan")])
def test_a_threshold_is_a_share(threshold):
    with pytest.raises(ReductionError, match="not a share between 0 and 1"):
        ranking_of(1.0).kept_by(threshold)


# -- refusals and windows ------------------------------------------------------------------------------------


def test_a_run_in_which_nothing_moves_is_refused():
    mass, spring, wall = Mass(mass=2.0), Spring(stiffness=50.0), Fixed()
    r = run(
        system(connect(mass.flange, spring.a), connect(spring.b, wall.flange), mass=mass, spring=spring, wall=wall), 1.0
    )
    with pytest.raises(ReductionError) as caught:
        rank_activity(r)
    assert str(caught.value) == (
        "error[activity/none]: nothing is active in scenario 'scenario': no element exchanges energy\n"
        "  help: give the scenario inputs or starts that make something move, or a later stop"
    )


def test_a_run_that_was_interrupted_is_refused():
    r = run(damped(), 1.0)
    broken = replace(r, ending=replace(r.ending, status="interrupted", message="interrupted at 0.5 s"))
    with pytest.raises(ReductionError, match=r"the run did not reach its end: interrupted at 0\.5 s"):
        rank_activity(broken)


def test_runs_that_blew_up_are_refused():
    model = compiled(damped())
    good = simulate(model, scenario(10.0), method=Method.RK4, step=1e-2, record_every=1.0)
    blown = simulate(model, scenario(400.0), method=Method.EULER, step=1.0, record_every=1.0)
    for name, given in (("run", (blown, None)), ("refined run", (good, blown))):
        with pytest.raises(ReductionError) as caught:
            rank_activity(given[0], refined=given[1])
        (fault,) = caught.value.diagnostics
        assert fault.code == "activity/incomplete"
        assert fault.message == f"the {name} did not reach its end: {blown.ending.message}"
        assert "is no longer a finite number; try a smaller step" in fault.message


def test_a_window_counts_only_what_happens_in_it():
    model = compiled(damped())
    r = simulate(model, scenario(3.0), method=Method.RK4, step=1e-3, record_every=1.0, integrals_every=0.5)
    parts = [rank_activity(r, window=w) for w in ((0.0, 1.0), (1.0, 3.0))]
    whole = rank_activity(r)
    assert parts[0].total + parts[1].total == pytest.approx(whole.total, rel=1e-12)
    assert parts[1].window == (1.0, 3.0)
    lost = [0.0, 0.0]
    for n, (begin, end) in enumerate(((0.0, 1.0), (1.0, 3.0))):
        energy = r["mass.energy"] + r["spring.energy"]
        lost[n] = float(energy[int(begin)] - energy[int(end)])
        assert parts[n].row(Path(("damper",))).activity == pytest.approx(lost[n], rel=1e-7)


def test_a_window_without_length_is_refused():
    r = run(damped(), 3.0)
    with pytest.raises(ReductionError):
        rank_activity(r, window=(1.0, 1.0))


class PseudoThermal(Domain):
    """Temperature and heat flow: their product is not power."""

    name = "pseudo thermal"
    effort, effort_unit = "temperature", "K"
    flow, flow_unit = "heat flow", "W"
    displacement_unit, momentum_unit = "J", "K.s"
    shared = Shared.EFFORT
    is_true = False


class PseudoBody(Compliance):
    port = Port(PseudoThermal)
    capacity: Parameter = parameter("J/K")

    def effort(self, displacement: Expr) -> Expr:
        return displacement / self.capacity


class PseudoWall(Resistance):
    port = Port(PseudoThermal)
    conductance: Parameter = parameter("W/K")

    def flow(self, effort: Expr) -> Expr:
        return self.conductance * effort


@pytest.mark.filterwarnings("ignore:warning.structure/disconnected:propermodel.ModelWarning")
def test_pseudo_bonds_are_not_ranked_with_true_ones():
    body, leak = PseudoBody(capacity=10.0), PseudoWall(conductance=1.0)
    mass, drag, wall = Mass(mass=1.0, start_velocity=1.0), Damper(damping=1.0), Fixed()
    pseudo = [connect(body.port, leak.port)]
    true = [connect(mass.flange, drag.a), connect(drag.b, wall.flange)]
    mixed = system(*pseudo, *true, body=body, leak=leak, mass=mass, drag=drag, wall=wall)
    with pytest.raises(ReductionError) as caught:
        rank_activity(run(mixed, 1.0, initial={"body.port.displacement": 100.0}))
    assert str(caught.value) == (
        "error[activity/pseudo-bonds]: true and pseudo bonds cannot be ranked together: the product of a pseudo bond "
        "is not power\n"
        "  --> body.port is a pseudo bond (pseudo thermal)\n"
        "  help: rank them apart, rank_activity(run, among='true') or among='pseudo thermal', or write the pseudo "
        "domain as a true one, with entropy flow for heat"
    )
    answer = run(mixed, 1.0, initial={"body.port.displacement": 100.0})
    assert {str(row.path) for row in rank_activity(answer, among="true").rows} == {"mass", "drag"}
    finer = run(mixed, 1.0, step=5e-4, initial={"body.port.displacement": 100.0})
    apart = rank_activity(answer, refined=finer, among="pseudo thermal")
    assert {str(row.path) for row in apart.rows} == {"body", "leak"}
    with pytest.raises(ReductionError, match=r"there are no bonds called 'pseudo thermol' to rank"):
        rank_activity(answer, among="pseudo thermol")
    body, leak = PseudoBody(capacity=10.0), PseudoWall(conductance=1.0)
    alone = system(connect(body.port, leak.port), body=body, leak=leak)
    assert len(rank_activity(run(alone, 1.0, initial={"body.port.displacement": 100.0})).rows) == 2


def test_a_ranking_names_the_datums_its_numbers_depend_on():
    assert rank_activity(run(gas(), 0.1)).datums == (
        "translation: velocity counts from the frame at rest, and with it what inertias take part in",
        "thermal: temperature counts from ambient, so heat counts by what could still do work",
    )


def test_bonds_of_sources_and_between_junctions_have_activities_too():
    r = run(damped(), 1.0)
    activities = bond_activities(r)
    assert activities[parse_path("mass.flange")] == pytest.approx(row_activities(r)[Path(("mass",))])
    assert all(value >= 0.0 for value in activities.values())
