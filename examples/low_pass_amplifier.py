"""An operational amplifier makes an active low pass filter.

An amplifier takes no power from what it feels: its inputs are activated bonds, signals, and its output a source.
Feedback through resistor and capacitor makes the gain -R_2 / R_1 below the corner 1 / (R_2 C) whatever the
amplifier's own gain, as long as that is large. Bond graph and circuit both show where the power comes from: the
amplifier's supply.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.electrical import Capacitor, Ground, OperationalAmplifier, Resistor, VoltageSource


class ActiveLowPass(pm.Component):
    """An inverting amplifier with a capacitor beside its feedback resistor."""

    tone = Sine(amplitude=0.1, frequency=1000.0)
    source = VoltageSource()
    input_resistor = Resistor(resistance=1e3)
    feedback = Resistor(resistance=10e3)
    capacitor = Capacitor(capacitance=15.9155e-9)
    amplifier = OperationalAmplifier(gain=1e5, transit_frequency=1e6)
    load = Resistor(resistance=1e4)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "V") * tone.result, source.voltage),
        pm.connect(source.pin, input_resistor.a),
        pm.connect(input_resistor.b, feedback.a, capacitor.a, amplifier.minus),
        pm.connect(feedback.b, capacitor.b, amplifier.output, load.a),
        pm.connect(amplifier.plus, load.b, ground.pin),
    )


OUTPUTS = ("source.pin.effort", "load.port.effort")


def scenario() -> pm.Scenario:
    """A tone at the corner frequency."""
    return pm.Scenario(name="tone", stop=5e-3)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-7, record_every=1e-5)


if __name__ == "__main__":
    answer = run(pm.elaborate(ActiveLowPass()))
    print(f"0.1 V become {answer['load.port.effort'][answer.time > 4e-3].max():.3f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
