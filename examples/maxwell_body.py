"""A spring and a damper in series forget a stretch: Maxwell's model of a viscous solid.

Between spring and damper nothing has mass. Both carry the same force: a 1-junction of flows would be wrong, a
0-junction of the common force with its two flows is right. After a sudden stretch the force fades with the time
constant c / k.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Damper, Fixed, Spring, VelocitySource


class MaxwellBody(pm.Component):
    """A body that is pressed at a given velocity."""

    velocity = pm.Input("m/s")

    press = VelocitySource()
    spring = Spring(stiffness=1.0e4)
    damper = Damper(damping=2.0e3)
    wall = Fixed()

    connections = (
        pm.connect(velocity, press.velocity),
        pm.connect(press.flange, spring.a),
        pm.connect(spring.b, damper.a),
        pm.connect(damper.b, wall.flange),
    )


OUTPUTS = ("spring.port.effort",)


def scenario() -> pm.Scenario:
    """Pressed by a centimetre within 0.1 s, then held."""
    velocity = pm.table_values([[0.0, 0.1, 0.1001, 9.0]], [0.1, 0.1, 0.0, 0.0])
    return pm.Scenario(name="press and hold", stop=1.0, inputs={"velocity": velocity})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(MaxwellBody()))
    force = answer["spring.port.effort"]
    print(f"the force rises to {force.max():.1f} N and fades to {force[-1]:.2f} N")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
