"""A torque turns two inertias that a rigid gear ties together.

Only one of them can be free: the speed of the other is that of the first over the ratio. In the bond graph the
second I element receives its flow and answers with an effort: derivative causality, dependent storage. The program
merges it into the first, J = J_1 + J_2 / ratio^2, and says so; nobody has to add a made-up compliance.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import Gear, RotatingInertia, TorqueSource


class GearedInertias(pm.Component):
    """A motor's rotor and a drum behind a reduction gear."""

    torque = pm.Input("N.m")

    source = TorqueSource()
    rotor = RotatingInertia(inertia=0.01)
    gear = Gear(ratio=5.0)
    drum = RotatingInertia(inertia=0.5)

    connections = (
        pm.connect(torque, source.torque),
        pm.connect(source.shaft, rotor.shaft, gear.a),
        pm.connect(gear.b, drum.shaft),
    )


OUTPUTS = ("rotor.shaft.flow", "drum.shaft.flow")


def scenario() -> pm.Scenario:
    """A constant torque."""
    return pm.Scenario(name="run up", stop=2.0, inputs={"torque": 3.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(GearedInertias()))
    print(answer.compiled)
    print(f"after 2 s the drum turns at {answer.at_end('drum.shaft.flow'):.3f} rad/s")
    print(pm.energy_balance(answer))
