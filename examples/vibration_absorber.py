"""A small mass on a spring takes the vibration of a large one upon itself (den Hartog).

Tuned to the frequency of the excitation, the absorber moves so that its spring cancels the force: at that frequency
the 0-junction of the force sees a 1-junction of zero flow. The machine stands nearly still while the absorber
swings.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.mechanics.translation import Fixed, ForceSource, Mass, SpringDamper


class VibrationAbsorber(pm.Component):
    """A machine on its foundation, shaken at 5 Hz, with an absorber tuned to 5 Hz."""

    shaking = Sine(amplitude=1.0, frequency=5.0)
    force = ForceSource()
    machine = Mass(mass=100.0)
    foundation = SpringDamper(stiffness=1.0e5, damping=400.0)
    absorber_spring = SpringDamper(stiffness=9869.6044, damping=2.0)
    absorber = Mass(mass=10.0)
    ground = Fixed()

    connections = (
        pm.connect(pm.quantity(100.0, "N") * shaking.result, force.force),
        pm.connect(force.flange, machine.flange, foundation.a, absorber_spring.a),
        pm.connect(absorber_spring.b, absorber.flange),
        pm.connect(foundation.b, ground.flange),
    )


OUTPUTS = ("machine.flange.flow", "absorber.flange.flow")


def scenario() -> pm.Scenario:
    """Long enough for the start to fade."""
    return pm.Scenario(name="shaking", stop=30.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(VibrationAbsorber()))
    late = answer.time > 28.0
    for name in ("machine", "absorber"):
        print(f"the {name} moves at up to {1e3 * answer[f'{name}.flange.flow'][late].max():.2f} mm/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
