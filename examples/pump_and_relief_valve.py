"""A pump of constant displacement, and the valve that saves it when nobody takes its oil.

A pump is a transformer between shaft and line. It gives its flow whatever the pressure, so something must take the
flow: a relief valve is a resistance that opens at a set pressure. The shaft then feels the set pressure as torque,
and the activity of the valve is the heat that the station makes for nothing.
"""

import propermodel as pm
from propermodel.library.hydraulics import FixedPump, MeteringOrifice, OilChamber, OpenTank, ReliefValve
from propermodel.library.mechanics.rotation import SpeedSource


class PumpStation(pm.Component):
    """A pump at constant speed, oil in the line, a relief valve, and a consumer that closes."""

    speed = pm.Input("rad/s")
    opening = pm.Input("1")

    motor = SpeedSource()
    pump = FixedPump(displacement=3e-6)
    line = OilChamber(volume=1e-3)
    relief = ReliefValve(set_pressure=15e6, conductance=5e-10)
    consumer = MeteringOrifice(area=5e-6)
    tank = OpenTank()

    connections = (
        pm.connect(speed, motor.speed),
        pm.connect(opening, consumer.opening),
        pm.connect(motor.shaft, pump.a),
        pm.connect(pump.b, line.port, relief.a, consumer.a),
        pm.connect(relief.b, consumer.b, tank.port),
    )


OUTPUTS = ("line.port.effort", "relief.port.flow")


def scenario() -> pm.Scenario:
    """The consumer closes from 0.2 s to 0.4 s."""
    opening = pm.table_values([[0.0, 0.2, 0.4, 9.0]], [1.0, 1.0, 0.0, 0.0])
    return pm.Scenario(name="closing", stop=0.6, inputs={"speed": 150.0, "opening": opening})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-5, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(PumpStation()))
    pressure = answer["line.port.effort"] / 1e5
    print(f"the pressure goes from {pressure[90]:.1f} to {pressure[-1]:.1f} bar")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
