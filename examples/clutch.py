"""A spinning flywheel drags another one along through a slipping clutch.

Momentum is what they share: both end at J_1 w / (J_1 + J_2). Energy is not kept: whatever the clutch and however it
is engaged, the heat is half the reduced inertia times the square of the first difference of speeds. The friction is
smoothed over a width of 0.1 rad/s and carries torque by creeping a little.
"""

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia, SlippingClutch


class ClutchEngagement(pm.Component):
    """Two flywheels and a clutch."""

    normal_force = pm.Input("N")

    driving = RotatingInertia(inertia=0.2, start_speed=100.0)
    clutch = SlippingClutch(friction=0.3, mean_radius=0.1, faces=2.0)
    driven = RotatingInertia(inertia=0.3)

    connections = (
        pm.connect(normal_force, clutch.normal_force),
        pm.connect(driving.shaft, clutch.a),
        pm.connect(clutch.b, driven.shaft),
    )


OUTPUTS = ("driving.shaft.flow", "driven.shaft.flow")


def scenario() -> pm.Scenario:
    """The clutch closes within half a second."""
    force = pm.table_values([[0.0, 0.5, 2.0]], [0.0, 500.0, 500.0])
    return pm.Scenario(name="engagement", stop=1.5, inputs={"normal_force": force})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=0.01)


if __name__ == "__main__":
    answer = run(pm.elaborate(ClutchEngagement()))
    balance = pm.energy_balance(answer)
    print(f"both turn at {answer.at_end('driven.shaft.flow'):.2f} rad/s; heat {balance.dissipated:.1f} J")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
