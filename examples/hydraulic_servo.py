"""A servo valve and a cylinder bring a mass to where a signal says.

The valve opens in proportion to the error of position: no flow, no motion, so the loop is an integrator and settles
without a steady error. Pressure drives the rod through transformers, the valve's four edges are resistances that a
signal modulates, and oil under a loaded piston is the spring that limits how fast the loop may be.
"""

import propermodel as pm
from propermodel.library.hydraulics import Cylinder, OpenTank, PressureSource, ServoValve
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, MotionSensor


class PositionServo(pm.Component):
    """Supply, valve, cylinder, and a mass with friction; the valve follows the error of position."""

    supply_pressure = pm.Input("Pa")
    wanted = pm.Input("m")

    supply = PressureSource()
    tank = OpenTank()
    valve = ServoValve(area=1e-5)
    cylinder = Cylinder(head_area=1e-3, rod_side_area=7e-4, head_volume=2e-4, rod_side_volume=2e-4)
    load = Mass(mass=200.0)
    friction = Damper(damping=3000.0)
    frame = Fixed()
    sensor = MotionSensor()

    connections = (
        pm.connect(supply_pressure, supply.pressure),
        pm.connect(supply.port, valve.supply),
        pm.connect(tank.port, valve.tank),
        pm.connect(valve.a, cylinder.head),
        pm.connect(valve.b, cylinder.rod_side),
        pm.connect(cylinder.rod, load.flange, friction.a, sensor.flange),
        pm.connect(friction.b, frame.flange),
        pm.connect((wanted - sensor.position) / pm.quantity(0.1, "m"), valve.opening),
    )


OUTPUTS = ("sensor.position", "cylinder.head_oil.port.effort")


def scenario() -> pm.Scenario:
    """Ten centimetres, reached over a ramp of half a second."""
    wanted = pm.table_values([[0.0, 0.1, 0.6, 9.0]], [0.0, 0.0, 0.1, 0.1])
    return pm.Scenario(name="ramp", stop=2.0, inputs={"supply_pressure": 1e7, "wanted": wanted})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-5, record_every=5e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(PositionServo()))
    print(f"the mass arrives at {1e3 * answer.at_end('sensor.position'):.3f} mm")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
