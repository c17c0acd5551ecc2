"""A flywheel runs down in a bearing with dry, Stribeck and viscous friction.

A resistance may have any law that takes power: here the friction falls before it rises with speed. The jump of dry
friction at rest is smoothed over a stated width of speed, so the wheel comes to rest by creeping.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia, StribeckFriction


class RunDown(pm.Component):
    """A flywheel on its bearing."""

    flywheel = RotatingInertia(inertia=0.5, start_speed=40.0)
    bearing = StribeckFriction(coulomb=1.0, breakaway=1.6, stribeck_speed=2.0, damping=0.03, width=0.1)

    connections = (pm.connect(flywheel.shaft, bearing.shaft),)


OUTPUTS = ("flywheel.shaft.flow",)


def scenario() -> pm.Scenario:
    """Nobody drives."""
    return pm.Scenario(name="run down", stop=16.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-3, record_every=0.05)


if __name__ == "__main__":
    answer = run(pm.elaborate(RunDown()))
    stopped = answer.time[(answer["flywheel.shaft.flow"] < 0.1).argmax()]
    print(f"the flywheel stands after {stopped:.2f} s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
