"""A pendulum whose bob moves in x and y, tied to the angle by transformers that the angle changes.

The bob is two inertias, one for each direction, its weight an effort source on the vertical one. Each is joined to
the shaft by a displacement-modulated transformer, v = (dx / d angle) w, the bond graph of kinematics. Both momenta
of the bob depend on that of the rod: the program adds their inertia to it, with the terms that the changing moduli
bring.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia, RotationSensor
from propermodel.library.mechanics.translation import Mass, Weight


class Slope(pm.Transformer):
    """Rotation into straight motion: v = slope * w, the slope of a coordinate over the angle."""

    a = pm.Port(pm.Rotation)
    b = pm.Port(pm.Translation)
    slope = pm.Input("m")

    def modulus(self) -> pm.Expr:
        return self.slope


class PendulumByTransformers(pm.Component):
    """A thin rod with a bob at its end; x = l sin(angle), y = -l cos(angle), started with a push."""

    length: pm.Parameter = pm.parameter("m", default=0.5, low=0.0)
    bob_mass: pm.Parameter = pm.parameter("kg", default=2.0, low=0.0)

    rod = RotatingInertia(inertia=0.02, start_speed=6.0)
    sensor = RotationSensor()
    along_x = Slope()
    along_y = Slope()
    bob_x = Mass(mass=bob_mass, start_velocity=3.0)
    bob_y = Mass(mass=bob_mass)
    weight = Weight(mass=bob_mass)

    connections = (
        pm.connect(rod.shaft, sensor.shaft, along_x.a, along_y.a),
        pm.connect(along_x.b, bob_x.flange),
        pm.connect(along_y.b, bob_y.flange, weight.flange),
        pm.connect(length * pm.cos(sensor.angle), along_x.slope),
        pm.connect(length * pm.sin(sensor.angle), along_y.slope),
    )


OUTPUTS = ("sensor.angle", "bob_x.flange.flow", "bob_y.flange.flow")


def scenario() -> pm.Scenario:
    """Nothing but the push at the start."""
    return pm.Scenario(name="push", stop=5.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(PendulumByTransformers()))
    print(f"the pendulum swings out to {answer['sensor.angle'].max():.4f} rad")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
