"""Equilibria against closed forms."""

import numpy as np
import pytest

from propermodel.compiler import compile_model
from propermodel.diagnostics import SimulationError
from propermodel.modelling import Scenario, connect, elaborate
from propermodel.simulation.equilibrium import Stability, find_equilibrium
from propermodel.simulation.simulate import simulate
from tests.cli.quarter_car import QuarterCar
from tests.parts import Damper, Fixed, Force, Mass, Spring
from tests.physics.systems import system


def test_a_mass_on_a_spring_sags_by_its_weight_over_the_stiffness():
    mass, spring, push, wall = Mass(mass=2.0), Spring(stiffness=50.0), Force(force=-10.0), Fixed()
    damper = Damper(damping=1.0)
    made = compile_model(
        elaborate(
            system(
                connect(mass.flange, spring.a, damper.a, push.flange), connect(wall.flange, spring.b, damper.b),
                mass=mass, spring=spring, push=push, wall=wall, damper=damper,
            )
        )
    )  # fmt: skip
    found = find_equilibrium(made, Scenario())
    assert found.stability is Stability.STABLE
    assert abs(found["spring.displacement"]) == pytest.approx(10.0 / 50.0, rel=1e-12)
    assert found["mass.momentum"] == pytest.approx(0.0, abs=1e-12)
    run = simulate(made, Scenario(stop=1.0), start="equilibrium")
    assert np.ptp(run["spring.displacement"]) < 1e-9
    assert "started at a stable equilibrium; changed spring.displacement 0 -> " in run.notes[0]


def test_a_car_carried_along_moves_as_its_road():
    found = find_equilibrium(compile_model(elaborate(QuarterCar())), Scenario(inputs={"road.flow": 1.0}))
    assert found["body.momentum"] == pytest.approx(1200.0)
    assert found["wheel.momentum"] == pytest.approx(80.0)


def test_a_force_that_nothing_answers_has_no_equilibrium():
    mass, push = Mass(mass=2.0), Force(force=-10.0)
    made = compile_model(elaborate(system(connect(mass.flange, push.flange), mass=mass, push=push)))
    with pytest.raises(SimulationError, match=r"mass\.momentum cannot be brought to rest"):
        find_equilibrium(made, Scenario())
