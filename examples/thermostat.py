"""A thermostat switches a heater on and off: a relay with hysteresis.

Between its two thresholds the relay does what it did before, so it must remember: `is_on` is a `Discrete` value that
two events change. They happen at the instant at which the temperature crosses a threshold, not at the end of the step
in which it did, so a long step and a short one switch at the same times.
"""

import propermodel as pm
from propermodel.library.thermal import HeatCapacity, HeatSource, WallConductance


class Thermostat(pm.SignalBlock):
    """Asks for heat below one temperature until another one is reached."""

    temperature = pm.Input("K")
    heat = pm.Output("W")
    power: pm.Parameter = pm.parameter("W", low=0.0)
    low: pm.Parameter = pm.parameter("K")
    high: pm.Parameter = pm.parameter("K")
    is_on = pm.Discrete("1")

    def outputs(self):
        return {self.heat: self.is_on * self.power}

    def events(self):
        return (
            pm.when(self.temperature > self.high, {self.is_on: 0.0}),
            pm.when(self.temperature < self.low, {self.is_on: 1.0}),
        )


class HeatedRoom(pm.Component):
    """A room that loses heat to a cold day; the sensor tells its temperature above that of the day."""

    day: pm.Parameter = pm.parameter("K", default=280.0, low=0.0)

    thermostat = Thermostat(power=2000.0, low=12.5, high=13.5)
    heater = HeatSource()
    room = HeatCapacity(capacity=1.0e5, ambient_temperature=day, start_temperature=day)
    walls = WallConductance(conductance=60.0, ambient_temperature=day)

    connections = (
        pm.connect(room.port.effort, thermostat.temperature),
        pm.connect(thermostat.heat / (room.port.effort + day), heater.entropy_flow),
        pm.connect(heater.port, room.port, walls.port),
    )


OUTPUTS = ("room.port.effort", "thermostat.heat")


def scenario() -> pm.Scenario:
    """The heater finds a cold room."""
    return pm.Scenario(name="warming up", stop=2400.0)


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=10.0, record_every=10.0)


if __name__ == "__main__":
    answer = run(pm.elaborate(HeatedRoom()))
    print("switched at " + ", ".join(f"{event.time:.1f}" for event in answer.events[:7]) + ", ... s")
    warm = answer.time > 900.0
    print(f"then the room stays above {answer['room.port.effort'][warm].min():.3f} K")
    print(pm.energy_balance(answer))
