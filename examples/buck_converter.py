"""A converter steps 24 V down to 6 V with a switch, a diode, a coil and a capacitor.

Switch and diode are ideal: no voltage while closed, no current while open. Which of them is closed changes the
equations: with the switch open and the diode closed the coil's current goes on in a circle; with both open it would
have no way, so it must be zero. Nobody writes these cases down. The diode closes because a coil that is cut off would
drive its voltage without bounds, and not a joule is lost at any instant of switching.
"""

import propermodel as pm
from propermodel.library.control import PulseWidth
from propermodel.library.electrical import (
    Capacitor,
    ConstantVoltage,
    Ground,
    IdealDiode,
    IdealSwitch,
    Inductor,
    Resistor,
)


class BuckConverter(pm.Component):
    """The switch is closed for a quarter of each period of 50 microseconds."""

    supply = ConstantVoltage(voltage=24.0)
    pulses = PulseWidth(frequency=20e3, duty=0.25)
    switch = IdealSwitch()
    diode = IdealDiode()
    coil = Inductor(inductance=200e-6, start_current=1.0)
    capacitor = Capacitor(capacitance=100e-6, start_voltage=5.0)
    load = Resistor(resistance=5.0)
    ground = Ground()

    connections = (
        pm.connect(pulses.result, switch.command),
        pm.connect(supply.p, switch.a),
        pm.connect(switch.b, diode.b, coil.a),
        pm.connect(coil.b, capacitor.a, load.a),
        pm.connect(supply.n, diode.a, capacitor.b, load.b, ground.pin),
    )


OUTPUTS = ("coil.port.flow", "load.port.effort")


def scenario() -> pm.Scenario:
    """Twenty periods from a load that takes less."""
    return pm.Scenario(name="start", stop=1e-3)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario; steps also end where something switches."""
    compiled = pm.compile_model(model)
    return pm.simulate(compiled, scenario(), method=pm.Method.RK4, step=1e-6, record_every=1e-6, integrals_every=1e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(BuckConverter()))
    late = answer.time > 0.95e-3
    current, voltage = answer["coil.port.flow"][late], answer["load.port.effort"][late]
    print(f"{len(answer.events)} events; in the last period the coil has {current.min():.3f} to {current.max():.3f} A,")
    print(f"the load {voltage.min():.3f} to {voltage.max():.3f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
