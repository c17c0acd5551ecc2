"""A direct-current motor as a transfer function: from the voltage to the speed.

Control begins with s: armature and rotor are two storages, so the motor has two poles, and the ratio of its numerator
and denominator at s = 0 is the speed that a volt makes at last. The poles need not be read off a sheet: they follow
from the same graph that is simulated, and the step of the linear model is the step of the run, since the motor is
linear.
"""

import propermodel as pm
from propermodel.library.electrical import DCMotor, VoltageSource
from propermodel.library.mechanics.rotation import RotatingInertia, ViscousFriction


class DrivenMotor(pm.Component):
    """A motor with a load, and a voltage that can be given."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    motor = DCMotor(resistance=0.5, inductance=5e-3, constant=0.1, inertia=2e-4)
    load = RotatingInertia(inertia=8e-4)
    bearing = ViscousFriction(damping=2e-3)

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, motor.pin),
        pm.connect(motor.shaft, load.shaft, bearing.shaft),
    )


OUTPUTS = ("load.shaft.flow", "motor.pin.flow")


def scenario() -> pm.Scenario:
    """One volt from the start: the unit step."""
    return pm.Scenario(name="step", stop=0.25, inputs={"voltage": 1.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-5, record_every=5e-4)


def linear(answer: pm.Trajectory) -> pm.LinearModel:
    """The motor from its voltage to its speed and its current."""
    return pm.linearise(answer.compiled, answer.scenario, inputs=["voltage"], outputs=OUTPUTS)


if __name__ == "__main__":
    answer = run(pm.elaborate(DrivenMotor()))
    model = linear(answer)
    print(model.transfer_function("voltage", "load.shaft.flow"))
    print(model.transfer_function("voltage", "motor.pin.flow"))
    print(model.modes())
    step = model.step_response("voltage", duration=0.25, points=501)
    difference = abs(step["load.shaft.flow"] - answer["load.shaft.flow"]).max()
    print(f"step of the linear model and run differ by at most {difference:.0e} rad/s")
    print(pm.energy_balance(answer))
