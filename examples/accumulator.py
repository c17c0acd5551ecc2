"""An accumulator smooths the flow of a pump that beats.

Gas under oil is a compliance: it takes in what comes too fast and gives it back, so an orifice behind it sees a
nearly constant pressure. The time constant is that of R and C, as in a rectifier with its capacitor; the analogy is
the same bond graph.
"""

import propermodel as pm
from propermodel.library.control import Sine
from propermodel.library.hydraulics import GasAccumulator, OpenTank, Orifice, VolumeFlowSource


class PulsatingPump(pm.Component):
    """A pump whose flow goes up and down ten times a second, an accumulator, and a load that throttles."""

    beat = Sine(amplitude=1.0, offset=1.0, frequency=10.0)
    pump = VolumeFlowSource()
    accumulator = GasAccumulator(gas_volume=1e-3, precharge=5e6, exponent=1.4, start_oil=1e-4)
    load = Orifice(area=3e-6)
    tank = OpenTank()

    connections = (
        pm.connect(pm.quantity(3e-4, "m3/s") * beat.result, pump.volume_flow),
        pm.connect(pump.port, accumulator.port, load.a),
        pm.connect(load.b, tank.port),
    )


OUTPUTS = ("pump.port.flow", "load.port.flow")


def scenario() -> pm.Scenario:
    """The gas is compressed until as much flows out as in."""
    return pm.Scenario(name="filling", stop=4.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.005)


if __name__ == "__main__":
    answer = run(pm.elaborate(PulsatingPump()))
    late = answer.time > 3.0
    for name in ("pump", "load"):
        flow = abs(answer[f"{name}.port.flow"][late])
        print(f"{name}: {1e3 * flow.min():.3f} to {1e3 * flow.max():.3f} L/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
