"""An engine starts to pull, and the driveline rings.

Engine, gearbox and wheels are three inertias with two shafts between them. The stiff shaft rings fast and carries
little, the soft one decides what the driver feels; activity shows it, and a proper model for that question has one
shaft.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import (
    RotatingInertia,
    RotationalSpringDamper,
    TorqueSource,
    ViscousFriction,
)


class Driveline(pm.Component):
    """Three inertias, two shafts, and the drag of the road."""

    torque = pm.Input("N.m")

    pull = TorqueSource()
    engine = RotatingInertia(inertia=0.25)
    input_shaft = RotationalSpringDamper(stiffness=1.0e5, damping=5.0)
    gearbox = RotatingInertia(inertia=0.05)
    half_shafts = RotationalSpringDamper(stiffness=5.0e3, damping=10.0)
    wheels = RotatingInertia(inertia=5.0)
    drag = ViscousFriction(damping=0.5)

    connections = (
        pm.connect(torque, pull.torque),
        pm.connect(pull.shaft, engine.shaft, input_shaft.a),
        pm.connect(input_shaft.b, gearbox.shaft, half_shafts.a),
        pm.connect(half_shafts.b, wheels.shaft, drag.shaft),
    )


OUTPUTS = ("engine.shaft.flow", "wheels.shaft.flow")


def scenario() -> pm.Scenario:
    """A hundred newton metres, at once."""
    return pm.Scenario(name="tip in", stop=1.0, inputs={"torque": 100.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=2e-3)


if __name__ == "__main__":
    answer = run(pm.elaborate(Driveline()))
    print(f"the half shafts carry up to {answer['half_shafts.spring.port.effort'].max():.1f} N.m")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
