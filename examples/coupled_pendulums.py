"""Two pendulums joined by a soft spring hand their energy to each other and back.

Each pendulum is an inertia and a gravity compliance; the torsion spring between them sees the difference of their
speeds. Energy wanders at the difference of the two natural frequencies: swinging together and swinging against each
other.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import GravityPendulum, RotatingInertia, TorsionSpring


class CoupledPendulums(pm.Component):
    """Two equal pendulums, one of them held out and let go."""

    left = RotatingInertia(inertia=0.25)
    left_weight = GravityPendulum(mass=1.0, length=0.5, start_angle=0.05)
    coupling = TorsionSpring(stiffness=0.5)
    right = RotatingInertia(inertia=0.25)
    right_weight = GravityPendulum(mass=1.0, length=0.5)

    connections = (
        pm.connect(left.shaft, left_weight.shaft, coupling.a),
        pm.connect(right.shaft, right_weight.shaft, coupling.b),
    )


OUTPUTS = ("left_weight.shaft.displacement", "right_weight.shaft.displacement")


def scenario() -> pm.Scenario:
    """One of them is let go."""
    return pm.Scenario(name="beating", stop=25.0, initial={"coupling.displacement": 0.05})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-3, record_every=0.02)


if __name__ == "__main__":
    answer = run(pm.elaborate(CoupledPendulums()))
    print(f"the right pendulum swings to {answer['right_weight.shaft.displacement'].max():.4f} rad")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
