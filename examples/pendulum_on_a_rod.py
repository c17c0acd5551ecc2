"""A pendulum in x and y on a rigid rod: a constraint that no state can take away.

A point mass has two coordinates; the rod leaves it one. Its pull does not follow from any law: it is whatever keeps the
mass at its distance (a system of index 3). A `KinematicTransformer` gives the distance in x and y, and `Fixed` holds
it; the program finds the effort that closes the loop at every instant, and after every step it brings the states back
onto the constraint. Compare `pendulum` (in its angle) and `pendulum_on_a_spring` (the rod gives way).
"""

import propermodel as pm
from propermodel.library.mechanics.planar import Point, PointMass
from propermodel.library.mechanics.translation import Fixed


class Rod(pm.KinematicTransformer):
    """How much farther from the origin a point is than the rod is long."""

    point = Point()
    excess = pm.Port(pm.Translation)
    length: pm.Parameter = pm.parameter("m", low=0.0)

    def positions(self):
        x, y = self.point.x.displacement, self.point.y.displacement
        return {self.excess.displacement: pm.sqrt(x * x + y * y) - self.length}

    def starts(self):
        return {self.point.x.displacement: self.length}


class RodPendulum(pm.Component):
    """A mass held out level, and let go."""

    bob = PointMass(mass=2.0)
    rod = Rod(length=0.5)
    hinge = Fixed()

    connections = (
        pm.connect(bob.point, rod.point),
        pm.connect(rod.excess, hinge.flange),
    )


OUTPUTS = ("rod.displacement.point_x", "rod.displacement.point_y", "rod.excess.effort")


def scenario() -> pm.Scenario:
    """Let go from rest."""
    return pm.Scenario(name="let go", stop=10.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=5e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(RodPendulum()))
    pull = -answer["rod.excess.effort"].min() / (2.0 * 9.80665)
    print(f"the rod pulls with up to {pull:.4f} times the weight")
    print(f"the mass leaves its circle by less than {max(abs(answer['rod.displacement.excess'])) + 1e-12:.0e} m")
    print(pm.energy_balance(answer))
