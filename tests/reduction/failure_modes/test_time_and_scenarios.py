"""Small elements that decide stability, slow drift, short manoeuvres, other scenarios and designs (modes 3, 5 to 8)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.diagnostics import parse_path
from propermodel.expressions import Expr, sin, time
from propermodel.library.mechanics.rotation import RotatingInertia, ViscousFriction
from propermodel.library.mechanics.translation import Damper, Mass, Spring
from propermodel.modelling import (
    Component,
    EffortSource,
    Input,
    Parameter,
    Port,
    Rotation,
    Translation,
    connect,
    elaborate,
    parameter,
)
from propermodel.reduction.plan import plan_reduction
from propermodel.reduction.search import find_proper_model
from propermodel.reduction.single import Refusal
from tests.physics.systems import compiled, eigenvalues, run, scenario, system
from tests.reduction.failure_modes.plain import error_without, plain_mora, rows_of
from tests.reduction.rigs import driveline, quarter_car

# -- 3: what decides stability may carry little energy -------------------------------------------------------------


class Brake(EffortSource):
    """A force against a measured velocity."""

    flange = Port(Translation)
    measured = Input("m/s")
    gain: Parameter = parameter("N.s/m")

    def effort(self) -> Expr:
        return self.gain * self.measured


def controlled(*, at_far_mass: bool) -> Component:
    """Two masses on a stiff link; a force on the first brakes the velocity of the first or of the other."""
    near, far = Mass(mass=1.0, start_velocity=1.0), Mass(mass=1.0, start_velocity=1.0)
    link, damper, brake = Spring(stiffness=4e6), Damper(damping=300.0), Brake(gain=10.0)
    damping = {} if at_far_mass else {"damper": damper}
    return system(
        connect(brake.flange, near.flange, link.a, *(part.a for part in damping.values())),
        connect(link.b, far.flange, *(part.b for part in damping.values())),
        connect((far if at_far_mass else near).flange.flow, brake.measured),
        near=near,
        far=far,
        link=link,
        brake=brake,
        **damping,
    )


def test_a_stiff_link_that_destabilises_is_refused_where_plain_mora_makes_it_rigid():
    full = compiled(controlled(at_far_mass=True))
    r = run(full, 0.4, step=5e-5, every=1e-3)
    plain = plain_mora(r)
    assert rows_of(plain) == {"link"}
    # On one rigid body the brake gives -gain / (2 m) = -5; in the full model the link's mode grows with gain / (4 m).
    assert np.max(eigenvalues(full).real) == pytest.approx(2.5, rel=0.02)
    assert np.max(eigenvalues(full.model.without(plain)).real) == pytest.approx(-5.0)
    reduction = plan_reduction(full, r, rank_activity(r))
    refused = {str(d.row.path): d for d in reduction.decisions if d.cause is Refusal.STABILITY}
    assert "link" in refused
    assert "a mode that grows with 2.5 1/s at 450 Hz is lost" in refused["link"].reason
    assert np.max(eigenvalues(full.model.without(reduction.removals)).real) == pytest.approx(2.5, rel=0.02)


def test_the_guard_is_silent_where_the_link_is_well_damped_and_stable():
    full = compiled(controlled(at_far_mass=False))
    r = run(full, 1.0, step=1e-4, every=1e-3)
    reduction = plan_reduction(full, r, rank_activity(r))
    assert {str(d.row.path) for d in reduction.removed} == {"link", "damper"}
    assert not reduction.notes


# -- 5: slow drift -------------------------------------------------------------------------------------------------


class SineTorque(EffortSource):
    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m")
    frequency: Parameter = parameter("Hz", default=1.0)

    def effort(self) -> Expr:
        return -self.torque * sin(2.0 * math.pi * self.frequency * time)


def flywheel(damping: float) -> Component:
    motor, wheel, bearing = SineTorque(torque=2000.0), RotatingInertia(inertia=1.0), ViscousFriction(damping=damping)
    return system(connect(motor.shaft, wheel.shaft, bearing.shaft), motor=motor, wheel=wheel, bearing=bearing)


SPINNING = {"wheel.shaft.flow": 100.0}
SPEED = "wheel.shaft.flow"


def test_a_bearing_that_stops_the_wheel_in_the_end_is_told():
    full = compiled(flywheel(1e-3))
    r = run(full, 20.0, step=1e-2, every=2e-2, initial=SPINNING)
    plain = plain_mora(r)
    assert rows_of(plain) == {"bearing"}
    assert error_without(r, plain, SPEED) < 0.02  # in this window nobody notices
    hours = run(full, 7200.0, step=5e-2, every=10.0, initial=SPINNING)
    assert np.mean(hours[SPEED][-20:]) < 0.5 * np.mean(r[SPEED])
    reduction = plan_reduction(full, r, rank_activity(r))
    (note,) = reduction.notes
    assert note.startswith("a slow change with a time constant of 1e+03 s is lost")


def test_a_bearing_that_acts_within_the_window_stays_without_a_word():
    full = compiled(flywheel(1.0))
    r = run(full, 20.0, step=1e-2, every=2e-2, initial=SPINNING)
    reduction = plan_reduction(full, r, rank_activity(r))
    assert "bearing" not in rows_of(reduction.removals)
    assert not any("slow" in note for note in reduction.notes)


# -- 7 and 8: other scenarios and designs --------------------------------------------------------------------------

FORCE = "tyre.a.effort"


def fast(frequency: float = 10.0, **parameters: float):
    return scenario(2.0, parameters={"road.frequency": frequency, **parameters})


@pytest.mark.parametrize(("other", "goes"), [(1.0, False), (12.0, True)])
def test_a_second_scenario_keeps_what_only_it_needs(other, goes):
    model = elaborate(quarter_car(velocity=0.3, frequency=10.0))
    r = run(model, 2.0, step=2e-4, every=1e-3)
    plain = plain_mora(r)
    assert "body" in rows_of(plain)
    elsewhere = run(model, 2.0, step=2e-4, every=1e-3, parameters={"road.frequency": other})
    assert (error_without(elsewhere, plain, FORCE) < 0.05) is goes
    search = find_proper_model(model, [fast(), fast(other)], {FORCE: 0.05}, step=2e-4)
    assert (parse_path("body") in search.best.rows) is goes
    assert error_without(elsewhere, search.best.removals, FORCE) < 0.06


@pytest.mark.parametrize(("damping", "goes"), [(2.0, False), (0.012, True)])
def test_a_design_that_moves_keeps_what_only_it_needs(damping, goes):
    model = elaborate(driveline())
    light = {"bearing.damping": 0.01}
    plain = plain_mora(run(model, 2.0, step=2e-4, every=1e-3, parameters=light))
    assert "bearing" in rows_of(plain)
    design = {"bearing.damping": damping}
    moved = run(model, 2.0, step=2e-4, every=1e-3, parameters=design)
    only_bearing = [removal for removal in plain if removal.bond == parse_path("bearing.shaft")]
    assert (error_without(moved, only_bearing, "load.shaft.flow") < 0.05) is goes
    scenarios = [scenario(2.0, parameters=light), scenario(2.0, parameters=design)]
    search = find_proper_model(model, scenarios, {"load.shaft.flow": 0.05}, step=2e-4)
    assert (parse_path("bearing") in search.best.rows) is goes
    assert error_without(moved, search.best.removals, "load.shaft.flow") < 0.06
