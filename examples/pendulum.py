"""A pendulum in its angle swings far out.

In the angle a pendulum is two elements on one 1-junction: the inertia I of the body about its axis and a compliance
C that is its weight, with the torque m g l sin(angle). The law is not linear, so the period grows with the swing:
at 120 degrees it is 1.373 times that of a small one.
"""

import math

import propermodel as pm
from propermodel.library.mechanics.rotation import GravityPendulum, RotatingInertia


class Pendulum(pm.Component):
    """A point mass on a rod without mass, held out at an angle and let go."""

    mass: pm.Parameter = pm.parameter("kg", default=2.0, low=0.0)
    length: pm.Parameter = pm.parameter("m", default=0.5, low=0.0)

    body = RotatingInertia(inertia=mass * length * length)
    weight = GravityPendulum(mass=mass, length=length, start_angle=math.radians(120.0))

    connections = (pm.connect(body.shaft, weight.shaft),)


OUTPUTS = ("weight.shaft.displacement", "body.shaft.flow")


def scenario() -> pm.Scenario:
    """Let go from rest."""
    return pm.Scenario(name="let go", stop=6.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(Pendulum()))
    angle = answer["weight.shaft.displacement"]
    print(f"the angle goes from {math.degrees(angle.max()):.2f} to {math.degrees(angle.min()):.2f} degrees")
    print(pm.energy_balance(answer))
