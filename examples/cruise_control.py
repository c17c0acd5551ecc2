"""A sampled controller keeps a car's speed on a hill.

Controllers see signals and give signals: a sensor takes no power, an actuator is a source that a signal modulates.
The controller's step runs once a period and holds its output in between; the physics between samples is continuous,
and the integrator never steps over a sample.
"""

import propermodel as pm
from propermodel.library.control import SampledPID
from propermodel.library.mechanics.translation import ForceSource, Mass, QuadraticDrag


class CruiseControl(pm.Component):
    """A car with air drag; the scenario gives the force of the hill, the controller that of the engine."""

    wanted = pm.Input("m/s")
    hill_force = pm.Input("N")

    car = Mass(mass=1400.0, start_velocity=25.0)
    drag = QuadraticDrag(drag_area=0.7)
    hill = ForceSource()
    engine = ForceSource()
    controller = SampledPID(period=0.1, proportional_gain=0.4, integral_gain=0.1)

    connections = (
        pm.connect(car.flange, drag.flange, hill.flange, engine.flange),
        pm.connect(wanted / pm.quantity(1.0, "m/s"), controller.setpoint),
        pm.connect(car.flange.flow / pm.quantity(1.0, "m/s"), controller.measurement),
        pm.connect(pm.quantity(4000.0, "N") * controller.command, engine.force),
        pm.connect(hill_force, hill.force),
    )


OUTPUTS = ("car.flange.flow", "engine.force")


def scenario() -> pm.Scenario:
    """A slope of 5 % begins after ten seconds."""
    slope = pm.table_values([[0.0, 10.0, 12.0, 99.0]], [0.0, 0.0, -686.5, -686.5])
    return pm.Scenario(name="hill", stop=40.0, inputs={"wanted": 25.0, "hill_force": slope})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.01, record_every=0.1)


if __name__ == "__main__":
    answer = run(pm.elaborate(CruiseControl()))
    speed = answer["car.flange.flow"]
    print(f"the speed falls to {speed.min():.2f} m/s and returns to {speed[-1]:.2f} m/s")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
