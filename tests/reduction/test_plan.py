"""What a plan proposes and refuses, on cases whose answer is worked out and that activity alone would get wrong."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, ReductionError, StructureError, parse_path
from propermodel.expressions import Expr
from propermodel.library.hydraulics import OpenTank
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, SpringDamper
from propermodel.modelling import (
    Component,
    ConstantEffort,
    ConstantFlow,
    Cut,
    Freeze,
    Input,
    Parameter,
    Port,
    Resistance,
    Translation,
    ZeroEffort,
    ZeroFlow,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import Removal, Variable
from propermodel.reduction.plan import Reduction, Verdict, plan_reduction
from propermodel.simulation.trajectory import Trajectory
from tests.parts import Line, Pipe, Tank
from tests.physics.systems import Shaking, close, compiled, run, state_matrix, system
from tests.reduction.rigs import driveline, preloaded, quarter_car


def planned(
    model: Component | CompiledModel, stop: float, step: float = 5e-4, given=None, **rules
) -> tuple[CompiledModel, Trajectory, Reduction]:
    full = compiled(model)
    r = run(full, stop, step=step, every=stop / 2000.0, **(given or {}))
    return full, r, plan_reduction(full, r, rank_activity(r), **rules)


def verdicts(reduction: Reduction) -> dict[str, Verdict]:
    return {str(d.row.path): d.verdict for d in reduction.decisions}


def amplitude(values: np.ndarray) -> float:
    """Half the range over the second half of a run."""
    return float(np.ptp(values[len(values) // 2 :])) / 2.0


# -- the worked warnings of the method -------------------------------------------------------------------------


def test_a_body_that_is_idle_at_ten_hertz_is_never_made_massless():
    full, r, reduction = planned(quarter_car(velocity=0.3, frequency=10.0), 2.0, threshold=0.99)
    ranking = rank_activity(r)
    assert ranking.row(Path(("body",))).index < 0.01  # activity alone would remove it
    assert ZeroEffort(parse_path("body.flange")) not in reduction.removals
    reduced = run(full.model.without(reduction.removals), 2.0, step=5e-4, every=1e-3)
    tyre = amplitude(r["tyre.a.effort"])
    assert amplitude(reduced["tyre.a.effort"]) == pytest.approx(tyre, rel=0.05)
    # What the type rule (an inertia becomes massless) would have done:
    massless = run(full.model.without([ZeroEffort(parse_path("body.flange"))]), 2.0, step=2e-4, every=1e-3)
    assert abs(amplitude(massless["tyre.a.effort"]) / tyre - 1.0) > 0.5
    held = run(full.model.without([ZeroFlow(parse_path("body.flange"))]), 2.0, step=5e-4, every=1e-3)
    assert amplitude(held["tyre.a.effort"]) == pytest.approx(tyre, rel=0.03)


def test_a_body_driven_one_way_keeps_its_output():
    r = run(quarter_car(velocity=0.3, frequency=10.0), 2.0, step=5e-4, every=1e-3)
    cut = elaborate(quarter_car(velocity=0.3, frequency=10.0)).without(
        [Cut(parse_path("body.flange"), Variable.EFFORT)]
    )
    driven = run(cut, 2.0, step=5e-4, every=1e-3)
    full = amplitude(r["body.flange.effort"])
    assert amplitude(driven["body.flange.effort"]) == pytest.approx(full, rel=0.05)
    assert amplitude(driven["tyre.a.effort"]) == pytest.approx(amplitude(r["tyre.a.effort"]), rel=0.03)


def test_a_protected_output_keeps_its_element():
    def step_road() -> Component:
        return quarter_car(velocity=0.3, frequency=10.0)

    _, _, free = planned(step_road(), 2.0, threshold=0.95)
    _, _, protecting = planned(step_road(), 2.0, threshold=0.95, protected=["body.flange.flow"])
    assert verdicts(free)["body"] is Verdict.REMOVED
    assert verdicts(protecting)["body"] is not Verdict.REMOVED
    reason = next(d.reason for d in protecting.decisions if str(d.row.path) == "body")
    assert reason.endswith("but the protected output body.flange.flow would not exist or would never change")


def test_a_locked_row_stays_and_a_released_one_is_tested():
    car = quarter_car()
    _, _, free = planned(car, 4.0, threshold=0.9)
    gone = free.removed[0].row.path
    _, _, locked = planned(car, 4.0, threshold=0.9, keep=[gone])
    decision = next(d for d in locked.decisions if d.row.path == gone)
    assert (decision.verdict, decision.reason) == (Verdict.KEPT, "locked: it was to be kept")
    assert locked.kept_by_threshold == free.kept_by_threshold
    most = free.decisions[0].row.path
    _, _, released = planned(car, 4.0, threshold=0.9, release=[most])
    decision = next(d for d in released.decisions if d.row.path == most)
    assert decision.verdict is Verdict.REFUSED  # it is tested, and carries the most
    assert decision.cause is not None
    with pytest.raises(ReductionError, match="the ranking has no row 'seat'"):
        planned(car, 4.0, keep=["seat"])


def test_an_unknown_protected_output_is_refused():
    with pytest.raises(ReductionError, match=r"the protected output 'body\.flange\.speed' does not exist"):
        planned(quarter_car(), 0.1, protected=["body.flange.speed"])


def test_a_preload_is_not_dropped_although_it_does_no_work():
    full, r, reduction = planned(preloaded(), 2.0, threshold=0.95, tolerance=0.2)
    assert rank_activity(r).row(Path(("spring",))).index < 0.02
    assert verdicts(reduction)["spring"] is not Verdict.KEPT  # the threshold would let it go
    assert ZeroEffort(parse_path("spring.port")) not in reduction.removals
    fallen = run(full.model.without([ZeroEffort(parse_path("spring.port"))]), 2.0, step=5e-4)
    assert np.min(fallen["body.flange.flow"]) < -0.5


def test_what_holds_a_preloaded_body_does_not_go_together():
    # Against the preload each of spring (made constant), damper and body is small. But weight and preload cancel, so
    # that without them the brake, with 30 % of the activity, would push against nothing.
    full, r, reduction = planned(preloaded(), 2.0, threshold=0.95, tolerance=0.2)
    assert rank_activity(r).row(Path(("spring",))).index < 0.02
    assert verdicts(reduction)["spring"] is Verdict.REFUSED
    reason = next(d.reason for d in reduction.decisions if str(d.row.path) == "spring")
    assert "out of 1-junction body.flange, with all that would go there 0.78%" in reason
    (line,) = (line for line in str(reduction).splitlines() if line.split()[0] == "spring")
    assert line.endswith(f"%  refused  {reason}")
    reduced = run(full.model.without(reduction.removals), 2.0, step=5e-4)
    assert np.max(np.abs(reduced["body.flange.flow"])) < 0.2  # without its spring it would fall at 20 m/s
    fallen = run(full.model.without([ZeroEffort(parse_path("spring.port"))]), 2.0, step=5e-4)
    assert np.min(fallen["body.flange.flow"]) < -0.5


def test_small_terms_go_together_where_something_large_stays():
    _, _, reduction = planned(driveline(), 2.0, threshold=0.9, tolerance=0.1)
    assert len(reduction.removed) > 1


# -- constants and groups ----------------------------------------------------------------------------------------


def reservoir() -> Component:
    """A large vessel under pressure feeds a small circuit that swings."""
    vessel = Tank(capacity=1e-3)
    feed = Pipe(loss=1e7)
    line = Line(inertance=1e6)
    chamber = Tank(capacity=1e-8)
    drain = Pipe(loss=1e9)
    sink = OpenTank()
    return system(
        connect(vessel.port, feed.a),
        connect(feed.b, line.a),
        connect(line.b, chamber.port, drain.a),
        connect(drain.b, sink.port),
        vessel=vessel,
        feed=feed,
        line=line,
        chamber=chamber,
        drain=drain,
        sink=sink,
    )


START = {"initial": {"vessel.port.effort": 5e5}}


def test_a_large_vessel_under_pressure_can_be_held_at_its_pressure():
    full = compiled(reservoir())
    r = run(full, 2.0, step=1e-4, **START)
    held = run(full.model.without([ConstantEffort(parse_path("vessel.port"), 5e5)]), 2.0, step=1e-4)
    close(held["chamber.port.effort"], r["chamber.port.effort"], 1e-2)
    assert held["vessel.port.effort"] == pytest.approx(5e5)
    assert len(held.compiled.system.states) == len(full.system.states) - 1


def mixer() -> Component:
    """A large vessel that hardly matters to a busy circuit: its pressure is a small, nearly constant term."""
    shaker = Shaking(velocity=2.0, frequency=2.0)
    mass = Mass(mass=10.0)
    spring = Spring(stiffness=1e4)
    ground = Fixed()
    slow, holder = Spring(stiffness=0.5, start_compression=40.0), Damper(damping=30.0)
    return system(
        connect(shaker.flange, holder.a),
        connect(holder.b, mass.flange, spring.a, slow.a),
        connect(spring.b, slow.b, ground.flange),
        shaker=shaker,
        mass=mass,
        spring=spring,
        ground=ground,
        slow=slow,
        holder=holder,
    )


def test_a_soft_preloaded_spring_becomes_a_constant_force():
    full, r, reduction = planned(mixer(), 3.0, threshold=0.97, tolerance=0.1)
    (removal,) = (x for x in reduction.removals if isinstance(x, ConstantEffort))
    assert removal.bond == parse_path("slow.port")
    assert removal.value == pytest.approx(20.0, rel=0.02)
    reduced = run(full.model.without(reduction.removals), 3.0, step=5e-4, every=3.0 / 2000.0)
    close(reduced["mass.flange.flow"], r["mass.flange.flow"], 0.02)


def with_seat() -> Component:
    road, wheel, body = Shaking(velocity=0.3, frequency=2.0), Mass(mass=80.0), Mass(mass=1200.0)
    tyre, suspension = SpringDamper(stiffness=2.4e5, damping=1.5e2), SpringDamper(stiffness=2.0e4, damping=1.5e3)
    cushion, seat = SpringDamper(stiffness=500.0, damping=20.0), Mass(mass=2.0)
    return system(
        connect(road.flange, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange, cushion.a),
        connect(cushion.b, seat.flange),
        road=road,
        tyre=tyre,
        wheel=wheel,
        suspension=suspension,
        body=body,
        cushion=cushion,
        seat=seat,
    )


def test_a_dangling_group_goes_as_a_whole():
    full, r, reduction = planned(with_seat(), 3.0, threshold=0.99)
    gone = {"cushion.spring", "cushion.damper", "seat"}
    assert gone <= {path for path, verdict in verdicts(reduction).items() if verdict is Verdict.REMOVED}
    assert any(set(map(str, group.rows)) >= gone for group in reduction.groups)
    reduced = compiled(full.model.without(reduction.removals))
    assert not gone & {str(row.path) for row in reduced.system.rows}
    again = run(reduced, 3.0, step=2e-4, every=3.0 / 2000.0)
    close(again["body.flange.flow"], r["body.flange.flow"], 0.02)


# -- refusals ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "removals", "names"),
    [
        # A held body on a moving road over a rigid tyre and suspension: two velocities at one junction.
        (
            quarter_car,
            [
                ZeroFlow(parse_path("tyre.spring.port")),
                ZeroFlow(parse_path("suspension.spring.port")),
                ZeroFlow(parse_path("body.flange")),
            ],
            ["road"],
        ),
        (
            quarter_car,
            [ConstantFlow(parse_path("wheel.flange"), 1.0), ZeroFlow(parse_path("tyre.spring.port"))],
            ["road", "wheel"],
        ),
        (driveline, [ZeroFlow(parse_path("engine.shaft")), ConstantFlow(parse_path("pinion.shaft"), 3.0)], ["pinion"]),
    ],
)
def test_impossible_removals_are_refused_with_the_elements_named(make, removals, names):
    with pytest.raises(StructureError) as caught:
        compiled(elaborate(make()).without(removals))
    for name in names:
        assert name in str(caught.value)


def test_faults_in_the_list_of_removals_are_named():
    model = elaborate(quarter_car())

    def fault(*removals: Removal) -> str:
        with pytest.raises(ReductionError) as caught:
            compiled(model.without(removals))
        return str(caught.value)

    assert fault(ZeroEffort(parse_path("tyre.damper.prot"))) == (
        "error[reduction/unknown-removal]: a removal names 'tyre.damper.prot', which is no bond of the model in normal "
        "form\n"
        "  help: did you mean 'tyre.damper.port'?"
    )
    twice = parse_path("wheel.flange")
    assert fault(ZeroEffort(twice), ZeroFlow(twice)) == (
        "error[reduction/removed-twice]: 'wheel.flange' is removed 2 times\n"
        "  help: keep one of the removals that name this bond"
    )
    inner = next(name for name in compiled(model).graph.normal.bonds if name.name == "carried")
    assert f"'{inner}' joins two junctions: there is no element to hold constant" in fault(ConstantEffort(inner, 1.0))
    assert "body.flange cannot be driven by the flow of the 0-junction" in fault(
        Cut(parse_path("body.flange"), Variable.FLOW)
    )


def test_what_a_plan_removes_can_always_be_compiled():
    for threshold in (0.999, 0.97, 0.9, 0.7, 0.5, 0.0):
        for tolerance in (0.01, 0.1, 1.0):
            full, _, reduction = planned(quarter_car(), 1.0, threshold=threshold, tolerance=tolerance)
            reduced = compiled(full.model.without(reduction.removals))
            kept = {d.row.path for d in reduction.kept}
            assert kept == {row.path for row in reduced.system.rows}


def test_nothing_goes_at_full_threshold():
    _full, _, reduction = planned(quarter_car(), 1.0, threshold=1.0)
    assert reduction.removals == ()
    assert reduction.kept_activity == pytest.approx(1.0)
    assert "nothing can be removed at this threshold" in str(reduction)


def test_a_plan_is_the_same_for_other_orders_of_parts():
    def ordered(names: Iterable[str]) -> Component:
        part = quarter_car()
        parts = {name: part.declarations[name] for name in names}
        return type("System", (Component,), {**parts, "connections": type(part).connections})()

    names = ["road", "tyre", "wheel", "suspension", "body"]
    for threshold in (0.999, 0.97, 0.9):
        plans = [planned(ordered(order), 2.0, threshold=threshold, tolerance=0.1)[2] for order in (names, names[::-1])]
        assert set(plans[0].removals) == set(plans[1].removals)


# -- signals of removed parts --------------------------------------------------------------------------------------


class Adjustable(Resistance):
    """A damper whose damping follows a signal."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    base: Parameter = parameter("N.s/m")
    reading = Input("N")
    scale: Parameter = parameter("N")

    def effort(self, flow: Expr) -> Expr:
        return self.base * (1.0 + 0.1 * self.reading / self.scale) * flow


