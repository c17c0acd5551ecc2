"""A quarter car on a wavy road: which of its elements matter?

Every element exchanges energy with its neighbours; the integral of the absolute power is its activity. Ranked, the
list says what the model is made of on this road: a tyre damper that carries a fiftieth of a percent can go, and a
program can say so (`propermodel reduce examples/quarter_car.py --output body.flange.flow`).
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.mechanics.translation import Mass, SpringDamper, VelocitySource


class QuarterCar(pm.Component):
    """Body on a suspension on a wheel on a tyre; the road moves the tyre."""

    waves = Sine(amplitude=1.0, frequency=1.0)
    road = VelocitySource()
    body = Mass(mass=1200.0)
    wheel = Mass(mass=80.0)
    suspension = SpringDamper(stiffness=2.0e4, damping=1.5e3)
    tyre = SpringDamper(stiffness=2.4e5, damping=1.5e2)

    connections = (
        pm.connect(pm.quantity(0.2, "m/s") * waves.result, road.velocity),
        pm.connect(road.flange, tyre.a),
        pm.connect(tyre.b, wheel.flange, suspension.a),
        pm.connect(suspension.b, body.flange),
    )


OUTPUTS = ("body.flange.flow", "wheel.flange.flow")


def scenario() -> pm.Scenario:
    """Ten seconds, one wave a second."""
    return pm.Scenario(name="waves", stop=10.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(QuarterCar()))
    late = answer.time > 8.0
    print(f"the body moves {answer['body.flange.flow'][late].max() / 0.2:.2f} times as fast as the road")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
