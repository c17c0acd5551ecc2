"""An oscillator that feeds itself: a resistance that is negative near zero (van der Pol 1926).

An active R element gives power where its law runs through the second quadrant and takes it where it does not. Coil
and capacitor swing; small swings grow, large ones shrink, and one limit cycle is left from whatever start.
"""

import propermodel as pm
from propermodel.library.electrical import Capacitor, Ground, Inductor


class ActiveResistance(pm.Resistance):
    """A current that grows backwards near zero voltage: i = g v (v^2 / v_0^2 - 1)."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)
    port = pm.Port(pm.Electrical, between=(a, b))
    conductance: pm.Parameter = pm.parameter("A/V", low=0.0)
    scale: pm.Parameter = pm.parameter("V", default=1.0, low=0.0)

    def flow(self, effort: pm.Expr) -> pm.Expr:
        share = effort / self.scale
        return self.conductance * effort * (share * share - 1.0)


class VanDerPol(pm.Component):
    """Coil, capacitor and active resistance between one node and ground."""

    capacitor = Capacitor(capacitance=1.0, start_voltage=0.1)
    coil = Inductor(inductance=1.0)
    triode = ActiveResistance(conductance=1.5)
    ground = Ground()

    connections = (
        pm.connect(capacitor.a, coil.a, triode.a),
        pm.connect(capacitor.b, coil.b, triode.b, ground.pin),
    )


OUTPUTS = ("capacitor.port.effort", "coil.port.flow")


def scenario() -> pm.Scenario:
    """A small start."""
    return pm.Scenario(name="growing", stop=40.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=2e-3, record_every=0.05)


if __name__ == "__main__":
    answer = run(pm.elaborate(VanDerPol()))
    print(f"the voltage swings to {answer['capacitor.port.effort'].max():.3f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
