"""A motor drives a spindle over a belt that stretches.

Pulleys are transformers from rotation to the straight motion of the belt and back; the belt between them is a
compliance, so both inertias keep their own state. Their ratio of speeds is that of the radii only after the belt
has stopped swinging.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import BeltDrive, RotatingInertia, TorqueSource, ViscousFriction


class BeltDrivenSpindle(pm.Component):
    """A rotor, a belt from a small to a large pulley, and a spindle with friction."""

    torque = pm.Input("N.m")

    motor = TorqueSource()
    rotor = RotatingInertia(inertia=0.002)
    belt = BeltDrive(radius_a=0.03, radius_b=0.09, stiffness=5.0e4, damping=20.0)
    spindle = RotatingInertia(inertia=0.05)
    bearing = ViscousFriction(damping=0.05)

    connections = (
        pm.connect(torque, motor.torque),
        pm.connect(motor.shaft, rotor.shaft, belt.a),
        pm.connect(belt.b, spindle.shaft, bearing.shaft),
    )


OUTPUTS = ("rotor.shaft.flow", "spindle.shaft.flow")


def scenario() -> pm.Scenario:
    """One newton metre from the start."""
    return pm.Scenario(name="start", stop=2.0, inputs={"torque": 1.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(BeltDrivenSpindle()))
    print(f"the spindle reaches {answer.at_end('spindle.shaft.flow'):.2f} rad/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
