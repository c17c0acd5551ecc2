"""Linear models of laws with kinks and vertical tangents, and of dependent storage, against closed forms."""

import math

import pytest

from propermodel import quantity
from propermodel.analysis.linearise import linearise
from propermodel.compiler import compile_model
from propermodel.diagnostics import SimulationError
from propermodel.expressions import Expr, sign, sqrt
from propermodel.modelling import Hydraulic, Parameter, Port, Resistance, Scenario, connect, elaborate, parameter
from tests.parts import Bearing, Flywheel, Gear, Tank, Torque
from tests.physics.systems import system


class Orifice(Resistance):
    port = Port(Hydraulic)
    loss: Parameter = parameter("Pa.s2/m6", default=4.0)

    def flow(self, effort: Expr) -> Expr:
        return sign(effort) * sqrt(abs(effort) / self.loss)


class TurbulentPipe(Resistance):
    port = Port(Hydraulic)
    loss: Parameter = parameter("m6/(Pa.s)", default=4.0)
    pressure: Parameter = parameter("Pa", default=1.0)

    def flow(self, effort: Expr) -> Expr:
        return effort * abs(effort) ** 0.5 * quantity(1.0, "m3/(Pa.s)") / self.pressure**0.5


@pytest.mark.parametrize(("displacement", "expected"), [(9.0, -0.5 / math.sqrt(9.0 * 4.0)), (-9.0, -0.5 / 6.0)])
def test_an_orifice_under_pressure_has_the_slope_of_the_root(displacement: float, expected: float):
    tank, orifice = Tank(capacity=1.0), Orifice()
    made = compile_model(elaborate(system(connect(tank.port, orifice.port), tank=tank, orifice=orifice)))
    model = linearise(made, Scenario(initial={"tank.displacement": displacement}))
    assert model.A[0, 0] == pytest.approx(expected, rel=1e-14)


def test_a_root_at_rest_has_no_slope_and_a_vanishing_factor_takes_it_away():
    tank, orifice = Tank(capacity=1.0), Orifice()
    made = compile_model(elaborate(system(connect(tank.port, orifice.port), tank=tank, orifice=orifice)))
    with pytest.raises(SimulationError, match=r"linear/not-finite.*tank\.displacement"):
        linearise(made, Scenario())
    pipe = TurbulentPipe()
    made = compile_model(elaborate(system(connect(tank.port, pipe.port), tank=tank, pipe=pipe)))
    assert linearise(made, Scenario()).A.tolist() == [[0.0]]
    model = linearise(made, Scenario(initial={"tank.displacement": 4.0}))
    assert model.A[0, 0] == pytest.approx(-1.5 * math.sqrt(4.0), rel=1e-14)


def test_inertias_on_one_gear_are_one_state_with_the_reflected_inertia():
    motor, gear, load, bearing = Torque(torque=1.0), Gear(ratio=0.1), Flywheel(inertia=3.0), Bearing(friction=0.5)
    rotor = Flywheel(inertia=0.02)
    made = compile_model(
        elaborate(
            system(
                connect(motor.shaft, rotor.shaft, gear.a), connect(gear.b, load.shaft, bearing.shaft),
                motor=motor, gear=gear, load=load, bearing=bearing, rotor=rotor,
            )
        )
    )  # fmt: skip
    model = linearise(made, Scenario(), outputs=["rotor.shaft.flow", "load.shaft.effort"])
    inertia = 0.02 + 3.0 * 0.1**2
    assert model.A.shape == (1, 1)
    assert model.A[0, 0] == pytest.approx(-0.5 * 0.1**2 / inertia, rel=1e-12)
    speed, torque = (
        model.transfer_function(output="rotor.shaft.flow"),
        model.transfer_function(None, "load.shaft.effort"),
    )
    assert abs(speed.gain) == pytest.approx(1.0 / inertia, rel=1e-12)
    assert abs(torque(1e9j)) == pytest.approx(3.0 * 0.1 / inertia, rel=1e-9)
