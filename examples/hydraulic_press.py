"""A small piston moves a large one: Pascal's press.

A piston is a transformer between force and pressure, with its area as the modulus; two of them back to back
multiply the force by the ratio of the areas and divide the way by it. What oil is compressed is energy that a press
stores: the compliance between the transformers.
"""

import propermodel as pm
from propermodel.library.hydraulics import OilChamber, Piston, Plunger
from propermodel.library.mechanics.translation import Damper, Fixed, ForceSource, Mass, SpringDamper


class Press(pm.Component):
    """A hand pump whose seal drags, oil, a ram, and a workpiece that yields a little."""

    force = pm.Input("N")

    hand = ForceSource()
    seal = Damper(damping=5.0)
    pump = Piston(area=1e-4)
    oil = OilChamber(volume=1e-4)
    ram_piston = Plunger(area=1e-2)
    ram = Mass(mass=50.0)
    workpiece = SpringDamper(stiffness=5e6, damping=1e4)
    frame = Fixed()

    connections = (
        pm.connect(force, hand.force),
        pm.connect(hand.flange, pump.a, seal.a),
        pm.connect(pump.b, oil.port, ram_piston.a),
        pm.connect(ram_piston.b, ram.flange, workpiece.a),
        pm.connect(workpiece.b, seal.b, frame.flange),
    )


OUTPUTS = ("workpiece.spring.port.effort", "oil.port.effort")


def scenario() -> pm.Scenario:
    """A hundred newtons, put on within a tenth of a second."""
    force = pm.table_values([[0.0, 0.1, 1.0]], [0.0, 100.0, 100.0])
    return pm.Scenario(name="pressing", stop=0.3, inputs={"force": force})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-5, record_every=1e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(Press()))
    print(f"100 N by hand are {answer.at_end('workpiece.spring.port.effort'):.0f} N on the workpiece")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
