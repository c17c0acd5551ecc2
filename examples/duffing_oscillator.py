"""A mass on a spring that hardens swings faster the farther it goes (Duffing 1918).

A nonlinear compliance states its force and its energy; the program checks neither against the other, the energy
balance does. The frequency depends on the amplitude, here nearly twice that of small swings.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Fixed, HardeningSpring, Mass


class DuffingOscillator(pm.Component):
    """A mass between a wall and nothing, let go from a stretched spring."""

    mass = Mass(mass=1.0)
    spring = HardeningSpring(stiffness=100.0, cubic_stiffness=4.0e4, start_compression=0.1)
    wall = Fixed()

    connections = (
        pm.connect(mass.flange, spring.a),
        pm.connect(spring.b, wall.flange),
    )


OUTPUTS = ("spring.port.displacement", "mass.flange.flow")


def scenario() -> pm.Scenario:
    """Let go."""
    return pm.Scenario(name="let go", stop=2.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-4, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(DuffingOscillator()))
    print(f"the mass passes the middle at {answer['mass.flange.flow'].max():.3f} m/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
