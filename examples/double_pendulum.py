"""A double pendulum of bodies, bars and hinges, joined by their frames.

A frame is a vector port: bonds in x, y and angle, wired as one, and the position beside them. Every joint from the
ground outwards has its own angle as a coordinate, so nothing is constrained twice: the turning inertias are states, the
masses in x and y depend on them, and the program adds them to the inertias with moduli that change with the angles.
What starts near the top swings wildly, yet keeps its energy.
"""

import propermodel as pm
from propermodel.library.mechanics.planar import Body, FixedFrame, FixedTranslation, Revolute


class DoublePendulum(pm.Component):
    """Two bars, each with a body at its end, that start upright, a little apart."""

    ceiling = FixedFrame()
    shoulder = Revolute(start_angle=1.6)
    upper_arm = FixedTranslation(x=0.8)
    upper = Body(mass=2.0, rotational_inertia=0.02)
    elbow = Revolute(start_angle=-0.1)
    forearm = FixedTranslation(x=0.6)
    lower = Body(mass=1.0, rotational_inertia=0.01)

    connections = (
        pm.connect(ceiling.frame, shoulder.a),
        pm.connect(shoulder.b, upper_arm.a),
        pm.connect(upper_arm.b, upper.frame, elbow.a),
        pm.connect(elbow.b, forearm.a),
        pm.connect(forearm.b, lower.frame),
    )


OUTPUTS = ("shoulder.angle", "elbow.angle", "ceiling.frame_y.effort")


def scenario() -> pm.Scenario:
    """Let go from rest."""
    return pm.Scenario(name="let go", stop=4.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(DoublePendulum()))
    most = abs(answer["ceiling.frame_y.effort"]).max() / (3.0 * 9.80665)
    print(f"the ceiling carries up to {most:.2f} times the weight")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
