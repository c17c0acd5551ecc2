"""Merged elements: the formula of the textbook, and the same answer to rounding."""

from __future__ import annotations

import pytest

import propermodel as pm
from propermodel.diagnostics import ReductionError, SimulationError, parse_path
from propermodel.library.mechanics.rotation import Gear, RotatingInertia, ViscousFriction
from propermodel.library.mechanics.translation import Damper, Fixed, HardeningSpring, Mass, Spring
from propermodel.modelling import Component, Merge, connect, elaborate
from propermodel.modelling.documents import from_document, to_document
from propermodel.reduction.merges import MergedElement, find_merges
from tests.parts import Capacitor, Coil, Ground, Resistor
from tests.physics.systems import Drive, Shaking, SineVoltage, close, compiled, run, system
from tests.reduction.rigs import driveline


def merged(part: Component) -> tuple[pm.CompiledModel, pm.CompiledModel, tuple[MergedElement, ...]]:
    full = compiled(part)
    found = find_merges(full)
    return full, compiled(full.model.without(r for merge in found for r in merge.removals)), found


def same(full: pm.CompiledModel, other: pm.CompiledModel, names: list[str], stop: float = 2.0) -> None:
    one, two = run(full, stop, step=1e-3), run(other, stop, step=1e-3)
    for name in names:
        close(two[name], one[name], 1e-10)


def test_inertias_through_a_gear_are_reflected():
    full, other, (found,) = merged(driveline())
    assert found.dependent
    assert found.formula == "engine.inertia + pinion.inertia/gear.ratio**2"
    assert found.value == pytest.approx(0.2 + 0.05 / 2.0**2)
    assert full.system.causal.derivative
    assert not other.system.causal.derivative
    assert len(other.system.rows) == len(full.system.rows) - 1
    names = [
        f"{part}.shaft.{what}" for part in ("engine", "pinion") for what in ("flow", "effort", "momentum", "power")
    ]
    same(full, other, [*names, "load.shaft.flow", "load.shaft.effort", "drive.shaft.power"])


def stiff() -> list[pm.Removal]:
    """The shaft of the driveline made rigid."""
    return [pm.ZeroFlow(parse_path("shaft.spring.port")), pm.ZeroFlow(parse_path("shaft.damper.port"))]


def test_what_removals_have_joined_can_be_one():
    full = compiled(driveline())
    rigid = compiled(full.model.without(stiff()))
    (found,) = find_merges(rigid)
    assert found.dependent
    assert found.formula == "engine.inertia + pinion.inertia/gear.ratio**2 + load.inertia/gear.ratio**2"
    assert found.value == pytest.approx(0.2 + (0.05 + 1.5) / 2.0**2)
    other = compiled(rigid.model.without(found.removals))
    assert rigid.system.causal.derivative
    assert not other.system.causal.derivative
    assert [str(row.path) for row in other.system.rows] == ["bearing", "engine_merged"]
    # The knobs of all three still turn.
    given = {"load.inertia": 0.7, "pinion.inertia": 0.4}
    one, two = (run(model, 2.0, parameters=given) for model in (rigid, other))
    for part in ("engine", "pinion", "load"):
        for what in ("flow", "momentum"):
            close(two[f"{part}.shaft.{what}"], one[f"{part}.shaft.{what}"], 1e-10)


def test_merging_comes_after_what_is_written_before_it_and_before_the_rest():
    full = compiled(driveline())
    (gear,) = find_merges(full)
    first = compiled(full.model.without([*gear.removals, *stiff()]))
    last = compiled(full.model.without([*stiff(), *gear.removals]))
    same(first, last, ["engine.shaft.flow", "load.shaft.flow", "pinion.shaft.effort"])
    gone = full.model.without([*gear.removals, pm.ZeroEffort(parse_path("engine_merged.shaft"))])
    assert {str(row.path) for row in compiled(gone).system.rows} == {"bearing", "load", "shaft.damper", "shaft.spring"}


def test_a_plan_offers_what_its_removals_have_joined():
    full = compiled(driveline())
    one = run(full, 4.0, step=1e-4, every=2e-3)
    reduction = pm.plan_reduction(full, one, pm.rank_activity(one), threshold=0.95, tolerance=0.2)
    (merge,) = reduction.merges
    assert str(merge) == "load into engine: inertia engine.inertia + load.inertia/gear.ratio**2 = 0.575"
    assert f"could be one: {merge}" in str(reduction)
    small = compiled(full.model.without([*reduction.removals, *merge.removals]))
    same(compiled(full.model.without(reduction.removals)), small, ["engine.shaft.flow", "load.shaft.flow"])
    assert len(small.system.states) == 1
    whole = pm.plan_reduction(full, one, pm.rank_activity(one), threshold=1.0)
    assert whole.merges == ()  # engine and pinion could be one, but no removal has brought that about


def three_wheels() -> Component:
    """Two gears in a row, three inertias that start at different speeds."""
    drive, first, gear = Drive(torque=5.0), RotatingInertia(inertia=0.2, start_speed=3.0), Gear(ratio=2.0)
    second, reducer = RotatingInertia(inertia=0.4), Gear(ratio=3.0)
    third, friction = RotatingInertia(inertia=2.0, start_speed=1.0), ViscousFriction(damping=0.3)
    return system(
        connect(drive.shaft, first.shaft, gear.a),
        connect(gear.b, second.shaft, reducer.a),
        connect(reducer.b, third.shaft, friction.shaft),
        drive=drive,
        first=first,
        gear=gear,
        second=second,
        reducer=reducer,
        third=third,
        friction=friction,
    )


