"""A loudspeaker: current becomes force in a voice coil, and the cone radiates.

The voice coil is a gyrator: seen from the amplifier, the mass of the cone is a capacitor and its suspension an
inductor, which is why the impedance of a loudspeaker has a peak at its resonance (Small 1972). The radiated sound
is a resistance on the cone, and its share of the power is small.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.electrical import Ground, Inductor, Resistor, VoiceCoil, VoltageSource
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, SpringDamper


class Loudspeaker(pm.Component):
    """A driver on an amplifier; the damper `air` is the radiated sound."""

    tone = Sine(amplitude=1.0, frequency=100.0)
    amplifier = VoltageSource()
    winding = Resistor(resistance=6.0)
    coil = Inductor(inductance=0.5e-3)
    motor = VoiceCoil(constant=7.0)
    cone = Mass(mass=20e-3)
    suspension = SpringDamper(stiffness=2000.0, damping=1.0)
    air = Damper(damping=0.4)
    basket = Fixed()
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(10.0, "V") * tone.result, amplifier.voltage),
        pm.connect(amplifier.pin, winding.a),
        pm.connect(winding.b, coil.a),
        pm.connect(coil.b, motor.pin_a),
        pm.connect(motor.pin_b, ground.pin),
        pm.connect(motor.b, cone.flange, suspension.a, air.a),
        pm.connect(suspension.b, air.b, basket.flange),
    )


OUTPUTS = ("cone.flange.flow", "coil.port.flow")


def scenario() -> pm.Scenario:
    """A tone of 100 Hz."""
    return pm.Scenario(name="tone", stop=0.2)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-5, record_every=5e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(Loudspeaker()))
    late = answer.time > 0.15
    print(f"the cone moves at up to {answer['cone.flange.flow'][late].max():.3f} m/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