def sensing() -> Component:
    """A busy oscillator whose damper listens to a small spring that hardly works."""
    shaker, spring, mass = Shaking(velocity=1.0, frequency=1.5), Spring(stiffness=400.0), Mass(mass=5.0)
    damper, ground = Adjustable(base=20.0, scale=1.0), Fixed()
    feeler, tip = Spring(stiffness=0.2), Damper(damping=0.05)
    return system(
        connect(shaker.flange, spring.a),
        connect(spring.b, mass.flange, damper.a, feeler.a),
        connect(feeler.b, tip.a),
        connect(damper.b, tip.b, ground.flange),
        connect(feeler.port.effort, damper.reading),
        shaker=shaker,
        spring=spring,
        mass=mass,
        damper=damper,
        ground=ground,
        feeler=feeler,
        tip=tip,
    )


def test_a_signal_of_a_removed_part_keeps_its_mean():
    full, r, reduction = planned(sensing(), 3.0, threshold=0.97, tolerance=0.1)
    removed = {str(d.row.path) for d in reduction.removed}
    assert {"feeler", "tip"} <= removed
    (frozen,) = reduction.frozen
    assert frozen == Freeze(parse_path("damper.reading"), pytest.approx(float(np.mean(r["damper.reading"]))))
    assert frozen in reduction.removals
    reduced = run(full.model.without(reduction.removals), 3.0, step=5e-4, every=3.0 / 2000.0)
    assert reduced["damper.reading"] == pytest.approx(frozen.value)
    close(reduced["mass.flange.flow"], r["mass.flange.flow"], 0.05)