def test_a_whole_train_becomes_one_inertia_and_keeps_its_momentum():
    full, other, (found,) = merged(three_wheels())
    assert len(found.removals) == 2
    n = {"first": 1.0, "second": 0.5, "third": 0.5 / 3.0}
    size = {"first": 0.2, "second": 0.4, "third": 2.0}
    total = sum(size[k] * n[k] ** 2 / n[str(found.into.parent)] ** 2 for k in n)
    assert found.value == pytest.approx(total)
    same(full, other, [f"{part}.shaft.{what}" for part in n for what in ("flow", "effort", "momentum")])


def circuit() -> Component:
    """Two of each in series on a voltage, and two of each in parallel behind them."""
    source, ground = SineVoltage(voltage=1.0, frequency=1.0), Ground()
    r1, r2 = Resistor(resistance=1.0), Resistor(resistance=2.0)
    l1, l2 = Coil(inductance=0.1), Coil(inductance=0.3)
    c1, c2 = Capacitor(capacitance=0.05), Capacitor(capacitance=0.02)
    g1, g2 = Resistor(resistance=4.0), Resistor(resistance=12.0)
    return system(
        connect(source.a, r1.a),
        connect(r1.b, r2.a),
        connect(r2.b, l1.a),
        connect(l1.b, l2.a),
        connect(l2.b, c1.a, c2.a, g1.a, g2.a),
        connect(c1.b, c2.b, g1.b, g2.b, source.b, ground.pin),
        source=source,
        ground=ground,
        r1=r1,
        r2=r2,
        l1=l1,
        l2=l2,
        c1=c1,
        c2=c2,
        g1=g1,
        g2=g2,
    )


def test_series_and_parallel_elements_follow_the_textbook():
    full, other, found = merged(circuit())
    values = {frozenset({str(m.into.parent), *(str(r.bond.parent) for r in m.removals)}): m.value for m in found}
    assert values == {
        frozenset({"r1", "r2"}): pytest.approx(3.0),
        frozenset({"l1", "l2"}): pytest.approx(0.4),
        frozenset({"c1", "c2"}): pytest.approx(1.0 / 0.07),  # as a stiffness, 1 / C
        frozenset({"g1", "g2"}): pytest.approx(3.0),
    }
    assert len(other.system.rows) == 4
    names = ["r1", "r2", "l1", "l2", "c1", "c2", "g1", "g2"]
    same(full, other, [f"{name}.port.{what}" for name in names for what in ("effort", "flow")])


def springs() -> Component:
    """A mass between two walls on parallel springs with other preloads, and two springs in series to a shaker."""
    mass, wall, shaker = Mass(mass=2.0), Fixed(), Shaking(velocity=0.5, frequency=1.0)
    first, second = Spring(stiffness=30.0, start_compression=0.1), Spring(stiffness=50.0, start_compression=-0.2)
    near, far = Spring(stiffness=20.0), Spring(stiffness=60.0)
    damper, brake = Damper(damping=1.0), Damper(damping=0.5)
    return system(
        connect(mass.flange, first.a, second.a, damper.a, brake.a, near.a),
        connect(first.b, second.b, damper.b, brake.b, wall.flange),
        connect(near.b, far.a),
        connect(far.b, shaker.flange),
        mass=mass,
        wall=wall,
        shaker=shaker,
        first=first,
        second=second,
        near=near,
        far=far,
        damper=damper,
        brake=brake,
    )


def test_springs_in_parallel_keep_their_force_and_springs_in_series_their_yield():
    full, other, found = merged(springs())
    values = {str(m.into.parent): m.value for m in found}
    assert values["first"] == pytest.approx(80.0)
    assert values["damper"] == pytest.approx(1.5)
    assert [v for k, v in values.items() if k in ("near", "far")] == [pytest.approx(15.0)]
    same(full, other, ["mass.flange.flow", "mass.flange.effort", "near.port.effort", "far.port.displacement"])
    assert len(other.system.states) == len(full.system.states) - 1


def test_what_is_not_linear_or_alone_is_not_merged():
    spring, stiff, mass, wall = (
        Spring(stiffness=3.0),
        HardeningSpring(stiffness=3.0, cubic_stiffness=1.0),
        Mass(mass=1.0),
        Fixed(),
    )
    part = system(
        connect(mass.flange, spring.a, stiff.a),
        connect(spring.b, stiff.b, wall.flange),
        spring=spring,
        stiff=stiff,
        mass=mass,
        wall=wall,
    )
    full = compiled(part)
    assert find_merges(full) == ()
    with pytest.raises(ReductionError, match=r"stiff\.port cannot be merged into spring\.port"):
        compiled(full.model.without([Merge(parse_path("stiff.port"), parse_path("spring.port"))]))


def test_a_merge_is_part_of_the_document():
    model = elaborate(driveline()).without([Merge(parse_path("pinion.shaft"), parse_path("engine.shaft"))])
    again = from_document(to_document(model))
    assert again == model
    assert run(again, 1.0).at_end("load.shaft.flow") == pytest.approx(run(driveline(), 1.0).at_end("load.shaft.flow"))


def test_a_start_of_what_was_merged_is_the_start_of_the_whole():
    model = elaborate(driveline()).without([Merge(parse_path("pinion.shaft"), parse_path("engine.shaft"))])
    for given in ({"engine.shaft.flow": 6.0}, {"pinion.shaft.flow": 3.0}):
        r = run(model, 1.0, initial=given)
        assert r.at_start("engine.shaft.flow") == pytest.approx(6.0)
        assert r.at_start("pinion.shaft.momentum") == pytest.approx(3.0 * 0.05)
    with pytest.raises(SimulationError, match=r"gives a start for 'pinion\.shaft\.momentum'"):
        run(model, 1.0, initial={"pinion.shaft.momentum": 1.0})
