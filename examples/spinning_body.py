"""A body spins freely about its middle axis and tumbles (the tennis racket theorem).

Euler's equations are three inertias, one for each principal axis, in a ring of three gyrators, each modulated by
the angular momentum of the third axis (Karnopp, Margolis and Rosenberg, System Dynamics, ch. 9). Gyrators pass
power on and keep none, so energy and angular momentum stay, while the body turns over again and again.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia


class EulerGyrator(pm.Gyrator):
    """What rotation about a third axis does to two others: T_a = h w_b, T_b = h w_a."""

    a = pm.Port(pm.Rotation)
    b = pm.Port(pm.Rotation)
    momentum = pm.Input("N.m.s")

    def modulus(self) -> pm.Expr:
        return self.momentum


class SpinningBody(pm.Component):
    """A rigid body with three moments of inertia, spun about the middle one, slightly off."""

    first = RotatingInertia(inertia=1.0, start_speed=0.01)
    second = RotatingInertia(inertia=2.0, start_speed=5.0)
    third = RotatingInertia(inertia=3.0)
    around_third = EulerGyrator()
    around_first = EulerGyrator()
    around_second = EulerGyrator()

    connections = (
        pm.connect(first.shaft, around_third.a, around_second.b),
        pm.connect(second.shaft, around_first.a, around_third.b),
        pm.connect(third.shaft, around_second.a, around_first.b),
        pm.connect(third.shaft.momentum, around_third.momentum),
        pm.connect(first.shaft.momentum, around_first.momentum),
        pm.connect(second.shaft.momentum, around_second.momentum),
    )


OUTPUTS = ("first.shaft.flow", "second.shaft.flow", "third.shaft.flow")


def scenario() -> pm.Scenario:
    """No torque from outside."""
    return pm.Scenario(name="free", stop=20.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.02)


if __name__ == "__main__":
    answer = run(pm.elaborate(SpinningBody()))
    print(
        f"the spin about the middle axis goes from {answer['second.shaft.flow'].max():.2f} to "
        f"{answer['second.shaft.flow'].min():.2f} rad/s"
    )
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
