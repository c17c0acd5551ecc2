"""A wall of three layers warms up from one side, with heat as a true bond.

The effort is temperature above ambient and the flow is entropy: conduction passes all its heat on and makes entropy
on the way, so the entropy that arrives is more than what left. What a layer takes as power is the work that the
heat can no longer do. Bond graphs with temperature and heat flow (pseudo bonds) cannot be ranked beside mechanical
ones; this can.
"""

import propermodel as pm
from propermodel.library.thermal import Conduction, HeatCapacity, TemperatureSource, WallConductance


class LayeredWall(pm.Component):
    """A heated room, plaster, brick and render, and the air outside at ambient temperature."""

    room = pm.Input("K")

    heating = TemperatureSource()
    inner_film = Conduction(conductance=8.0)
    plaster = HeatCapacity(capacity=2.0e4)
    plaster_to_brick = Conduction(conductance=6.0)
    brick = HeatCapacity(capacity=3.0e5)
    brick_to_render = Conduction(conductance=6.0)
    render = HeatCapacity(capacity=3.0e4)
    outer_film = WallConductance(conductance=20.0)

    connections = (
        pm.connect(room, heating.temperature),
        pm.connect(heating.port, inner_film.a),
        pm.connect(inner_film.b, plaster.port, plaster_to_brick.a),
        pm.connect(plaster_to_brick.b, brick.port, brick_to_render.a),
        pm.connect(brick_to_render.b, render.port, outer_film.port),
    )


OUTPUTS = ("plaster.port.effort", "brick.port.effort", "render.port.effort")


def scenario() -> pm.Scenario:
    """The room is kept 20 K above ambient for three days."""
    return pm.Scenario(name="heating", stop=259200.0, inputs={"room": 20.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=60.0, record_every=1800.0)


if __name__ == "__main__":
    answer = run(pm.elaborate(LayeredWall()))
    for layer in ("plaster", "brick", "render"):
        print(f"{layer}: {answer.at_end(f'{layer}.port.effort'):.2f} K above ambient")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
