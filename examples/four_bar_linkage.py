"""A four-bar linkage: a crank that goes round rocks a lever.

Three bars that turn about an end each would have three coordinates; the two gaps of the loop, along and across, leave
one. The shortest bar goes all the way round, because shortest and longest together are no longer than the other two
(Grashof). Only the crank's angle and speed are given at the start; the other bars follow from closing the loop.
"""

import math

import propermodel as pm
from propermodel.library.mechanics.planar import FixedPoint, FourBarLinkage
from propermodel.library.mechanics.rotation import RotatingInertia


class FourBar(pm.Component):
    """Crank, coupler and rocker with inertias; nothing drives and nothing brakes."""

    crank = RotatingInertia(inertia=0.1)
    coupler = RotatingInertia(inertia=0.02)
    rocker = RotatingInertia(inertia=0.05)
    loop = FourBarLinkage(crank_length=0.2, coupler_length=0.5, rocker_length=0.4, base=0.5)
    base = FixedPoint()

    connections = (
        pm.connect(crank.shaft, loop.crank),
        pm.connect(coupler.shaft, loop.coupler),
        pm.connect(rocker.shaft, loop.rocker),
        pm.connect(base.point, loop.gap),
    )


OUTPUTS = ("loop.displacement.rocker", "crank.shaft.flow", "rocker.shaft.flow")


def scenario() -> pm.Scenario:
    """The crank turns at 5 rad/s."""
    return pm.Scenario(name="turning", stop=5.0, initial={"loop.displacement.crank": 1.0, "crank.momentum": 0.5})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-4, record_every=5e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(FourBar()))
    rocker = answer["loop.displacement.rocker"]
    print(f"the rocker swings between {math.degrees(rocker.min()):.2f} and {math.degrees(rocker.max()):.2f} degrees")
    for note in answer.notes:
        print(f"note: {note}")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
