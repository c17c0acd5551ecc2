"""A ball falls on a stiff, elastic floor and bounces for ever.

Contact as a law: a compliance that is zero until a gap has closed and a stiff spring then. No event is needed, but
the step must resolve the contact, which lasts half a period of ball and floor. Nothing is dissipated, so every
bounce must come back to the height of the first: a hard test of an integrator, and the energy balance shows how it
did.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import ElasticStop, Fixed, Mass, Weight


class BallOnElasticFloor(pm.Component):
    """A ball half a metre above the floor."""

    ball = Mass(mass=0.2)
    weight = Weight(mass=0.2)
    contact = ElasticStop(stiffness=2.0e5, gap=0.5)
    floor = Fixed()

    connections = (
        pm.connect(ball.flange, weight.flange, contact.b),
        pm.connect(contact.a, floor.flange),
    )


OUTPUTS = ("contact.port.displacement", "ball.flange.flow")


def scenario() -> pm.Scenario:
    """Let go."""
    return pm.Scenario(name="bouncing", stop=7.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-6, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(BallOnElasticFloor()))
    height = 0.5 - answer["contact.port.displacement"]
    late = answer.time > 6.4
    print(f"after ten bounces the ball still comes up to {height[late].max():.4f} m")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
