"""A quarter car by its modes: what a suspension is chosen for.

Small motions of a linear model are a sum of modes. A quarter car has two that swing: the body on its suspension, slow
and well damped, and the wheel between suspension and tyre, ten times as fast ("wheel hop"). `modes()` tells frequency
and damping, whose energy they are and where it is lost; the frequency response tells what the road does to the body.
The run shows both at once: a step of the road.
"""

import math

import numpy as np

import propermodel as pm
from propermodel.library.mechanics.translation import Mass, SpringDamper


class SuspendedCar(pm.Component):
    """Body on a suspension on a wheel on a tyre; the scenario moves the road."""

    road = pm.Port(pm.Translation)

    body = Mass(mass=300.0)
    wheel = Mass(mass=40.0)
    suspension = SpringDamper(stiffness=1.8e4, damping=1.2e3)
    tyre = SpringDamper(stiffness=1.8e5, damping=50.0)

    connections = (
        pm.connect(road, tyre.a),
        pm.connect(tyre.b, wheel.flange, suspension.a),
        pm.connect(suspension.b, body.flange),
        pm.prescribed_flow(road),
    )


OUTPUTS = ("body.flange.flow", "wheel.flange.flow")


def scenario() -> pm.Scenario:
    """The road rises by five centimetres within a twentieth of a second."""
    bump = pm.table_values([[0.5, 0.525, 0.55]], [0.0, 2.0, 0.0])
    return pm.Scenario(name="step", stop=3.0, inputs={"road.flow": bump})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-4, record_every=0.005)


def linear(answer: pm.Trajectory) -> pm.LinearModel:
    """Small motions, from the velocity of the road to those of wheel and body."""
    return pm.linearise(answer.compiled, answer.scenario, inputs=["road.flow"], outputs=OUTPUTS)


if __name__ == "__main__":
    answer = run(pm.elaborate(SuspendedCar()))
    model = linear(answer)
    print(model.modes())
    for mode in model.modes():
        shares = ", ".join(f"{path} {share:.0%}" for path, share in list(mode.energy.items())[:2])
        print(f"at {mode.frequency:.2f} Hz the energy is that of {shares}")
    hertz = np.array([0.5, 1.2, 3.0, 11.0, 30.0])
    passed = model.frequency_response(2.0 * math.pi * hertz).magnitude("road.flow", "body.flange.flow")
    print("road to body: " + ", ".join(f"{f:g} Hz {g:.3f}" for f, g in zip(hertz, passed, strict=True)))
    print(pm.energy_balance(answer))
