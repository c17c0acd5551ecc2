"""A motor lifts a load over a drum: three domains in one chain.

Gyrator (motor), transformer (gear), transformer (drum): electrical, rotating and straight-line power in a row.
Rotor and load move together, so the load's momentum depends on the rotor's; its weight is an effort source that a
bond graph keeps apart from its mass.
"""

import propermodel as pm
from propermodel.library.electrical import DCMotor, VoltageSource
from propermodel.library.mechanics.rotation import Gear, RollingWheel
from propermodel.library.mechanics.translation import Mass, Weight


class Hoist(pm.Component):
    """A motor, a reduction gear, a drum and a load on its rope."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    motor = DCMotor(resistance=0.4, inductance=2e-3, constant=0.2, inertia=5e-3, friction=1e-3)
    gear = Gear(ratio=20.0)
    drum = RollingWheel(radius=0.1)
    load = Mass(mass=100.0)
    weight = Weight(mass=100.0)

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, motor.pin),
        pm.connect(motor.shaft, gear.a),
        pm.connect(gear.b, drum.a),
        pm.connect(drum.b, load.flange, weight.flange),
    )


OUTPUTS = ("load.flange.flow", "motor.pin.flow")


def scenario() -> pm.Scenario:
    """The voltage rises to 48 V within half a second."""
    voltage = pm.table_values([[0.0, 0.5, 9.0]], [10.0, 48.0, 48.0])
    return pm.Scenario(name="lifting", stop=2.0, inputs={"voltage": voltage})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(Hoist()))
    speed, current = answer.at_end("load.flange.flow"), answer.at_end("motor.pin.flow")
    print(f"the load rises at {speed:.3f} m/s, the motor draws {current:.1f} A")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
