"""An electric heater warms water: the RS element.

A resistor does not lose energy: it turns it into heat. As a field with two ports, an electrical and a thermal one,
it takes the power R i^2 and gives the entropy flow R i^2 / T, so heat stays in the model and the balance can say
what the heat could still do. One watt at 360 K is worth 0.17 W of work against 300 K; the rest counts as lost at
once.
"""

import propermodel as pm
from propermodel.library.electrical import Ground, VoltageSource
from propermodel.library.thermal import HeatCapacity, HeatingResistor, WallConductance


class Heater(pm.Component):
    """A heating coil in a kettle that loses heat to ambient."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    coil = HeatingResistor(resistance=50.0)
    water = HeatCapacity(capacity=2000.0)
    wall = WallConductance(conductance=5.0)
    ground = Ground()

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, coil.a),
        pm.connect(coil.b, ground.pin),
        pm.connect(coil.heat, water.port, wall.port),
    )


OUTPUTS = ("water.port.effort",)


def scenario() -> pm.Scenario:
    """450 watts for ten minutes."""
    return pm.Scenario(name="heating", stop=600.0, inputs={"voltage": 150.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.1, record_every=5.0)


if __name__ == "__main__":
    answer = run(pm.elaborate(Heater()))
    print(f"the water is {answer.at_end('water.port.effort'):.2f} K above ambient")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
