"""A slider-crank as a closed chain: crank and rod turn freely until a guide closes the loop.

`slider_crank` writes the piston in the angle of the crank, which takes a root and its derivative by hand. A chain needs
neither: the end of the rod is r cos(crank) + l cos(rod) along the guide and r sin(crank) + l sin(rod) across it, and
holding the second at zero closes the loop. The start gives the crank; the angle of the rod is only a guess, from which
the program finds the one that closes the chain, and it says so in the notes of the run.
"""

import propermodel as pm
from propermodel.library.mechanics.planar import SliderCrankLinkage
from propermodel.library.mechanics.rotation import RotatingInertia, TorqueSource, ViscousFriction
from propermodel.library.mechanics.translation import Fixed, Mass


class SliderCrankChain(pm.Component):
    """A flywheel on the crank, a rod with an inertia of its own, a piston, a torque and friction."""

    torque = pm.Input("N.m")

    motor = TorqueSource()
    flywheel = RotatingInertia(inertia=0.02)
    rod = RotatingInertia(inertia=0.002)
    bearing = ViscousFriction(damping=0.05)
    chain = SliderCrankLinkage(radius=0.05, length=0.15, start_crank=0.3, start_rod=-0.05)
    guide = Fixed()
    piston = Mass(mass=2.0)

    connections = (
        pm.connect(torque, motor.torque),
        pm.connect(motor.shaft, flywheel.shaft, bearing.shaft, chain.crank),
        pm.connect(rod.shaft, chain.rod),
        pm.connect(chain.slider, piston.flange),
        pm.connect(chain.gap_y, guide.flange),
    )


OUTPUTS = ("flywheel.shaft.flow", "rod.shaft.flow", "piston.flange.flow")


def scenario() -> pm.Scenario:
    """A constant torque of 2 N.m on a crank that turns at 20 rad/s."""
    initial = {"chain.displacement.crank": 0.3, "flywheel.momentum": 0.4}
    return pm.Scenario(name="driven", stop=1.0, inputs={"torque": 2.0}, initial=initial)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-4, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(SliderCrankChain()))
    speed = answer["flywheel.shaft.flow"]
    print(f"the crank turns at {speed.min():.1f} to {speed.max():.1f} rad/s")
    for note in answer.notes:
        print(f"note: {note}")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
