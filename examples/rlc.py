"""A resistor, an inductor and a capacitor in series, on a voltage that is switched on.

One current flows through all of them, so in the bond graph they hang on one 1-junction: Se, R, I and C, the
shortest graph that oscillates. The inductor keeps flux, the capacitor keeps charge; energy swings between the two
and the resistor takes some of it each time.
"""

import propermodel as pm
from propermodel.library.electrical import Capacitor, Ground, Inductor, Resistor, VoltageSource


class RLC(pm.Component):
    """A series resonant circuit: natural frequency 1 / sqrt(L C), damping ratio R / 2 sqrt(C / L)."""

    voltage = pm.Input("V")

    source = VoltageSource()
    resistor = Resistor(resistance=20.0)
    inductor = Inductor(inductance=10e-3)
    capacitor = Capacitor(capacitance=1e-6)
    ground = Ground()

    connections = (
        pm.connect(voltage, source.voltage),
        pm.connect(source.pin, resistor.a),
        pm.connect(resistor.b, inductor.a),
        pm.connect(inductor.b, capacitor.a),
        pm.connect(capacitor.b, ground.pin),
    )


OUTPUTS = ("capacitor.port.effort", "inductor.port.flow")


def scenario() -> pm.Scenario:
    """Ten volts from the start."""
    return pm.Scenario(name="switched on", stop=5e-3, inputs={"voltage": 10.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    compiled = pm.compile_model(model)
    return pm.simulate(compiled, scenario(), method=pm.Method.RK4, step=1e-6, record_every=1e-5)


if __name__ == "__main__":
    answer = run(pm.elaborate(RLC()))
    print(f"the capacitor overshoots to {answer['capacitor.port.effort'].max():.2f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
