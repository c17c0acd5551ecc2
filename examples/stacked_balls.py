"""A small ball on a large one is dropped, and flies higher than it was: impacts between bodies.

`Impact` is a rigid stop between two flanges. When its gap has closed, an impulse separates them with a share of the
speed of approach, and whatever is joined to them takes its part of it. The large ball meets the small one while it
comes up and the small one still goes down, and hands it a good part of its own energy.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Fixed, Impact, Mass, MotionSensor, Weight


class StackedBalls(pm.Component):
    """Two balls one metre above the floor, a centimetre apart; heights are those of their lowest points."""

    large = Mass(mass=0.6)
    large_weight = Weight(mass=0.6)
    large_height = MotionSensor(start=1.0)
    small = Mass(mass=0.06)
    small_weight = Weight(mass=0.06)
    small_height = MotionSensor(start=1.01)
    on_floor = Impact(start_gap=1.0, restitution=0.9)
    between = Impact(start_gap=0.01, restitution=0.9)
    floor = Fixed()

    connections = (
        pm.connect(large.flange, large_weight.flange, large_height.flange, on_floor.b, between.a),
        pm.connect(small.flange, small_weight.flange, small_height.flange, between.b),
        pm.connect(floor.flange, on_floor.a),
    )


OUTPUTS = ("small_height.position", "large_height.position", "small.flange.flow", "large.flange.flow")


def scenario() -> pm.Scenario:
    """Let go."""
    return pm.Scenario(name="dropped", stop=1.8)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.01, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(StackedBalls()))
    for event in answer.events[:4]:
        print(f"at {event.time:.6f} s {event.element} loses {event.lost:.4f} J")
    print(f"the small ball flies up to {answer['small_height.position'].max():.3f} m")
    print(pm.energy_balance(answer))
