"""What heats or cools from outside."""

from __future__ import annotations

from propermodel.expressions import Expr
from propermodel.modelling import EffortSource, FlowSource, Input, Parameter, Port, PseudoThermal, parameter


class FixedTemperature(EffortSource):
    """Surroundings of one temperature."""

    port = Port(PseudoThermal)
    temperature: Parameter = parameter("K", default=293.15, low=0.0)

    def effort(self) -> Expr:
        return self.temperature


class PrescribedTemperature(EffortSource):
    """A prescribed absolute temperature."""

    port = Port(PseudoThermal)
    temperature = Input("K")

    def effort(self) -> Expr:
        return self.temperature


class PrescribedHeatFlow(FlowSource):
    """A prescribed heat flow into whatever is connected."""

    port = Port(PseudoThermal)
    heat_flow = Input("W")

    def flow(self) -> Expr:
        return -self.heat_flow
