"""A pulse runs along an electrical line and ends where the line is matched.

Inductors and capacitors in turn: thirty 1-junctions with an I and thirty 0-junctions with a C. The pulse needs
sqrt(L C) per section; a resistor of sqrt(L / C) at the end takes it up with hardly an echo.
"""

import propermodel as pm
from propermodel.library.electrical import Capacitor, Ground, Inductor, Resistor, VoltageSource


class Section(pm.Component):
    """A millimetre of line: an inductor along it and a capacitor to ground."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)

    inductor = Inductor(inductance=25e-9)
    capacitor = Capacitor(capacitance=10e-12)
    ground = Ground()

    connections = (
        pm.connect(a, inductor.a),
        pm.connect(inductor.b, capacitor.a, b),
        pm.connect(capacitor.b, ground.pin),
    )


class TransmissionLine(pm.Component):
    """A source with its resistance, thirty sections, and a matched load."""

    voltage = pm.Input("V")

    source = VoltageSource()
    inner = Resistor(resistance=50.0)
    sections = pm.repeat(30, Section())
    load = Resistor(resistance=50.0)
    ground = Ground()

    connections = (
        pm.connect(voltage, source.voltage),
        pm.connect(source.pin, inner.a),
        pm.connect(inner.b, sections[0].a),
        *pm.chain(sections, "b", "a"),
        pm.connect(sections[29].b, load.a),
        pm.connect(load.b, ground.pin),
    )


OUTPUTS = ("sections[0].capacitor.port.effort", "load.port.effort")


def scenario() -> pm.Scenario:
    """A triangular pulse of 6 ns."""
    pulse = pm.table_values([[0.0, 3e-9, 6e-9, 1.0]], [0.0, 2.0, 0.0, 0.0])
    return pm.Scenario(name="pulse", stop=40e-9, inputs={"voltage": pulse})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-11, record_every=1e-10)


if __name__ == "__main__":
    answer = run(pm.elaborate(TransmissionLine()))
    arrived = answer.time[answer["load.port.effort"].argmax()]
    print(f"the pulse arrives {1e9 * (arrived - 3e-9):.1f} ns late and {answer['load.port.effort'].max():.2f} V high")
    print(pm.energy_balance(answer))
