"""Sensors of temperature and heat flow; they take no heat."""

from __future__ import annotations

from propermodel.expressions import ExprLike
from propermodel.modelling import Component, EffortSource, FlowSource, Output, Port, PseudoThermal, connect


class NoHeat(FlowSource):
    """Feels a temperature without taking heat."""

    port = Port(PseudoThermal)

    def flow(self) -> ExprLike:
        return 0.0


class TemperatureSensor(Component):
    """The absolute temperature of a node."""

    port = Port(PseudoThermal)
    temperature = Output("K")

    touch = NoHeat()

    connections = (
        connect(port, touch.port),
        connect(touch.port.effort, temperature),
    )


class NoDrop(EffortSource):
    """Lets heat pass without a difference of temperature."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    port = Port(PseudoThermal, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class HeatFlowSensor(Component):
    """The heat flow from port `a` to port `b`."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    heat_flow = Output("W")

    meter = NoDrop()

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, heat_flow),
    )
