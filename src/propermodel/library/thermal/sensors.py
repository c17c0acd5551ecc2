"""Sensors of temperature; they take no heat."""

from __future__ import annotations

from propermodel.expressions import ExprLike
from propermodel.modelling import Component, FlowSource, Output, Parameter, Port, Thermal, connect, parameter


class NoHeat(FlowSource):
    """Feels a temperature without taking heat."""

    port = Port(Thermal)

    def flow(self) -> ExprLike:
        return 0.0


class TemperatureSensor(Component):
    """The absolute temperature of a node."""

    port = Port(Thermal)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    temperature = Output("K")

    touch = NoHeat()

    connections = (
        connect(port, touch.port),
        connect(touch.port.effort + ambient_temperature, temperature),
    )
