"""Sensors of temperature, heat flow and heat; they take no heat."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    FlowSource,
    Input,
    Output,
    Parameter,
    Port,
    PseudoThermal,
    SignalBlock,
    State,
    connect,
    parameter,
)


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


class HeatCounter(SignalBlock):
    """The heat that a flow has carried."""

    heat_flow = Input("W")
    heat = Output("J")
    start: Parameter = parameter("J", default=0.0)
    passed = State("J", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.heat: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.heat_flow}


class HeatSensor(Component):
    """The heat that has passed from port `a` to port `b`, and the heat flow."""

    a = Port(PseudoThermal)
    b = Port(PseudoThermal)
    start: Parameter = parameter("J", default=0.0, doc="heat at the start")
    heat = Output("J")
    heat_flow = Output("W")

    meter = NoDrop()
    counter = HeatCounter(start=start)

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, heat_flow, counter.heat_flow),
        connect(counter.heat, heat),
    )
