"""A ball bounces off a hard floor: an impact as an event.

Where `ball_on_elastic_floor` resolves the contact with a stiff spring and small steps, here it takes no time: when the
ball has come down to the floor, its momentum turns round and keeps a share of its size. `when` says so, the instant is
found to rounding whatever the step is, and what the impact takes stands in the energy balance. In the condition of an
impact stands that the ball approaches: it is true again only at the next bounce.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import MotionSensor, Weight


class Ball(pm.Inertia):
    """A mass that leaves the floor with a share of the speed with which it came."""

    flange = pm.Port(pm.Translation)
    height = pm.Input("m")
    mass: pm.Parameter = pm.parameter("kg", low=0.0)
    restitution: pm.Parameter = pm.parameter("1", low=0.0, high=1.0)

    def momentum(self, flow: pm.Expr) -> pm.Expr:
        return self.mass * flow

    def events(self):
        hits = (self.height < 0.0) & (self.flange.flow < 0.0)
        return (pm.when(hits, {self.flange.momentum: -self.restitution * self.flange.momentum}),)


class BouncingBall(pm.Component):
    """A ball one metre above the floor."""

    ball = Ball(mass=0.2, restitution=0.8)
    weight = Weight(mass=0.2)
    sensor = MotionSensor(start=1.0)

    connections = (
        pm.connect(ball.flange, weight.flange, sensor.flange),
        pm.connect(sensor.position, ball.height),
    )


OUTPUTS = ("sensor.position", "ball.flange.flow")


def scenario() -> pm.Scenario:
    """Let go."""
    return pm.Scenario(name="bouncing", stop=3.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.01, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(BouncingBall()))
    for event in answer.events:
        print(f"at {event.time:.9f} s the {event.element} loses {event.lost:.6f} J")
    print(pm.energy_balance(answer))
