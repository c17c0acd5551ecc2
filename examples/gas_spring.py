"""A mass bounces on a gas spring: the same spring is stiffer when it is fast.

Gas under a piston is a field that takes work at one port and heat at the other. When the heat has no time to pass
the wall the gas is adiabatic and stiffer by the ratio of heat capacities; in between, the heat that does pass damps
the motion. No exponent has to be chosen: wall and frequency decide.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Fixed, GasSpring, Mass
from propermodel.library.thermal import WallConductance


class GasSpringRig(pm.Component):
    """A mass carried by gas; the static load is in the gas, so everything counts from equilibrium."""

    mass = Mass(mass=300.0, start_velocity=0.05)
    gas = GasSpring(gas_volume=1e-3, piston_area=2e-3, static_pressure=1.5e6)
    wall = WallConductance(conductance=0.05)
    frame = Fixed()

    connections = (
        pm.connect(mass.flange, gas.a),
        pm.connect(gas.b, frame.flange),
        pm.connect(gas.wall, wall.port),
    )


OUTPUTS = ("gas.compression", "gas.temperature")


def scenario() -> pm.Scenario:
    """A push."""
    return pm.Scenario(name="push", stop=5.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(GasSpringRig()))
    print(f"the gas is compressed by up to {1e3 * answer['gas.compression'].max():.2f} mm")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
