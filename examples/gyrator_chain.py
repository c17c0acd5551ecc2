"""Capacitors joined by gyrators behave like a chain of capacitors and inductors.

Seen through a gyrator, a C is an I: three gyrators make the second and fourth of these four storages the duals of
the others, so a ladder that needs no coil carries waves (Tellegen 1948; filters without coils are built so). All
four storages are independent: each gets integral causality, and the strokes alternate along the chain.
"""

import propermodel as pm
from propermodel.library.electrical import Capacitor, Ground


class IdealGyrator(pm.Gyrator):
    """A two-port between two nodes and ground: v_a = r i_b, v_b = r i_a."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)
    resistance: pm.Parameter = pm.parameter("Ohm", low=0.0)

    def modulus(self) -> pm.Expr:
        return self.resistance


class GyratorChain(pm.Component):
    """Four capacitors to ground, three gyrators between them; the first capacitor is charged."""

    first = Capacitor(capacitance=1e-6, start_voltage=1.0)
    second = Capacitor(capacitance=1e-6)
    third = Capacitor(capacitance=1e-6)
    fourth = Capacitor(capacitance=1e-6)
    links = pm.repeat(3, IdealGyrator(resistance=1000.0))
    ground = Ground()

    connections = (
        pm.connect(first.a, links[0].a),
        pm.connect(links[0].b, second.a, links[1].a),
        pm.connect(links[1].b, third.a, links[2].a),
        pm.connect(links[2].b, fourth.a),
        pm.connect(first.b, second.b, third.b, fourth.b, ground.pin),
    )


OUTPUTS = ("first.port.effort", "second.port.effort", "third.port.effort", "fourth.port.effort")


def scenario() -> pm.Scenario:
    """Nothing from outside."""
    return pm.Scenario(name="let go", stop=0.02)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-5, record_every=1e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(GyratorChain()))
    print(f"the voltage at the far end reaches {abs(answer['fourth.port.effort']).max():.3f} V")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
