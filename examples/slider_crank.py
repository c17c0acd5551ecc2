"""A crank drives a piston: the transformer of a mechanism.

With the crank angle as coordinate, a slider-crank is one displacement-modulated transformer, v = (dx / d angle) w,
between the inertia of the crank and the mass of the piston. It goes through zero at both dead centres, which no
causality minds as long as the piston follows the crank. The piston's mass is felt at the crank with the square of a
changing modulus, so the speed swings twice a turn.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia, RotationSensor, TorqueSource, ViscousFriction
from propermodel.library.mechanics.translation import Mass


class CrankDrive(pm.Transformer):
    """The piston's velocity over the crank's: the slope of x = r cos(angle) + sqrt(l^2 - r^2 sin(angle)^2)."""

    a = pm.Port(pm.Rotation)
    b = pm.Port(pm.Translation)
    angle = pm.Input("rad")
    crank: pm.Parameter = pm.parameter("m", low=0.0)
    rod: pm.Parameter = pm.parameter("m", low=0.0)

    def modulus(self) -> pm.Expr:
        across = self.crank * pm.sin(self.angle)
        along = self.crank * pm.cos(self.angle)
        return -across - across * along / pm.sqrt(self.rod * self.rod - across * across)


class SliderCrank(pm.Component):
    """A flywheel on the crank, a piston, a torque that drives and friction that brakes."""

    torque = pm.Input("N.m")

    motor = TorqueSource()
    flywheel = RotatingInertia(inertia=0.02, start_speed=20.0)
    bearing = ViscousFriction(damping=0.05)
    sensor = RotationSensor()
    drive = CrankDrive(crank=0.05, rod=0.15)
    piston = Mass(mass=2.0)

    connections = (
        pm.connect(torque, motor.torque),
        pm.connect(motor.shaft, flywheel.shaft, bearing.shaft, sensor.shaft, drive.a),
        pm.connect(drive.b, piston.flange),
        pm.connect(sensor.angle, drive.angle),
    )


OUTPUTS = ("flywheel.shaft.flow", "piston.flange.flow")


def scenario() -> pm.Scenario:
    """A constant torque of 2 N.m."""
    return pm.Scenario(name="driven", stop=1.0, inputs={"torque": 2.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(SliderCrank()))
    speed = answer["flywheel.shaft.flow"]
    print(f"the crank turns at {speed.min():.1f} to {speed.max():.1f} rad/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
