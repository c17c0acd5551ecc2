"""Two open tanks level out through a pipe, and one of them drains.

A tank is a compliance: the more volume, the more pressure at its bottom. An orifice is a resistance whose pressure
drop grows with the square of the flow. With a 0-junction for every tank and a 1-junction for every orifice the bond
graph repeats the drawing of the plant.
"""

import propermodel as pm
from propermodel.library.hydraulics import LaminarLine, LevelTank, OpenTank, Orifice


class TwoTanks(pm.Component):
    """A full tank fills an empty one through a thin pipe; the second drains through an orifice."""

    upper = LevelTank(area=0.10, start_level=1.0)
    pipe = LaminarLine(diameter=0.010, length=2.0, viscosity=1e-3)
    lower = LevelTank(area=0.05)
    outlet = Orifice(area=4e-5, density=1000.0)
    drain = OpenTank()

    connections = (
        pm.connect(upper.port, pipe.a),
        pm.connect(pipe.b, lower.port, outlet.a),
        pm.connect(outlet.b, drain.port),
    )


OUTPUTS = ("upper.port.effort", "lower.port.effort")


def scenario() -> pm.Scenario:
    """Ten minutes."""
    return pm.Scenario(name="draining", stop=600.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.1, record_every=1.0)


if __name__ == "__main__":
    answer = run(pm.elaborate(TwoTanks()))
    for name in ("upper", "lower"):
        level = answer[f"{name}.port.effort"] / (1000.0 * 9.80665)
        print(f"{name} tank: at most {level.max():.3f} m, at the end {level[-1]:.3f} m")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
