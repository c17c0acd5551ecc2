"""A coil drives its current through a diode: a law solved for the other variable.

When a relay is switched off, its coil forces the current on, and a diode beside it gives the current a way. The coil
decides the current, but a diode's law gives the current that a voltage drives (Shockley), not the other way round.
Nobody has to invert it: the stroke asks for the voltage, so the law is solved for it at every instant. The diode takes
a nearly constant voltage, so the current ends sooner than in a resistor.
"""

import propermodel as pm
from propermodel.library.electrical import Diode, Ground, Inductor, Resistor


class FreewheelingDiode(pm.Component):
    """The coil of a relay, its wire, and a diode with a resistor of a kilohm beside it in one loop."""

    coil = Inductor(inductance=0.1, start_current=0.5)
    wire = Resistor(resistance=4.0)
    diode = Diode(saturation_current=1e-9, leakage=1e-3)
    ground = Ground()

    connections = (
        pm.connect(coil.b, wire.a),
        pm.connect(wire.b, diode.a),
        pm.connect(diode.b, coil.a, ground.pin),
    )


OUTPUTS = ("coil.port.flow", "diode.port.effort")


def scenario() -> pm.Scenario:
    """The relay has just been switched off."""
    return pm.Scenario(name="switched off", stop=0.06)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-5, record_every=2e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(FreewheelingDiode()))
    print(pm.explain_causality(answer.compiled))
    print(f"the current falls from 0.5 A to {1e3 * answer.at_end('coil.port.flow'):.3f} mA")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
