"""A counterflow heat exchanger: hot water heats cold water through a wall.

Heat is a true bond here: temperature above ambient times entropy flow. A wall is a resistance with two ports that
makes entropy. A stream carries heat one way only, whatever happens behind it: an activated bond, a signal that
tells each cell the temperature of the one before it.
"""

from itertools import pairwise

import propermodel as pm
from propermodel.library.thermal import Conduction, HeatCapacity


class Stream(pm.Resistance):
    """Water that enters a cell at another temperature and leaves at that of the cell: Q = c m' (T - T_in)."""

    port = pm.Port(pm.Thermal)
    inlet = pm.Input("K")
    capacity_rate: pm.Parameter = pm.parameter("W/K", low=0.0, doc="heat capacity times mass flow")
    ambient_temperature: pm.Parameter = pm.parameter("K", default=300.0, low=0.0)

    def flow(self, effort: pm.Expr) -> pm.Expr:
        return self.capacity_rate * (effort - self.inlet) / (effort + self.ambient_temperature)


class Cell(pm.Component):
    """A length of the exchanger; temperatures count from ambient."""

    hot_inlet = pm.Input("K")
    cold_inlet = pm.Input("K")
    hot_outlet = pm.Output("K")
    cold_outlet = pm.Output("K")

    hot = HeatCapacity(capacity=400.0)
    cold = HeatCapacity(capacity=400.0)
    hot_stream = Stream(capacity_rate=400.0)
    cold_stream = Stream(capacity_rate=800.0)
    wall = Conduction(conductance=60.0)

    connections = (
        pm.connect(hot.port, hot_stream.port, wall.a),
        pm.connect(cold.port, cold_stream.port, wall.b),
        pm.connect(hot_inlet, hot_stream.inlet),
        pm.connect(cold_inlet, cold_stream.inlet),
        pm.connect(hot.port.effort, hot_outlet),
        pm.connect(cold.port.effort, cold_outlet),
    )


class CounterflowExchanger(pm.Component):
    """Ten cells; the hot water enters the first, the cold water the last."""

    hot_inlet = pm.Input("K")
    cold_inlet = pm.Input("K")

    cells = pm.repeat(10, Cell())

    connections = (
        pm.connect(hot_inlet, cells[0].hot_inlet),
        pm.connect(cold_inlet, cells[9].cold_inlet),
        *(pm.connect(before.hot_outlet, after.hot_inlet) for before, after in pairwise(cells)),
        *(pm.connect(after.cold_outlet, before.cold_inlet) for before, after in pairwise(cells)),
    )


OUTPUTS = ("cells[9].hot_outlet", "cells[0].cold_outlet")


def scenario() -> pm.Scenario:
    """Water at 60 K and at 0 K above ambient, from a cold start."""
    return pm.Scenario(name="warming up", stop=60.0, inputs={"hot_inlet": 60.0, "cold_inlet": 0.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=0.02, record_every=0.5)


if __name__ == "__main__":
    answer = run(pm.elaborate(CounterflowExchanger()))
    print(
        f"the hot water leaves at {answer.at_end('cells[9].hot_outlet'):.2f} K, the cold at "
        f"{answer.at_end('cells[0].cold_outlet'):.2f} K above ambient"
    )
    print(pm.energy_balance(answer))
