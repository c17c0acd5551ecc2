"""Two coils share their flux: a field, one I element with two ports.

Neither coil has an energy of its own: the field does, in both flux linkages together, and the currents are its
gradient. That makes the coupling reciprocal whatever the numbers. Here the primary is switched to a voltage and the
secondary feeds a resistor, which gets a pulse and then nothing: a coil passes no constant current on.
"""

import propermodel as pm
from propermodel.library.electrical import CoupledInductors, Ground, Resistor, VoltageSource


class CoupledCoils(pm.Component):
    """A primary coil on a supply with its winding resistance, a secondary coil on a load."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    winding = Resistor(resistance=2.0)
    coils = CoupledInductors(primary_inductance=20e-3, secondary_inductance=5e-3, mutual_inductance=8e-3)
    load = Resistor(resistance=5.0)
    ground = Ground()

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, winding.a),
        pm.connect(winding.b, coils.primary_a),
        pm.connect(coils.secondary_a, load.a),
        pm.connect(coils.primary_b, coils.secondary_b, load.b, ground.pin),
    )


OUTPUTS = ("coils.primary.flow", "load.port.flow")


def scenario() -> pm.Scenario:
    """Ten volts from the start."""
    return pm.Scenario(name="switched on", stop=0.05, inputs={"voltage": 10.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-5, record_every=1e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(CoupledCoils()))
    print(f"the load gets a pulse of {answer['load.port.flow'].max():.2f} A")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
