"""A Wheatstone bridge: four resistors in a ring measure how much one of them is out of balance.

Its bond graph is a mesh of resistances without a state: what flows where follows from all of them at once, a causal
loop. The program finds the loop and solves its linear equations exactly, so a model may be purely algebraic.
"""

import propermodel as pm
from propermodel.library.electrical import Ground, Resistor, VariableResistor, VoltageSource


class WheatstoneBridge(pm.Component):
    """Three known resistors, a strain gauge whose resistance is given, and a galvanometer across the bridge."""

    voltage = pm.Input("V")
    gauge_resistance = pm.Input("Ohm")

    supply = VoltageSource()
    upper_left = Resistor(resistance=120.0)
    lower_left = Resistor(resistance=120.0)
    upper_right = Resistor(resistance=120.0)
    gauge = VariableResistor()
    galvanometer = Resistor(resistance=1000.0)
    ground = Ground()

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(gauge_resistance, gauge.resistance),
        pm.connect(supply.pin, upper_left.a, upper_right.a),
        pm.connect(upper_left.b, lower_left.a, galvanometer.a),
        pm.connect(upper_right.b, gauge.a, galvanometer.b),
        pm.connect(lower_left.b, gauge.b, ground.pin),
    )


OUTPUTS = ("galvanometer.port.flow",)


def scenario() -> pm.Scenario:
    """The gauge goes from 118 to 122 ohms; in the middle the bridge is balanced."""
    strain = pm.table_values([[0.0, 1.0]], [118.0, 122.0])
    return pm.Scenario(name="strain", stop=1.0, inputs={"voltage": 5.0, "gauge_resistance": strain})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.01, record_every=0.1)


if __name__ == "__main__":
    answer = run(pm.elaborate(WheatstoneBridge()))
    for time, current in zip(answer.time, answer["galvanometer.port.flow"], strict=True):
        print(f"{118.0 + 4.0 * time:6.1f} Ohm  {1e6 * current:8.2f} uA")
    print(pm.energy_balance(answer))
