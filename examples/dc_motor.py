"""A direct-current motor starts under a load.

Voltage and current become torque and speed in a gyrator, because torque answers to current and voltage to speed,
both by one constant. What is an inductor on the electrical side acts on the shaft like a spring, what is an inertia
on the shaft looks to the supply like a capacitor: a gyrator exchanges effort and flow.
"""

import propermodel as pm
from propermodel.library.electrical import DCMotor, VoltageSource
from propermodel.library.mechanics.rotation import RotatingInertia, ViscousFriction


class DrivenFan(pm.Component):
    """A motor on a supply turns an inertia with friction."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    motor = DCMotor(resistance=0.5, inductance=2e-3, constant=0.1, inertia=2e-4, friction=1e-5)
    fan = RotatingInertia(inertia=8e-4)
    air = ViscousFriction(damping=2e-3)

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, motor.pin),
        pm.connect(motor.shaft, fan.shaft, air.shaft),
    )


OUTPUTS = ("fan.shaft.flow", "motor.pin.flow")


def scenario() -> pm.Scenario:
    """Twelve volts from the start."""
    return pm.Scenario(name="start", stop=0.5, inputs={"voltage": 12.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    compiled = pm.compile_model(model)
    return pm.simulate(compiled, scenario(), method=pm.Method.RK4, step=1e-4, record_every=1e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(DrivenFan()))
    print(f"the fan reaches {answer.at_end('fan.shaft.flow'):.1f} rad/s at {answer.at_end('motor.pin.flow'):.2f} A")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
