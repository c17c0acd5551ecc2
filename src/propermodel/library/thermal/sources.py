"""What heats from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Input, Parameter, Port, Thermal, parameter


class Ambient(EffortSource):
    """Surroundings at ambient temperature."""

    port = Port(Thermal)

    def effort(self) -> ExprLike:
        return 0.0


class TemperatureSource(EffortSource):
    """A prescribed temperature, given above ambient."""

    port = Port(Thermal)
    temperature = Input("K")

    def effort(self) -> Expr:
        return self.temperature


class HeatSource(FlowSource):
    """A prescribed entropy flow into whatever is connected."""

    port = Port(Thermal)
    entropy_flow = Input("W/K")

    def flow(self) -> Expr:
        return -self.entropy_flow


class HeatFlowSource(FlowSource):
    """A prescribed heat flow into whatever is connected; its entropy follows from the temperature that it meets."""

    port = Port(Thermal)
    heat_flow = Input("W")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def flow(self) -> Expr:
        return -self.heat_flow / (self.port.effort + self.ambient_temperature)


class FixedTemperature(EffortSource):
    """An absolute temperature that is always the same."""

    port = Port(Thermal)
    temperature: Parameter = parameter("K", low=0.0)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def effort(self) -> Expr:
        return self.temperature - self.ambient_temperature


class ConstantHeatFlow(FlowSource):
    """A heat flow into whatever is connected that is always the same."""

    port = Port(Thermal)
    heat_flow: Parameter = parameter("W")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)

    def flow(self) -> Expr:
        return -self.heat_flow / (self.port.effort + self.ambient_temperature)
