"""A diode and a capacitor make direct current.

The diode is a resistance with an exponential law that lets next to nothing back, no switch: current starts when the
mains rise above the capacitor, which carries the load in between. The law is given for the current only, so the
diode must receive a voltage; the capacitor gives it one.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.electrical import Capacitor, Diode, Ground, Resistor, VoltageSource


class SmoothedRectifier(pm.Component):
    """Mains of 20 V at the peak, a diode with the resistance of the winding, a capacitor and a load."""

    mains = Sine(amplitude=20.0, frequency=50.0)
    supply = VoltageSource()
    winding = Resistor(resistance=0.5)
    diode = Diode()
    capacitor = Capacitor(capacitance=1e-3)
    load = Resistor(resistance=100.0)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "V") * mains.result, supply.voltage),
        pm.connect(supply.pin, winding.a),
        pm.connect(winding.b, diode.a),
        pm.connect(diode.b, capacitor.a, load.a),
        pm.connect(capacitor.b, load.b, ground.pin),
    )


OUTPUTS = ("supply.pin.effort", "load.port.effort")


def scenario() -> pm.Scenario:
    """Five periods of the mains."""
    return pm.Scenario(name="mains", stop=0.1)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-5, record_every=5e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(SmoothedRectifier()))
    late = answer["load.port.effort"][answer.time > 0.08]
    print(f"the load sees {late.min():.2f} to {late.max():.2f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
