"""A bob in x and y on a stiff spring: a pendulum without a constraint.

A third way to a pendulum keeps both inertias independent and lets the rod give a little. The spring sees the
velocity along itself, a projection of x and y with shares that change as the bob moves. All causality is integral,
at the price of a fast vibration along the rod: the step must follow it, although it carries next to no energy.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Fixed, Mass, MotionSensor, Projection, Spring, Weight


class PendulumOnASpring(pm.Component):
    """A bob that starts at rest, sideways of its hinge."""

    length: pm.Parameter = pm.parameter("m", default=0.5, low=0.0)

    bob_x = Mass(mass=2.0)
    bob_y = Mass(mass=2.0)
    weight = Weight(mass=2.0)
    x = MotionSensor(start=length)
    y = MotionSensor()
    along = Projection()
    rod = Spring(stiffness=2.0e4)
    hinge = Fixed()

    distance = pm.sqrt(x.position * x.position + y.position * y.position)

    connections = (
        pm.connect(bob_x.flange, x.flange, along.first),
        pm.connect(bob_y.flange, y.flange, along.second, weight.flange),
        pm.connect(along.along, rod.a),
        pm.connect(rod.b, hinge.flange),
        pm.connect(x.position / distance, along.first_share),
        pm.connect(y.position / distance, along.second_share),
    )


OUTPUTS = ("x.position", "y.position")


def scenario() -> pm.Scenario:
    """Let go from a quarter turn."""
    return pm.Scenario(name="let go", stop=5.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(PendulumOnASpring()))
    print(f"the rod stretches by at most {1e3 * answer['rod.port.displacement'].max():.2f} mm")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
