"""A planetary gear adds two speeds: the power split of a hybrid car.

Sun, carrier and ring obey w_carrier (1 + z) = w_sun + z w_ring, a 0-junction between two transformers. Three
inertias hang on it and only two speeds are free, so one of the storages depends on the other two; its inertia acts
on both.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import PlanetaryGear, RotatingInertia, TorqueSource


class HybridSplit(pm.Component):
    """A generator on the sun, an engine on the carrier, the wheels on the ring."""

    engine_torque = pm.Input("N.m")
    generator_torque = pm.Input("N.m")

    engine = TorqueSource()
    generator = TorqueSource()
    gear = PlanetaryGear(ratio=2.6)
    generator_rotor = RotatingInertia(inertia=0.02)
    crankshaft = RotatingInertia(inertia=0.2)
    wheels = RotatingInertia(inertia=8.0)

    connections = (
        pm.connect(engine_torque, engine.torque),
        pm.connect(generator_torque, generator.torque),
        pm.connect(engine.shaft, crankshaft.shaft, gear.carrier),
        pm.connect(generator.shaft, generator_rotor.shaft, gear.sun),
        pm.connect(gear.ring, wheels.shaft),
    )


OUTPUTS = ("generator_rotor.shaft.flow", "crankshaft.shaft.flow", "wheels.shaft.flow")


def scenario() -> pm.Scenario:
    """The engine pulls while the generator brakes."""
    return pm.Scenario(name="pull away", stop=2.0, inputs={"engine_torque": 80.0, "generator_torque": -20.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-3, record_every=0.02)


if __name__ == "__main__":
    answer = run(pm.elaborate(HybridSplit()))
    for name in ("generator_rotor", "crankshaft", "wheels"):
        print(f"{name}: {answer.at_end(f'{name}.shaft.flow'):.2f} rad/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
