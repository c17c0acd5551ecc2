"""The energy balance of full and reduced models."""

from __future__ import annotations

import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.diagnostics import parse_path
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, SpringDamper
from propermodel.modelling import (
    Component,
    ConstantEffort,
    ConstantFlow,
    Cut,
    Model,
    ZeroEffort,
    ZeroFlow,
    connect,
    elaborate,
)
from propermodel.modelling.model import Variable
from tests.physics.systems import Push, Shaking, run, system


def quarter_car() -> Component:
    road, wheel, body = Shaking(velocity=0.3, frequency=2.0), Mass(mass=80.0), Mass(mass=1200.0)
    tyre, suspension = SpringDamper(stiffness=2.4e5, damping=1.5e2), SpringDamper(stiffness=2.0e4, damping=1.5e3)
    return system(
        connect(road.flange, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange),
        road=road,
        tyre=tyre,
        wheel=wheel,
        suspension=suspension,
        body=body,
    )


def test_numbers_of_a_free_slide():
    mass, damper, wall = Mass(mass=2.0, start_velocity=3.0), Damper(damping=1.0), Fixed()
    model = system(connect(mass.flange, damper.a), connect(damper.b, wall.flange), mass=mass, damper=damper, wall=wall)
    balance = energy_balance(run(model, 40.0, step=0.01))
    assert balance.supplied == 0.0
    assert balance.stored == pytest.approx(-9.0, rel=1e-9)
    assert balance.dissipated == pytest.approx(9.0, rel=1e-9)
    assert balance.relative_residual < 1e-9


def test_a_source_that_brakes_takes_energy_back():
    push, mass = Push(force=-10.0), Mass(mass=2.0, start_velocity=3.0)
    balance = energy_balance(run(system(connect(push.flange, mass.flange), push=push, mass=mass), 1.0))
    # v = 3 - 5 t turns round at 0.6 s: 9 J are taken, 4 J are given back.
    assert balance.supplied == pytest.approx(-5.0, rel=1e-9)
    assert balance.throughput == pytest.approx(13.0, rel=1e-5)
    assert dict(balance.sources) == {parse_path("push"): pytest.approx(-5.0, rel=1e-9)}


def test_a_run_at_rest_balances():
    mass, spring, wall = Mass(mass=2.0), Spring(stiffness=5.0), Fixed()
    model = system(connect(mass.flange, spring.a), connect(spring.b, wall.flange), mass=mass, spring=spring, wall=wall)
    assert energy_balance(run(model, 1.0)).relative_residual == 0.0


REMOVALS = {
    "nothing": (),
    "no damper": (ZeroEffort(parse_path("tyre.damper.port")),),
    "massless wheel": (ZeroEffort(parse_path("wheel.flange")),),
    "clamped body": (ZeroFlow(parse_path("body.flange")),),
    "body at constant speed": (ConstantFlow(parse_path("body.flange"), 0.2),),
    "spring at constant force": (ConstantEffort(parse_path("suspension.spring.port"), 100.0),),
    "driven body": (Cut(parse_path("body.flange"), Variable.EFFORT),),
    "driven damper": (Cut(parse_path("tyre.damper.port"), Variable.FLOW),),
}


@pytest.mark.parametrize("removals", REMOVALS.values(), ids=REMOVALS)
def test_full_and_reduced_models_balance(removals):
    model: Model = elaborate(quarter_car()).without(removals)
    balance = energy_balance(run(model, 2.0, step=2e-4))
    assert balance.relative_residual < 1e-6
    assert abs(balance.wiring_residual) < 1e-9 * balance.throughput


def test_constants_in_place_of_elements_count_as_sources():
    removal = ConstantEffort(parse_path("suspension.spring.port"), 100.0)
    r = run(elaborate(quarter_car()).without([removal]), 2.0, step=2e-4)
    balance = energy_balance(r)
    work = dict(balance.sources)
    assert set(map(str, work)) == {"road", "suspension.spring.port_constant"}
    # The constant force works on the slip of the suspension: its work is minus force times the travel.
    assert work[parse_path("suspension.spring.port_constant")] == pytest.approx(
        -r.work(parse_path("suspension.spring.port")), rel=1e-12
    )


def test_the_balance_says_what_it_found():
    mass, damper, wall = Mass(mass=2.0, start_velocity=3.0), Damper(damping=1.0), Fixed()
    model = system(connect(mass.flange, damper.a), connect(damper.b, wall.flange), mass=mass, damper=damper, wall=wall)
    text = str(energy_balance(run(model, 40.0, step=0.01)))
    assert text.startswith("energy balance: sources 0 J = stored -9 J + dissipated 9 J; residual ")
