"""Removals that need each other, nothing to rank, hidden use of signals, and laws that fold (modes 14 to 16)."""

from __future__ import annotations

import math

import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.expressions import Expr, tanh
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    Freeze,
    Input,
    Parameter,
    Port,
    Resistance,
    Translation,
    connect,
    parameter,
)
from propermodel.reduction.plan import Verdict, plan_reduction
from propermodel.reduction.search import find_proper_model
from propermodel.reduction.single import Refusal
from tests.physics.systems import Drag, Shaking, SinePush, compiled, run, scenario, system
from tests.reduction.failure_modes.plain import error_without, plain_mora, rows_of

# -- 14: indices change with every removal -------------------------------------------------------------------------


def resonator(damping: float) -> Component:
    """A mass on a spring in resonance, held back by two equal dampers."""
    push = SinePush(force=1.0, frequency=10.0 / (2.0 * math.pi))
    mass, spring, ground = Mass(mass=1.0), Spring(stiffness=100.0), Fixed()
    first, second = Drag(damping=damping), Drag(damping=damping)
    return system(
        connect(push.flange, mass.flange, spring.a, first.flange, second.flange),
        connect(spring.b, ground.flange),
        push=push,
        mass=mass,
        spring=spring,
        ground=ground,
        first=first,
        second=second,
    )


def test_what_is_harmless_alone_may_not_be_together():
    full = compiled(resonator(0.05))
    r = run(full, 80.0, step=5e-3, every=4e-2)
    output = "mass.flange.flow"
    plain = plain_mora(r, 0.97)
    assert rows_of(plain) == {"first", "second"}
    assert error_without(r, plain, output) > 0.3
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.97)
    assert {"first", "second"} <= rows_of(reduction.removals)  # by its own rule too; but then it says
    (note,) = reduction.notes
    assert note.startswith("an oscillation at 1.59 Hz with a damping ratio of 0.005 has one of 0 in the reduced model")
    search = find_proper_model(full.model, scenario(80.0), {output: 0.05}, step=5e-3)
    assert search.best is None or error_without(r, search.best.removals, output) < 0.06


def test_where_damping_does_not_matter_nothing_is_said():
    full = compiled(resonator(30.0))
    r = run(full, 20.0, step=5e-3, every=1e-2)
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.9)
    assert not any("oscillation" in note for note in reduction.notes)


# -- 15: nothing moves ---------------------------------------------------------------------------------------------


def test_a_scenario_in_which_nothing_moves_is_refused():
    r = run(compiled(resonator(0.05)), 1e-3, step=1e-3, parameters={"push.force": 0.0})
    with pytest.raises(ReductionError, match="nothing is active in scenario 'scenario'"):
        rank_activity(r)


# -- 16: a signal from what is gone --------------------------------------------------------------------------------


class Adjustable(Resistance):
    """A damper whose damping follows a signal."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    base: Parameter = parameter("N.s/m")
    reading = Input("N")
    share: Parameter = parameter("1")
    scale: Parameter = parameter("N", default=0.05)

    def effort(self, flow: Expr) -> Expr:
        return self.base * (1.0 + self.share * abs(self.reading) / self.scale) * flow


def sensing(share: float) -> Component:
    """An oscillator whose damper listens to a feeler that hardly works."""
    shaker, spring, mass = Shaking(velocity=1.0, frequency=1.5), Spring(stiffness=400.0), Mass(mass=5.0)
    damper, ground = Adjustable(base=10.0, share=share), Fixed()
    feeler, tip = Spring(stiffness=0.2, start_compression=0.5), Damper(damping=0.05)
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


def test_a_signal_of_a_removed_part_is_frozen_and_it_is_told_how_much_it_moved():
    full = compiled(sensing(share=5.0))
    r = run(full, 4.0, step=1e-3, every=2e-3)
    plain = plain_mora(r, 0.97)
    assert {"feeler", "tip"} <= rows_of(plain)
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.97, tolerance=0.1)
    (frozen,) = [removal for removal in reduction.removals if isinstance(removal, Freeze)]
    assert frozen.signal == parse_path("damper.reading")
    (note,) = [note for note in reduction.notes if "is frozen" in note]
    assert note.startswith("damper.reading is frozen at ")
    search = find_proper_model(full.model, scenario(4.0), {"mass.flange.flow": 0.02}, step=1e-3)
    for candidate in search.front:
        if candidate.score <= 1.0:
            assert error_without(r, candidate.removals, "mass.flange.flow") <= 0.02


# -- laws that decide nothing --------------------------------------------------------------------------------------


class DryFriction(Resistance):
    """Coulomb friction, smoothed: beyond its largest force no velocity answers to a force."""

    flange = Port(Translation)
    force: Parameter = parameter("N")
    width: Parameter = parameter("m/s", default=1e-3)

    def effort(self, flow: Expr) -> Expr:
        return self.force * tanh(flow / self.width)


def sledge(mass: float) -> Component:
    push, sledge, friction = SinePush(force=30.0, frequency=1.0), Mass(mass=mass), DryFriction(force=29.0)
    return system(connect(push.flange, sledge.flange, friction.flange), push=push, sledge=sledge, friction=friction)


def test_a_mass_on_a_flat_law_is_refused():
    full = compiled(sledge(mass=0.5))
    r = run(full, 2.0, step=1e-5, every=1e-3)
    plain = plain_mora(r, 0.5)
    assert rows_of(plain) == {"sledge"}
    assert error_without(r, plain, "sledge.flange.flow") == math.inf
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.5)
    decision = next(d for d in reduction.decisions if str(d.row.path) == "sledge")
    assert decision.verdict is Verdict.REFUSED
    assert decision.cause is Refusal.FLAT_LAW
    assert decision.reason.endswith("; the law of friction does not give it")


def test_a_mass_on_a_law_that_gives_its_velocity_goes():
    push, sledge, friction = SinePush(force=30.0, frequency=1.0), Mass(mass=0.5), Drag(damping=100.0)
    part = system(connect(push.flange, sledge.flange, friction.flange), push=push, sledge=sledge, friction=friction)
    r = run(full := compiled(part), 2.0, step=1e-3, every=2e-3)
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.5)
    assert rows_of(reduction.removals) == {"sledge"}
