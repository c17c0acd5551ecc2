"""A load behind a transformer looks like ratio squared times itself.

An ideal transformer keeps power and exchanges voltage for current; 230 V to 23 V with a load of one ohm is a
hundred ohms to the mains. Its two ports lie between pins, so primary and secondary may float against each other.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.electrical import Ground, IdealTransformer, Inductor, Resistor, VoltageSource


class TransformerLoad(pm.Component):
    """Mains, the leakage of the windings, an ideal transformer ten to one, and a load."""

    mains = Sine(amplitude=325.0, frequency=50.0)
    supply = VoltageSource()
    leakage = Inductor(inductance=0.1)
    transformer = IdealTransformer(ratio=10.0)
    load = Resistor(resistance=1.0)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "V") * mains.result, supply.voltage),
        pm.connect(supply.pin, leakage.a),
        pm.connect(leakage.b, transformer.primary_a),
        pm.connect(transformer.secondary_a, load.a),
        pm.connect(transformer.primary_b, transformer.secondary_b, load.b, ground.pin),
    )


OUTPUTS = ("supply.pin.effort", "load.port.effort")


def scenario() -> pm.Scenario:
    """Five periods."""
    return pm.Scenario(name="mains", stop=0.1)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-5, record_every=2e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(TransformerLoad()))
    print(f"the load has {answer['load.port.effort'][answer.time > 0.08].max():.2f} V at its peak")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
