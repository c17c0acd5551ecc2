"""The valve at the end of a long pipe closes, and the water hammers.

Water that moves is an inertia, water that is compressed a compliance. A pipe is a chain of them, and a chain
carries waves: stopping the flow v at once raises the pressure by rho c v (Joukowsky 1898), which then runs to the
reservoir and back. Forty sections are enough to see the square wave, with ripples that more sections push to higher
frequencies.
"""

import propermodel as pm
from propermodel.library.hydraulics import LineSection, PressureSource, VolumeFlowSource


class ClosingValve(pm.Component):
    """A reservoir, a hundred metres of pipe, and a consumer that stops."""

    reservoir_pressure = pm.Input("Pa")
    demand = pm.Input("m3/s")

    reservoir = PressureSource()
    pipe = pm.repeat(
        40,
        LineSection(
            length=2.5,
            diameter=0.05,
            density=1000.0,
            bulk_modulus=2.2e9,
            viscosity=1e-3,
            start_flow=1e-3,
            start_pressure=1e6,
        ),
    )
    consumer = VolumeFlowSource()

    connections = (
        pm.connect(reservoir_pressure, reservoir.pressure),
        pm.connect(-demand, consumer.volume_flow),
        pm.connect(reservoir.port, pipe[0].a),
        *pm.chain(pipe, "b", "a"),
        pm.connect(pipe[39].b, consumer.port),
    )


OUTPUTS = ("pipe[39].oil.port.effort", "pipe[20].column.port.flow")


def scenario() -> pm.Scenario:
    """One litre a second, stopped within 50 ms."""
    demand = pm.table_values([[0.0, 0.01, 0.06, 1.0]], [1e-3, 1e-3, 0.0, 0.0])
    return pm.Scenario(name="closing", stop=0.6, inputs={"reservoir_pressure": 1e6, "demand": demand})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-4, record_every=1e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(ClosingValve()))
    pressure = answer["pipe[39].oil.port.effort"]
    print(f"the pressure rises from {pressure[0] / 1e5:.2f} to {pressure.max() / 1e5:.2f} bar")
    print(pm.energy_balance(answer))
