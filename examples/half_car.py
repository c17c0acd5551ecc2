"""Half of a car drives over a bump: heave and pitch.

A rigid body has one inertia for each degree of freedom; a lever makes the velocity of a mount, heave plus arm times
pitch rate, with a transformer and a 0-junction. Each axle acts on both degrees of freedom, and with unequal arms
they couple: hitting the bump in front lifts and pitches.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.library.mechanics.translation import Lever, Mass, SpringDamper


class HalfCar(pm.Component):
    """A body on a front and a rear suspension; the road moves their lower ends."""

    front_road = pm.Port(pm.Translation)
    rear_road = pm.Port(pm.Translation)
    front_arm: pm.Parameter = pm.parameter("m", default=1.2)
    rear_arm: pm.Parameter = pm.parameter("m", default=-1.5)

    heave = Mass(mass=600.0)
    pitch = RotatingInertia(inertia=900.0)
    front_mount = Lever()
    rear_mount = Lever()
    front = SpringDamper(stiffness=2.0e4, damping=1.5e3)
    rear = SpringDamper(stiffness=2.5e4, damping=1.8e3)

    connections = (
        pm.connect(front_road, front.a),
        pm.connect(rear_road, rear.a),
        pm.connect(front.b, front_mount.point),
        pm.connect(rear.b, rear_mount.point),
        pm.connect(heave.flange, front_mount.base, rear_mount.base),
        pm.connect(pitch.shaft, front_mount.rotation, rear_mount.rotation),
        pm.connect(front_arm, front_mount.arm),
        pm.connect(rear_arm, rear_mount.arm),
        pm.prescribed_flow(front_road),
        pm.prescribed_flow(rear_road),
    )


OUTPUTS = ("heave.flange.flow", "pitch.shaft.flow")


def scenario() -> pm.Scenario:
    """A ramp of 4 cm; the rear axle meets it 0.135 s after the front one."""
    front = pm.table_values([[0.0, 0.1, 0.101, 0.2, 0.201, 9.0]], [0.0, 0.0, 0.4, 0.4, 0.0, 0.0])
    rear = pm.table_values([[0.0, 0.235, 0.236, 0.335, 0.336, 9.0]], [0.0, 0.0, 0.4, 0.4, 0.0, 0.0])
    return pm.Scenario(name="ramp", stop=3.0, inputs={"front_road.flow": front, "rear_road.flow": rear})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(HalfCar()))
    print(f"the body pitches at up to {abs(answer['pitch.shaft.flow']).max():.3f} rad/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