def test_an_unknown_signal_cannot_be_frozen():
    model = elaborate(sensing()).without([Freeze(parse_path("damper.readin"), 0.0)])
    with pytest.raises(Exception, match=r"a removal freezes 'damper\.readin', which is no signal of this model"):
        compiled(model)


# -- documents and further reduction ---------------------------------------------------------------------------------


def test_a_reduced_model_comes_back_from_its_document_and_runs_the_same():
    full, _, reduction = planned(sensing(), 3.0, threshold=0.97, tolerance=0.1)
    reduced = full.model.without(reduction.removals)
    again = from_document(to_document(reduced))
    assert again == reduced
    one, other = run(reduced, 1.0), run(again, 1.0)
    assert one["mass.flange.flow"].tobytes() == other["mass.flange.flow"].tobytes()


def test_a_plan_can_be_made_for_a_reduced_model():
    full, r, first = planned(quarter_car(0.2, 1.0), 2.0, threshold=0.999, tolerance=0.1)
    reduced = compiled(full.model.without(first.removals))
    _, _, second = planned(reduced, 2.0, step=2e-4, threshold=0.97, tolerance=0.1)
    assert first.removals
    assert second.removals
    both = compiled(reduced.model.without(second.removals))
    assert len(both.system.rows) == len(full.system.rows) - len(first.removed) - len(second.removed)
    again = run(both, 2.0, step=1e-4, every=1e-3)
    close(again["body.flange.flow"], r["body.flange.flow"], 0.05)
    assert state_matrix(both).shape[0] < state_matrix(full).shape[0]
